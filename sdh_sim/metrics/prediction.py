"""Metrics of a snapshot, computed before the lift."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from sdh_sim.metrics.built_in import evaluate, task_scaling
from sdh_sim.objects import ObjectInfo
from sdh_sim.robot import HandKinematics
from sdh_sim.sensing import PadContact, PerceivedGrasp, TactileSnapshot, perceive
from sdh_sim.settings import TAXEL_THRESHOLD

NO_READING = "no pad reads a contact"


@dataclass(frozen=True)
class Prediction:
    """Metrics of a snapshot.

    Attributes:
        values: by name of the metric; NaN where it cannot be computed.
        reason: why q* is 0, empty otherwise.
        grasp: what they were computed from, as the hand perceived it.
    """

    values: dict[str, float]
    reason: str
    grasp: PerceivedGrasp

    @property
    def contacts(self) -> tuple[PadContact, ...]:
        """The pads in contact."""
        return self.grasp.contacts

    @property
    def q_linf(self) -> float:
        """q* of equation (9); 0 when the grasp cannot exert the task."""
        return self.values["q_linf"]

    @property
    def q_l1(self) -> float:
        """q* of equation (10); 0 when the grasp cannot exert the task."""
        return self.values["q_l1"]


def predict(
    snapshot: TactileSnapshot,
    obj: ObjectInfo,
    torque_limit: Sequence[float],
    pads: str,
    kinematics: HandKinematics | None = None,
    threshold: float = TAXEL_THRESHOLD,
) -> Prediction:
    """Every metric from the snapshot and the known object alone.

    Args:
        snapshot: what the hand sensed.
        obj: mass, friction and centre of mass of the object.
        torque_limit: of the groups of motors [N m or N].
        pads: ``all``, or the kind of array whose pads count.
        kinematics: the hand; None takes the one of the process.
        threshold: share of its pad's largest reading that a taxel must exceed to count.
    """
    grasp = perceive(snapshot, obj, torque_limit, pads, kinematics, threshold)
    values = evaluate(grasp)
    reason = ""
    if not grasp.contacts:
        reason = NO_READING
    elif values["q_linf"] == 0.0:
        reason = task_scaling(grasp, "linf").reason or ""
    return Prediction(values, reason, grasp)
