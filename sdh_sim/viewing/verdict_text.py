"""The prediction and the outcome of a trial as text."""

from __future__ import annotations

import math

import numpy as np

import graspq as gq
from sdh_sim.records import LIFT_OFF, TrialRow
from sdh_sim.trial import TrialLog
from sdh_sim.viewing.style import FORCE_SCALE, LIMIT_SCALE


def verdict_markdown(log: TrialLog, least: gq.ContactForces | None) -> str:
    """The prediction and the outcome, as Markdown.

    Args:
        log: of the trial.
        least: contact forces of least effort that bear the weight; None where there are none.
    """
    row = log.row
    limit = log.scene.torque_limit
    outcome = "held" if row["success"] else f"failed: {row['failure']}"
    contacts = forces = "-"
    if log.prediction is not None and log.prediction.contacts:
        contacts = ", ".join(
            f"{p.pad} {p.contact.max_normal_force:.1f} N" for p in log.prediction.contacts
        )
        forces = "none within friction and motor torques"
        if least is not None:
            sizes = np.linalg.norm(least.wrenches[:, :3], axis=1)
            forces = ", ".join(
                f"{p.pad} {size:.1f} N"
                for p, size in zip(log.prediction.contacts, sizes, strict=True)
            )
    facts = [
        ("object", f"{row['object']}, {row['mass_kg']:.3f} kg, friction {row['friction']:.2f}, "
                   f"seed {row['seed']}"),
        ("motion in the hand", f"{_number(row['displacement_mm'], 'mm')}, "
                               f"{_number(row['rotation_deg'], '°')}"),
        ("q* L∞, q* L1", f"{_number(row.get('q_linf'))}, {_number(row.get('q_l1'))}"
                         + (f" ({row['q_reason']})" if row.get("q_reason") else "")),
        *_lift_off(row),
        ("contacts, g*", contacts),
        ("forces of least effort for the weight", forces),
        ("torque limit", ", ".join(
            f"{group} {value:.3f} N m"
            for group, value in zip(log.scene.hand.groups, limit, strict=True)
        )),
        ("plan", _plan(row)),
    ]  # fmt: skip
    table = [f"| {name} | {text} |" for name, text in facts]
    lines = [f"## {outcome}", "", table[0], "|---|---|", *table[1:]]
    lines += [
        "",
        "A value of q* above 1 predicts that the object is held. Arrows: red are contact forces, "
        f"{FORCE_SCALE * 1e3:.0f} mm/N; blue are the contacts of the prediction, as long as their "
        f"g*, {LIMIT_SCALE * 1e3:.0f} mm/N, with their friction cones; yellow, of the same scale, "
        "are the contact forces of least effort that would bear the weight. The wrench space shows "
        "the forces that the contacts can exert on the object, L1 (orange) inside L∞ (blue), and "
        "the weight (red).",
    ]
    return "\n".join(lines)


def _lift_off(row: TrialRow) -> list[tuple[str, str]]:
    """What the second snapshot says, where there is one."""
    if LIFT_OFF + "rise_mm" not in row:
        return []
    q = [_number(row.get(f"{LIFT_OFF}{name}")) for name in ("q_linf", "q_l1")]
    where = "still on the table" if row[LIFT_OFF + "on_table"] else "off the table"
    moved = _number(row[LIFT_OFF + "displacement_mm"], "mm")
    text = f"{', '.join(q)}; {where}, {moved} in the hand, "
    return [("q* L∞, q* L1 at lift-off", f"{text}{row[LIFT_OFF + 'rise_mm']:.1f} mm up")]


def _plan(row: TrialRow) -> str:
    """How the hand went to the object."""
    if row.approach is None:  # a given grasp
        return f"given, preshape {row.preshape or 'of its own'}"
    assert row.plan_height_m is not None
    assert row.plan_roll_rad is not None
    assert row.plan_tilt_rad is not None
    return (
        f"{row.approach}, {row.preshape}, height {row.plan_height_m * 1e3:.0f} mm, "
        f"roll {math.degrees(row.plan_roll_rad):.0f}°, tilt {math.degrees(row.plan_tilt_rad):.0f}°"
    )


def _number(value: float | None, unit: str = "") -> str:
    if value is None or math.isnan(value):
        return "-"
    return f"{value:.2f} {unit}".rstrip()
