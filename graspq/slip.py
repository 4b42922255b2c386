"""How far contacts stay from slipping when the hand may choose its forces: linear programs.

GraspIt! calls it grasp force optimisation (Miller, Allen: GraspIt!, IEEE Robotics and Automation
Magazine 11(4), 2004); the problem is Kerr and Roth's (Analysis of multifingered hands, Int. J.
Robotics Research 4(4), 1986).

Forces inside a cone are f = Σ x_e (n + μ u_e) + x₀ n with x >= 0 and unit tangents u_e, so that μ
x₀ is friction that is left. Where no such forces bear the task, friction that is not there is
added as y_e μ u_e, y >= 0, as little as possible at the contact that needs most.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from graspq.errors import GraspError
from graspq.hand_bound import HandBound, cones_of, intervals_of
from graspq.inputs import as_tasks

INFEASIBLE, UNBOUNDED = 2, 3  # status of SciPy's linprog


def slip_margin(hand: HandBound, tasks: ArrayLike, edges: int = 12) -> float:
    """Return the least over tasks of max over forces of min over contacts (μ f_n - |f_t|) [N].

    The friction left at the contact that is nearest to slipping, with the forces that leave the
    most; of a patch it is the sum over its points. High is good.

    - above 0: every contact can press and bear its share of every task without slipping;
    - 0: a task needs all friction of some contact, or some contact bears nothing;
    - below 0: no forces inside the friction cones bear some task; friction would have to be larger
      by that much at some contact;
    - -inf: no pushing forces at all do within the motors' limits; inf: the motors limit none.

    A moment of a soft point takes its share: μ f_n - |f_t| - |m| μ ``g*/tau*``.

    So it is at least 0 exactly where ``hand_task_scaling`` with as many edges is at least 1. It
    sees whether the motors can exert such forces, not whether they do, and not by how much the
    task could grow.

    Args:
        hand: contacts and motors.
        tasks: wrenches that the hand must exert, shape (6, t) or (6,) [N, N m], moments about the
            origin of the contacts' frame.
        edges: of the friction cones, inscribed, at least 3; the margin is never too large.

    Raises:
        GraspError: for bad input, or where a linear program cannot be solved.
    """
    if not isinstance(hand, HandBound):
        raise GraspError(f"hand: expected a HandBound, got {type(hand).__name__}")
    if isinstance(edges, bool) or not isinstance(edges, int | np.integer) or edges < 3:
        raise GraspError(f"edges: expected an integer >= 3, got {edges!r}")
    wanted = as_tasks(tasks)
    cones = _cones(hand, int(edges))
    least = math.inf
    for task in wanted.T:
        # Once a task lacks friction, what others have left does not matter.
        least = min(least, _margin(hand, cones, task, lacks=least < 0.0))
        if least == -math.inf:
            break
    return least


class _Cones(NamedTuple):
    """Columns of the programs; rows are the wrench, the motors and the passive motions.

    Attributes:
        inside: of forces inside the cones, the normal ones last (6 + k + u, c).
        left: friction left at each contact per unit of those (n, c).
        added: of friction that is not there (6 + k + u, d).
        lacking: friction added at each contact per unit of those (n, d).
        preloads: of motor torques that load no joint (6 + k + u, r).
    """

    inside: np.ndarray
    left: np.ndarray
    added: np.ndarray
    lacking: np.ndarray
    preloads: np.ndarray


def _cones(hand: HandBound, edges: int) -> _Cones:
    cones, owners = cones_of(hand, np.zeros(3), 1.0)
    angle = 2.0 * np.pi * np.arange(edges) / edges
    sides = np.zeros((edges + 2, 3))
    sides[:edges, 0], sides[:edges, 1] = np.cos(angle), np.sin(angle)
    sides[edges, 2], sides[edges + 1, 2] = 1.0, -1.0
    if not cones[:, :, 3].any():
        sides = sides[:edges]
    normal = cones[:, :, 0]
    added = cones[:, :, 1:] @ sides.T  # (K, rows, sides)
    pushed = normal[:, :, None] + added
    friction = np.array([contact.friction for contact in hand.contacts])
    of_contact = (owners == np.arange(len(friction))[:, None]) * friction[:, None]
    every = np.repeat(of_contact, len(sides), axis=1)

    def flat(stack: np.ndarray) -> np.ndarray:
        return stack.transpose(1, 0, 2).reshape(stack.shape[1], -1)

    loads = cones.shape[1] - 6 - len(hand.torque_limit)
    preloads = np.vstack(
        [np.zeros((6, hand.preloads.shape[1])), -hand.preloads,
         np.zeros((loads, hand.preloads.shape[1]))]
    )  # fmt: skip
    return _Cones(
        inside=np.hstack([flat(pushed), normal.T]),
        left=np.hstack([np.zeros_like(every), of_contact]),
        added=flat(added),
        lacking=every,
        preloads=preloads,
    )


def _margin(hand: HandBound, cones: _Cones, task: np.ndarray, lacks: bool) -> float:
    """The margin of one task; first with the friction that there is, then with more.

    Where some task is known to lack friction, margins above 0 may be given as 0.
    """
    free = cones.preloads.shape[1]
    without = np.zeros((len(cones.left), free))
    found = None
    if not lacks:
        columns = np.hstack([cones.inside, cones.preloads])
        found = _best(hand, columns, np.hstack([-cones.left, without]), free, task)
    if found is not None:
        return max(0.0, found)
    columns = np.hstack([cones.inside, cones.added, cones.preloads])
    needs = np.hstack([np.zeros_like(cones.left), cones.lacking, without])
    found = _best(hand, columns, needs, free, task)
    return -math.inf if found is None else min(0.0, found)


def _best(
    hand: HandBound, columns: np.ndarray, needs: np.ndarray, free: int, task: np.ndarray
) -> float | None:
    """max s with s + needs x <= 0 at every contact, for x that balances the task; None: none does.

    Args:
        hand: for the motors' limits.
        columns: per variable (6 + k + u, c); the last ``free`` of them have no sign.
        needs: friction per variable (n, c) [N/N], below 0 where it is left.
        free: number of variables without a sign.
        task: wrench (6,).
    """
    from scipy.optimize import linprog

    low, high = intervals_of(hand)
    size = float(np.linalg.norm(task))  # the programs are in its units
    tight = low == high  # passive motions, and motors without torque
    balance = np.concatenate([np.ones(6, dtype=bool), tight])
    motors = columns[6:][~tight]
    rows = np.vstack([needs, motors, -motors])
    margin = np.concatenate([np.ones(len(needs)), np.zeros(2 * len(motors))])
    # The margin is bounded from above by what motors allow; where they do not, linprog says so.
    result = linprog(
        np.concatenate([np.zeros(columns.shape[1]), [-1.0]]),
        A_ub=np.hstack([rows, margin[:, None]]),
        b_ub=np.concatenate([np.zeros(len(needs)), high[~tight] / size, -low[~tight] / size]),
        A_eq=np.hstack(
            [np.vstack([columns[:6], columns[6:][tight]]), np.zeros((balance.sum(), 1))]
        ),
        b_eq=np.concatenate([task, low[tight]]) / size,
        bounds=[*[(0.0, None)] * (columns.shape[1] - free), *[(None, None)] * (free + 1)],
        method="highs-ds",
    )
    if result.status == INFEASIBLE:
        return None
    if result.status == UNBOUNDED:
        return math.inf
    if result.x is None:
        raise GraspError(f"slip_margin: the linear program stopped ({result.message})")
    return float(result.x[-1]) * size
