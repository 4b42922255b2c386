"""What settling says of a grasp, put into a trial's row."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sdh_sim.metrics import METRICS, evaluate, user_metrics
from sdh_sim.records import SETTLED, TrialRow
from sdh_sim.robot import HandKinematics
from sdh_sim.sensing import PerceivedGrasp
from sdh_sim.settling import Allowed, Rubber, Settled, settle_grasp
from sdh_sim.trial.outcome import MAX_DISPLACEMENT_MM, MAX_ROTATION_DEG
from sdh_sim.user_references import UserMetric


def settle_into(
    row: TrialRow, grasp: PerceivedGrasp, kinematics: HandKinematics, rubber: Rubber, pads: str
) -> Settled:
    """Let the grasp settle; the row gets verdict, motion, pose and load.

    Args:
        row: of the trial.
        grasp: as perceived at the snapshot.
        kinematics: of the hand.
        rubber: of its pads.
        pads: whose readings metrics use.
    """
    allowed = Allowed(MAX_DISPLACEMENT_MM, MAX_ROTATION_DEG)
    settled = settle_grasp(grasp, kinematics, rubber, allowed, pads)
    row["settled"] = settled.held
    row[SETTLED + "displacement_mm"] = settled.displacement_mm
    row[SETTLED + "rotation_deg"] = settled.rotation_deg
    row[SETTLED + "object_pose_hand"] = settled.object_pose_hand
    row["q_settled"], row["q_settled_capped"] = settled.ramp
    return settled


def rate_settled(row: TrialRow, settled: Settled, metrics: Sequence[UserMetric]) -> None:
    """All metrics where the grasp settled, put into the row.

    A grasp that does not settle within what is allowed bears nothing: its metrics are 0, as those
    of a hand that touches nothing, and users' metrics have no value.

    Args:
        row: of the trial.
        settled: what settling says of it.
        metrics: users' own.
    """
    if settled.held:
        values = {
            **evaluate(settled.grasp),
            **user_metrics.evaluate_user_metrics(settled.grasp, metrics),
            "contacts": len(settled.grasp.contacts),
        }
    else:
        values = {**dict.fromkeys(METRICS, 0.0), **{m.column: np.nan for m in metrics}}
    row.update({SETTLED + name: value for name, value in values.items()})
