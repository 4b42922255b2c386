"""Everything that settling says of a grasp, and the grasp as it would be perceived afterwards."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from sdh_sim.robot import HandKinematics
from sdh_sim.sensing import PerceivedGrasp, perceive
from sdh_sim.settling.load_ramp import Ramp, load_ramp
from sdh_sim.settling.process import (
    Allowed,
    Process,
    Rubber,
    Settling,
    settle,
    weight_directions,
)
from sdh_sim.settling.quasi_static import State


@dataclass(frozen=True)
class Settled:
    """What settling says of a grasp, under its weight along every direction of its snapshot.

    Attributes:
        displacement_mm, rotation_deg: motion in the hand, at most over the directions.
        held: the grasp settles within what is allowed, under each.
        ramp: where its load ramp ended, the least over the directions.
        ways: each direction's own settling.
        pads: whose readings metrics use.
        kinematics: of the hand.
    """

    displacement_mm: float
    rotation_deg: float
    held: bool
    ramp: Ramp
    ways: tuple[Settling, ...]
    pads: str
    kinematics: HandKinematics

    @property
    def _shown(self) -> tuple[Process, State]:
        """The state to look at, of the only direction of the weight or before any acts."""
        way = self.ways[0]
        return way.process, way.state if len(self.ways) == 1 else way.gripped

    @property
    def object_pose_hand(self) -> np.ndarray:
        """Pose of the object in the palm frame where ``grasp`` is (7,)."""
        process, state = self._shown
        return process.snapshot(state).object_pose_hand

    @cached_property
    def grasp(self) -> PerceivedGrasp:
        """The grasp where it settled, for any metric: contacts, Jacobians, readings, torques.

        Readings are the pressures of the predicted contacts. Of a weight along several directions
        in turn, it is the grasp before any of them acts.
        """
        process, state = self._shown
        before = process.grasp
        limits = self.kinematics.hand.group_limits(before.torque_limits)
        snapshot = process.snapshot(state)
        # No crosstalk lights taxels here, so that all count.
        return perceive(snapshot, before.obj, limits, self.pads, self.kinematics, threshold=0.0)


def settle_grasp(
    grasp: PerceivedGrasp,
    kinematics: HandKinematics,
    rubber: Rubber,
    allowed: Allowed,
    pads: str = "all",
) -> Settled:
    """Let go of the table, then let the weight grow.

    Args:
        grasp: as perceived at the snapshot.
        kinematics: of the hand.
        rubber: of its pads.
        allowed: motion in the hand up to which a grasp counts as holding.
        pads: whose readings metrics of the settled grasp use: ``all``, or the kind of array.
    """
    ways, ramps = [], []
    for down in weight_directions(grasp.snapshot):
        way = settle(grasp, kinematics, rubber, allowed, down)
        ways.append(way)
        ramps.append(load_ramp(way.process, way.gripped, allowed))
    return Settled(
        displacement_mm=max(way.displacement_mm for way in ways),
        rotation_deg=max(way.rotation_deg for way in ways),
        held=all(way.held for way in ways),
        ramp=min(ramps, key=lambda ramp: ramp.load),
        ways=tuple(ways),
        pads=pads,
        kinematics=kinematics,
    )
