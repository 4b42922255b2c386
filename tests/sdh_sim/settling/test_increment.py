"""Increments of a quasi-static motion against closed forms: blocks, pinches, pegs, patches."""

from __future__ import annotations

import math

import numpy as np
import pytest

import graspq as gq
from sdh_sim.settling.increment import Contacts, Increment, Springs, solve_increment

WEIGHT = 9.81  # [N]
STIFFNESS = 1e4  # of contacts [N/m]
VISCOSITY = 100.0  # [N/m]


class Bodies:
    """A small system whose contacts keep their points and normals, advanced by increments.

    Attributes:
        at: coordinates so far (n,) [m or rad].
        last: the last increment.
    """

    def __init__(
        self, contacts: Contacts, springs: Springs | None = None, reach: tuple[float, ...] = ()
    ) -> None:
        n = contacts.jacobian.shape[2]
        self.reach = np.array(reach or (1.0,) * n)
        nothing = np.zeros(0)
        self.contacts = contacts
        self.springs = springs or Springs(np.zeros((0, n)), nothing, nothing, nothing, nothing)
        self.at = np.zeros(n)
        self.last: Increment | None = None

    def advance(self, load: object, times: int = 1, longest: float = math.inf) -> Increment:
        """Increments under the same load (n,) [N or N m]; the last of them."""
        for _ in range(times):
            found = solve_increment(
                self.contacts, self.springs, np.asarray(load, dtype=float),
                VISCOSITY * self.reach**2, self.reach, longest,
            )  # fmt: skip
            moved = self.contacts.jacobian @ found.motion
            approach = (moved * self.contacts.normal).sum(axis=1)
            self.contacts = self.contacts._replace(
                gap=self.contacts.gap + approach, carried=found.tangential
            )
            relaxed = self.springs.stiffness * (self.springs.rows @ found.motion)
            self.springs = self.springs._replace(force=self.springs.force - relaxed)
            self.at += found.motion
            self.last = found
        assert self.last is not None
        return self.last


def contacts(jacobian: object, normal: object, friction: float, gap: object = 0.0) -> Contacts:
    rows = np.atleast_2d(np.asarray(normal, dtype=float))
    count = len(rows)
    return Contacts(
        np.asarray(jacobian, dtype=float).reshape(count, 3, -1),
        rows,
        np.broadcast_to(np.asarray(gap, dtype=float), count).copy(),
        np.full(count, STIFFNESS),
        np.full(count, friction),
        np.zeros((count, 3)),
    )


def incline(angle: float, friction: float) -> tuple[Bodies, np.ndarray, np.ndarray]:
    """A block that moves without turning on a slope; its weight, and the way down."""
    normal = np.array([math.sin(angle), 0.0, math.cos(angle)])
    down = np.array([math.cos(angle), 0.0, -math.sin(angle)])
    gap = -WEIGHT * math.cos(angle) / STIFFNESS  # it bears the weight already
    block = Bodies(contacts(np.eye(3), normal, friction, gap))
    return block, np.array([0.0, 0.0, -WEIGHT]), down


@pytest.mark.parametrize("degrees", [5.0, 20.0, 35.0])
def test_a_block_sticks_up_to_the_angle_of_friction_and_does_not_creep(degrees):
    angle = math.radians(degrees)
    block, weight, down = incline(angle, math.tan(angle) * 1.001)
    block.advance(weight, 50)
    elastic = WEIGHT * math.sin(angle) / STIFFNESS
    assert block.at @ down == pytest.approx(elastic, rel=1e-3)
    before = block.at.copy()
    block.advance(weight, 1000)
    assert np.abs(block.at - before).max() < 1e-8


@pytest.mark.parametrize("degrees", [5.0, 20.0, 35.0])
def test_a_block_slides_beyond_the_angle_of_friction(degrees):
    angle = math.radians(degrees)
    friction = 0.9 * math.tan(angle)
    block, weight, down = incline(angle, friction)
    found = block.advance(weight, 50)
    drive = WEIGHT * (math.sin(angle) - friction * math.cos(angle))
    assert found.motion @ down == pytest.approx(drive / VISCOSITY, rel=1e-3)
    assert np.linalg.norm(found.tangential) == pytest.approx(friction * found.normal[0], rel=1e-6)


def test_a_long_way_is_gone_in_short_increments_with_all_forces_in_balance():
    block, weight, _ = incline(math.radians(35.0), 0.2)
    found = block.advance(weight, 1, longest=1e-3)
    assert np.abs(found.motion).max() <= 1e-3
    assert found.factor > 1.0
    normal = block.contacts.normal[0]
    force = found.normal[0] * normal + found.tangential[0] + weight
    assert force == pytest.approx(found.factor * VISCOSITY * found.motion, abs=1e-3 * WEIGHT)


