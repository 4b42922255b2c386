"""The field's metrics against the numbers of their authors' code.

What was run, on the contacts of ``tests/support/field_contacts.py``:

- DexGraspBench at 1e7a5a6 (``fc_metric``), friction 0.3 and torsion 0.01 m, normals into the
  object. Q1 with the edges' angles in double precision (single precision there: up to 1e-7 in Q1),
  TDG with this library's 1000 directions, and Clarabel with the tolerance 1e-13 (its own there: up
  to 2e-6).
- FRoGGeR at f91157f (``min_weight_lp``) on its own wrenches, friction 0.5, 4 edges.
- GraspQP at 744ffbc with SciPy's solver (method bvls, tolerance 1e-15), friction 0.2, double
  precision. Its singular map of two contacts gives a sixth root of round-off; not compared.
- Dex-Net at cccf933 (``quality.py``) on FRoGGeR's wrenches with moments over 0.05 m.
"""

from __future__ import annotations

import numpy as np
import pytest

import graspq as gq
from tests.support.field_contacts import field_contacts

NAMES = ("pair", "cube", "ellipsoid_3", "ellipsoid_4", "ellipsoid_6", "one_side")
DFC = (0.0, 0.0, 0.450963122414579, 1.13035966754323, 1.38061732199423, 2.59885400137580)
Q1 = (2.0, 1.75506082328875, 1.97565152580847, 2.0, 1.91181231361608, 2.0)
TDG = (
    *(0.0163917212046319, 0.00212968501029787, 0.0969179391448263),
    *(0.225509580624643, 0.162444700670297, 0.715365733026039),
)
QP = (0.0, 0.0, 0.0, 0.00284944644373005, 0.0, 0.574159663051297)
QP_DFC = (0.0, 0.0, 0.0, 0.00227991529848302, 0.0, 0.571246762805717)
SPAN_AXES = (
    *(None, 0.0197996357484240, 0.241198254689426),
    *(0.426710463271634, 0.101315036557493, 0.836377866841929),
)
SPAN_ZERO = (
    *(None, 0.0197996357484240, 0.0275900793282877),
    *(0.396531736523690, 0.0524661722005320, 6.09464718608025),
)
WEIGHT = (
    *(0.125, 0.0416666666666667, 0.0383548993900554),
    *(0.00385552047381056, 0.0186762332898804, -0.162447384861642),
)
# Smallest singular value, square root of the volume, isotropy.
DEX_NET = (
    (0.0, 0.0, 0.0),
    (0.632455532033676, 2.39255804995395, 0.223606797749979),
    (0.478767758163538, 1.23218168203858, 0.193122751011174),
    (0.657794747910201, 2.44574936896612, 0.221497300479016),
    (1.05245517465241, 6.34557701209086, 0.316243136009817),
    (0.0798817172243073, 0.469868822338678, 0.0288415814213577),
)


def grasps(values):
    """For each grasp with a value, its contacts and the value."""
    made = field_contacts()
    return [(*made[n], v) for n, v in zip(NAMES, values, strict=True) if v is not None]


def edge_wrenches(positions: np.ndarray, normals: np.ndarray) -> list[np.ndarray]:
    """Wrenches of four cone edges of unit length for every contact, as FRoGGeR lays them."""
    sets = []
    for place, normal in zip(positions, normals, strict=True):
        first = np.array([1.2, 2.3, 3.4])
        first -= (first @ normal) * normal
        first /= np.linalg.norm(first)
        second = np.cross(normal, first)
        sides = 0.5 * np.array([first, second, -first, -second])
        forces = (normal + sides) / np.sqrt(1.25)
        sets.append(np.vstack([forces.T, np.cross(place, forces).T]))
    return sets


@pytest.mark.parametrize(
    ("function", "values"),
    [
        (gq.dfc_residual, DFC),
        (lambda p, n: gq.dexgraspbench_q1(p, n, 0.3), Q1),
        (lambda p, n: gq.tdg_loss(p, n, 0.3), TDG),
        (lambda p, n: gq.qp_residual(p, n, 0.3, 0.01), QP),
        (lambda p, n: gq.qp_dfc_residual(p, n, 0.3, 0.01), QP_DFC),
        (lambda p, n: gq.span_loss(p, n, 0.2, targets="axes"), SPAN_AXES),
        (lambda p, n: gq.span_loss(p, n, 0.2, targets="zero"), SPAN_ZERO),
        (lambda p, n: gq.minimum_weight(edge_wrenches(p, n)), WEIGHT),
    ],
    ids=["dfc", "q1", "tdg", "qp", "qp_dfc", "span_axes", "span_zero", "minimum_weight"],
)
def test_values_are_those_of_the_authors_code(function, values):
    for positions, normals, value in grasps(values):
        assert function(positions, normals) == pytest.approx(value, rel=1e-9, abs=1e-9)


def test_singular_values_are_those_of_dex_net():
    for positions, normals, (smallest, root, ratio) in grasps(DEX_NET):
        edges = np.hstack(edge_wrenches(positions, normals))
        edges[3:] /= 0.05
        assert gq.smallest_singular_value(edges) == pytest.approx(smallest, rel=1e-9, abs=1e-12)
        assert gq.ellipsoid_volume(edges) == pytest.approx(root**2, rel=1e-9, abs=1e-12)
        assert gq.isotropy(edges) == pytest.approx(ratio, rel=1e-9, abs=1e-12)


def test_epsilon_is_that_of_froggers_hull():
    # 0.00751441266681426 and so on: its ferrari_canny_L1 with the same wrenches.
    values = (None, 0.00751441266681426, 0.00336612546300454, 0.000642823570474174,
              0.00731514476005050, 0.0)  # fmt: skip
    for positions, normals, value in grasps(values):
        found = gq.epsilon(edge_wrenches(positions, normals), "l1", unloading=False)
        assert found == pytest.approx(value, rel=1e-9)
