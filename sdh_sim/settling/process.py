"""What a grasp does when the table lets go, predicted from the snapshot alone.

Four steps, each a sequence of increments (``quasi_static``):

1. *Grip*: with the object where it was perceived, the hand moves until its contacts balance the
   measured motor torques. This takes in what is inconsistent between pose, posture and torques.
   The servos' references are then where they exert these torques; motors at their limit push on
   beyond it, by ``DEMAND`` times the limit.
2. *Lift*: the object is free, its weight acts, and the table's plane goes down from its lowest
   point, as it does for the hand that rises.
3. *Rest*: until nothing moves and the table bears nothing.
4. *Verdict*: how far the object came in the hand; then a load ramp (``load_ramp``).

Passive stability of grasps: Haas-Heger, Iyengar, Ciocarlie: Passive reaction analysis for grasp
stability, IEEE T-ASE, 2018; Haas-Heger, Papalexandrou, Ciocarlie: Accurate energetic constraints
for passive grasp stability analysis, IEEE T-RO, 2020. They ask whether rigid contacts and joints
that resist without limit have an equilibrium; here both give way, and the way there is followed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from sdh_sim import poses
from sdh_sim.poses import rotation_of
from sdh_sim.sensing import GRAVITY, TactileSnapshot, directions_of, unit_vector
from sdh_sim.settling.grasp_model import GraspModel, grasp_model
from sdh_sim.settling.quasi_static import LONGEST, Laws, QuasiStatic, State

if TYPE_CHECKING:
    from sdh_sim.robot import HandKinematics
    from sdh_sim.sensing import PerceivedGrasp

DEMAND = 1.1  # torque that a saturated motor's reference asks for, over its limit
SATURATED = 0.95  # share of its limit from which on a motor counts as saturated
STEP = 0.5e-3  # of the table per increment [m]
GRIP_STEPS, LIFT_STEPS = 20, 120  # increments at most
GRIPPED, STILL = 2e-5, 1e-5  # at rest: no increment moves anything as far [m]
QUIET = 3  # increments at rest that end a step
WEIGHT_STEPS = 10  # increments in which the weight grows where there is no table


class Rubber(NamedTuple):
    """What the pads are known to be made of.

    Attributes:
        modulus: Young's [Pa].
        thickness: [m].
    """

    modulus: float
    thickness: float


class Allowed(NamedTuple):
    """Motion in the hand up to which a grasp counts as holding.

    Attributes:
        displacement_mm, rotation_deg: at most.
    """

    displacement_mm: float = 10.0
    rotation_deg: float = 10.0

    def exceeded_by(self, motion: tuple[float, float]) -> bool:
        """Whether a motion [mm, deg] goes further, in either way."""
        return motion[0] > self.displacement_mm or motion[1] > self.rotation_deg


ALLOWED = Allowed()
GONE = Allowed(20.0, 20.0)  # beyond that an object is not followed


@dataclass(frozen=True)
class Settling:
    """Where a grasp came to rest, or how far it was followed.

    Attributes:
        displacement_mm: of the object's centre of mass in the hand [mm].
        rotation_deg: of the object in the hand [deg].
        at_rest: nothing moved at the end and the table bore nothing.
        held: at rest, within what is allowed.
        state: the last state.
        gripped: the state before the lift.
        process: what it was advanced with.
    """

    displacement_mm: float
    rotation_deg: float
    at_rest: bool
    held: bool
    state: State
    gripped: State
    process: Process


class Process:
    """The way of one grasp under a weight in one direction.

    Args:
        grasp: as perceived.
        kinematics: of the hand.
        rubber: of the pads.
        down: direction of the weight in the palm frame (3,).
        step: of the table in one increment [m]; motions are cut in proportion.
        frozen: as ``QuasiStatic`` takes it.
    """

    def __init__(
        self,
        grasp: PerceivedGrasp,
        kinematics: HandKinematics,
        rubber: Rubber,
        down: np.ndarray,
        step: float = STEP,
        frozen: bool = False,
    ) -> None:
        self.grasp, self._step = grasp, step
        self.model: GraspModel = grasp_model(kinematics.hand, grasp.obj)
        snapshot = grasp.snapshot
        joints = snapshot.joints
        if joints is None:
            joints = kinematics.joint_positions(snapshot.joint_angles)
        self._first = self.model.pose(joints, snapshot.object_pose_hand)
        palm = self.model.data.xmat[self.model.palm].reshape(3, 3)
        laws = Laws(
            stiffness=self.model.contact_stiffness(*rubber),
            friction=grasp.obj.friction,
            torque_limits=grasp.torque_limits,
            down=palm @ down,
            weight=grasp.obj.mass_kg * GRAVITY,
            centre=grasp.obj.com_m,
        )
        self.laws = laws
        self._quasi_static = QuasiStatic(self.model, laws, LONGEST * step / STEP, frozen)

    def grip(self) -> State:
        """The hand in balance with the measured torques, the object fixed; servos then set."""
        torques = self.grasp.snapshot.motor_torques
        limits = self.laws.torque_limits
        state = self._quasi_static.start(self._first, np.clip(torques, -limits, limits))
        self.model.put_table(-1.0, -self.laws.down)
        for _ in range(GRIP_STEPS):
            state = self._quasi_static.grip(state)
            if state.moved < GRIPPED:
                break
        asked = np.where(np.abs(torques) >= SATURATED * limits, DEMAND * torques, torques)
        return self._quasi_static.release(state, asked)

    def lift(self, state: State) -> tuple[State, bool]:
        """Let the table go down until the object rests in the hand; whether it does."""
        up = -self.laws.down
        height = self.model.lowest(state.qpos, up)
        still = 0
        for _ in range(round(LIFT_STEPS * STEP / self._step)):
            self.model.put_table(height, up)
            state = self._quasi_static.advance(state, 1.0)
            height -= self._step
            still = still + 1 if state.moved < STILL and not state.on_table else 0
            if still >= QUIET:
                return state, True
            if GONE.exceeded_by(self.motion(state)):
                break
        return state, False

    def take_weight(self, state: State) -> tuple[State, bool]:
        """Let the weight grow from nothing, without a table; whether the object comes to rest."""
        self.model.put_table(-1.0, -self.laws.down)
        still = 0
        for k in range(1, round(LIFT_STEPS * STEP / self._step) + 1):
            share = min(1.0, k / WEIGHT_STEPS)
            state = self._quasi_static.advance(state, share)
            still = still + 1 if state.moved < STILL and share == 1.0 else 0
            if still >= QUIET:
                return state, True
            if GONE.exceeded_by(self.motion(state)):
                break
        return state, False

    def advance(self, state: State, load: float) -> State:
        """An increment without a table, under so many times the weight."""
        self.model.put_table(-1.0, -self.laws.down)
        return self._quasi_static.advance(state, load)

    def motion(self, state: State, since: State | None = None) -> tuple[float, float]:
        """How far the object is in the hand from where it was perceived, or since a state.

        Returns:
            displacement of its centre of mass [mm] and rotation [deg].
        """
        at = slice(self.model.object_qpos, self.model.object_qpos + 7)
        before = (self._first if since is None else since.qpos)[at]
        now, centre = state.qpos[at], self.laws.centre
        shift = poses.transform(now, centre) - poses.transform(before, centre)
        return 1e3 * float(np.linalg.norm(shift)), float(
            np.degrees(poses.turn_between(before, now))
        )

    def snapshot(self, state: State) -> TactileSnapshot:
        """What the hand would sense in a state: the pressure itself, no crosstalk, no errors."""
        model, before = self.model, self.grasp.snapshot
        model.look(state.qpos)
        positions = model.moment_arms()[1]
        return replace(
            before,
            tactile=model.readings(state.geoms, state.points, state.normal),
            joint_angles=positions,
            motor_torques=state.torques,
            object_pose_hand=model.object_in_palm(),
            joints=None if before.joints is None else state.qpos[model.hand_qpos],
        )


def weight_directions(snapshot: TactileSnapshot) -> list[np.ndarray]:
    """Directions of the weight in the palm frame, (3,) each, as the snapshot has them."""
    if snapshot.gravity:
        rotation = rotation_of(snapshot.object_pose_hand[3:])
        return [rotation @ unit_vector(name) for name in directions_of(snapshot.gravity)]
    return [rotation_of(snapshot.hand_pose_world[3:]).T @ np.array([0.0, 0.0, -1.0])]


def settle(
    grasp: PerceivedGrasp,
    kinematics: HandKinematics,
    rubber: Rubber,
    allowed: Allowed = ALLOWED,
    down: np.ndarray | None = None,
    step: float = STEP,
    frozen: bool = False,
) -> Settling:
    """Let go of the table.

    Args:
        grasp: as perceived at the snapshot.
        kinematics: of the hand.
        rubber: of the pads.
        allowed: motion up to which the grasp counts as holding.
        down: direction of the weight in the palm frame (3,); None: the first of the snapshot's.
        step, frozen: as ``Process`` takes them.
    """
    if down is None:
        down = weight_directions(grasp.snapshot)[0]
    process = Process(grasp, kinematics, rubber, down, step, frozen)
    gripped = process.grip()
    taken = process.take_weight if grasp.snapshot.gravity else process.lift
    state, at_rest = taken(gripped)
    motion = process.motion(state)
    held = at_rest and not allowed.exceeded_by(motion)
    return Settling(*motion, at_rest, held, state, gripped, process)
