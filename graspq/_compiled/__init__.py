"""The compiled kernel of graspq: q*, ε, V and the motors' bounds, in Numba.

Nothing here is public, and importing a module compiles nothing: an entry is compiled at its first
call and kept on disk (``jit``). Only NumPy and Numba are imported. SI units; a wrench is (force,
moment).

What a body is
--------------
Each contact i can exert a convex set W_i of wrenches: the hull of points, of ellipsoids
``c + A x, |x| <= 1`` and, where the contact may unload, of the origin. A *body* is the Minkowski
sum W = W_1 + ... + W_n of such sets ("linf"), or one set that is the hull of them all ("l1"). A sum
of n sets of l points has up to lⁿ vertices, so it is never formed: everything is asked through the
support function

    h(u) = max over w in W of u·w = Σ_i max over w in W_i of u·w,

which also names a point of W where it is reached. [Ferrari and Canny 1992; Rockafellar 1970, §13]

Ray shooting (q*)
-----------------
How far does W reach along a task t? 1/q = min Σ λ_k with Σ λ_k v_k = t over points v_k of W.

 1. B := six short artificial vectors whose cone contains t.                          [two-phase]
 2. Perturb t a little, so that no ratio ties and no pivot cycles.                  [Charnes 1952]
 3. u := B⁻ᵀ 1, the normal of the plane through the six.
 4. Ask the support function for the point v of W furthest along u, and h(u) = u·v.
 5. Certificate: 1/(u·t) <= q <= h(u)/(u·t).
 6. If h(u) <= 1: the plane holds W, go to 9.
 7. Ratio test: of B⁻¹ v > 0, the vertex with the smallest (B⁻¹ t)_k / (B⁻¹ v)_k leaves.
 8. Pivot v in and go to 3.                                     [Dantzig 1963; column generation]
 9. Weights that are negative for t itself are mended by dual pivots.               [Lemke 1954]
10. Refine, verify the certificate, or try again with another perturbation.

The next task starts from the last basis. Bodies of many columns are asked through a list of
candidates first (partial pricing); from a cold start, smaller polytopes are asked along a direction
between u and the best so far, which takes a quarter fewer pivots. [Wentges 1997]

The largest ball (ε)
--------------------
ε = min h(u) over unit u: the distance of the nearest facet. The incremental hull starts as a tiny
simplex around the origin and is grown at its nearest facet alone, by the support point of that
facet's normal; when that facet supports W it is the nearest of W. [Ferrari and Canny 1992; growing
through the support function: Zheng 2013]

Before that, the body is made about round: a linear map takes the scatter matrix of its points to
the unit matrix. [Kessy, Lewin and Strimmer 2018]

The incremental hull
--------------------
A facet is the plane u·x = 1 through six vertices. A new vertex removes the facets that it sees,
found through neighbours, and joins the ridges of the horizon; a new facet's u is a convex
combination of the two u at its ridge. [Barber, Dobkin and Huhdanpaa 1996]

The Minkowski sum (V)
---------------------
A face of W in direction u is the sum of its sets' faces F_i in direction u, and in general position
the dimensions of a facet's F_i add up to five. So V = (1/6) Σ h(u) vol₅(F_1 + ... + F_n) over the
sums of faces whose normal cones meet in one u. [Schneider 1993; Fukuda 2004]

The bounded simplex (motors)
----------------------------
Where contacts share motors, q is the value of a linear program with bounded variables: primal and
dual pivots on a kept inverse, with cone generators added as they are needed. [Dantzig 1955; Chvátal
1983, chapter 8; Bland 1977; Harris 1973]

The files; each imports from those above it
-------------------------------------------

                                      jit
                                       |
          +----------------------------+------------------------+
          |                            |                        |
    small_matrices                   body                   polytopes
          |                            |                        |
          +-- bounded_simplex          |                   normal_cones
          |          |                 |                        |
          |   shared_motor_reach       |                  minkowski_volume
          |                            |
      workspace                        |
          |                            |
    support_function              body_reading
          |                            |
     +----+-------------+              |
     |                  |              |
   pivots     incremental_hull         |
     |                  |              |
  ray_shooting   inscribed_ball        |
     |                  |              |
     +------------------+--------------+
     |                  |              |
  ray_batch        ball_batch      whitening

Entries, which Python calls: ``ray_batch.shoot_bodies``, ``whitening.whiten_bodies``,
``ball_batch.balls_in_bodies``, ``minkowski_volume.add_facets``, ``shared_motor_reach.reach``.

References
----------
- C. B. Barber, D. P. Dobkin, H. Huhdanpaa: The Quickhull algorithm for convex hulls. ACM
  Transactions on Mathematical Software 22 (1996).
- R. G. Bland: New finite pivoting rules for the simplex method. Mathematics of Operations Research
  2 (1977).
- A. Charnes: Optimality and degeneracy in linear programming. Econometrica 20 (1952).
- V. Chvátal: Linear Programming. Freeman (1983).
- G. B. Dantzig: Upper bounds, secondary constraints, and block triangularity in linear programming.
  Econometrica 23 (1955).
- G. B. Dantzig: Linear Programming and Extensions. Princeton University Press (1963).
- C. Ferrari, J. Canny: Planning optimal grasps. ICRA (1992).
- K. Fukuda: From the zonotope construction to the Minkowski addition of convex polytopes. Journal
  of Symbolic Computation 38 (2004).
- P. M. J. Harris: Pivot selection methods of the Devex LP code. Mathematical Programming 5 (1973).
- A. Kessy, A. Lewin, K. Strimmer: Optimal whitening and decorrelation. The American Statistician 72
  (2018).
- C. E. Lemke: The dual method of solving the linear programming problem. Naval Research Logistics
  Quarterly 1 (1954).
- R. T. Rockafellar: Convex Analysis. Princeton University Press (1970).
- R. Schneider: Convex Bodies: The Brunn-Minkowski Theory. Cambridge University Press (1993).
- P. Wentges: Weighted Dantzig-Wolfe decomposition for linear mixed-integer programming.
  International Transactions in Operational Research 4 (1997).
- Y. Zheng: An efficient algorithm for a grasp quality measure. IEEE Transactions on Robotics 29
  (2013).
"""