def test_a_pinch_moves_until_the_other_finger_bears_what_the_saturated_one_does():
    # Along x: coordinates of the object, of a finger to its left and of one to its right. The left
    # motor pushes with its limit of 5 N, the right one is a position servo that pushes with 8 N.
    limit, pushed, servo = 5.0, 8.0, 1000.0
    jacobian = np.zeros((2, 3, 3))
    jacobian[0, 0], jacobian[1, 0] = (1.0, -1.0, 0.0), (1.0, 0.0, -1.0)  # object less finger
    gaps = [-limit / STIFFNESS, -pushed / STIFFNESS]
    touch = contacts(jacobian, [(1, 0, 0), (-1, 0, 0)], 0.5, gaps)
    rows = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    springs = Springs(
        rows, np.array([10.0, -pushed]), np.array([servo, servo]), np.array([-limit, -10.0]),
        np.array([limit, 10.0]),
    )  # fmt: skip
    hand = Bodies(touch, springs)
    found = hand.advance(np.zeros(3), 200, longest=1e-3)
    assert found.normal == pytest.approx([limit, limit], rel=1e-4)
    finger = -(pushed - limit) / servo
    squeezed = (pushed - limit) / STIFFNESS  # by which the rubber on the right relaxes
    assert hand.at[2] == pytest.approx(finger, rel=1e-3)
    assert hand.at[0] == pytest.approx(finger - squeezed, rel=1e-3)


def peg_on_springs() -> Bodies:
    """A peg that lies on two springs at ±10 mm; coordinates: height and tilt."""
    half = 0.01
    jacobian = np.zeros((2, 3, 2))
    jacobian[:, 2, 0], jacobian[:, 2, 1] = 1.0, (-half, half)
    return Bodies(contacts(jacobian, [(0, 0, 1), (0, 0, 1)], 0.0), reach=(1.0, half))


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9])
def test_a_peg_on_two_springs_sinks_and_tilts(share):
    half, eccentricity = 0.01, 0.01 * share
    peg = peg_on_springs()
    load = (-WEIGHT, -WEIGHT * eccentricity)
    found = peg.advance(load, 50)
    assert found.normal == pytest.approx(
        [WEIGHT / 2 * (1 - share), WEIGHT / 2 * (1 + share)], rel=1e-3
    )
    assert peg.at[0] == pytest.approx(-WEIGHT / (2 * STIFFNESS), rel=1e-3)
    tilt = WEIGHT * eccentricity / (2 * STIFFNESS * half**2)
    assert -peg.at[1] == pytest.approx(tilt, rel=1e-3, abs=1e-9)


def test_a_peg_loaded_outside_its_springs_tips_over():
    peg = peg_on_springs()
    load = (-WEIGHT, -WEIGHT * 0.012)
    found = peg.advance(load, 50)
    assert found.normal == pytest.approx([0.0, WEIGHT * 1.1], rel=0.1)
    before = peg.at[1]
    found = peg.advance(load, 10)
    assert peg.at[1] - before == pytest.approx(10 * found.motion[1], rel=1e-2)
    assert found.motion[1] * 0.01 < -1e-4  # and goes on


def test_torsion_of_a_patch_ends_at_equation_7():
    rng = np.random.default_rng(7)
    taxels = np.column_stack((rng.uniform(-0.01, 0.01, (20, 2)), np.zeros(20)))
    pressures = rng.uniform(0.2, 2.0, 20)
    centre = pressures @ taxels / pressures.sum()
    friction = 0.6
    limit = gq.max_torsion(friction, pressures.sum(), pressures, taxels, centre)
    arms = np.cross((0.0, 0.0, 1.0), taxels - centre)
    normals = np.tile((0.0, 0.0, 1.0), (20, 1))
    touch = contacts(arms[:, :, None], normals, friction, -pressures / STIFFNESS)
    reach = 0.01
    patch = Bodies(touch, reach=(reach,))
    patch.advance((0.98 * limit,), 300)
    before = patch.at[0]
    patch.advance((0.98 * limit,), 300)
    assert patch.at[0] - before < 1e-6  # it stays
    found = patch.advance((1.02 * limit,), 300)
    resisted = float(np.einsum("ci,ci->", found.tangential, arms))
    assert -resisted == pytest.approx(limit, rel=1e-3)
    assert found.motion[0] == pytest.approx(0.02 * limit / (VISCOSITY * reach**2), rel=2e-2)
