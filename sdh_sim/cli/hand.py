"""``sdh-sim hand``: what a hand is, and whether a user's own can be used."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sdh_sim.cli.console import output, plain_table

if TYPE_CHECKING:
    from sdh_sim.robot import Hand, HandKinematics


def hand(given: str | None = None) -> None:
    """Print motors, joints, fingers, pads and closings of a hand.

    Args:
        given: name of a built-in hand, or path of a folder or of its ``hand.toml``; None:
            the SDH-2.

    Raises:
        SettingsError: no such hand, or a folder that cannot be used.
    """
    from sdh_sim.robot import hand_kinematics

    known = _hand(given)
    kinematics = hand_kinematics(known)
    console = output()
    console.print(_joints(kinematics))
    console.print(_pads(known))
    console.print(_closings(kinematics))
    _say(f"{known.name}: motor groups {', '.join(known.groups)}")
    for finger in known.fingers:
        motors = ", ".join(known.motor_names[k] for k in finger.stops)
        _say(f"  {finger.name} counts as stopped with {motors or 'no motor'}")
    if kinematics.passive:
        _say(f"  passive, held by spring or stop: {', '.join(kinematics.passive)}")
    if known.folder is not None:
        _say(f"  sha256 {known.folder.sha256[:12]}")
        for note in known.folder.notes:
            _say(f"  {note}")


def _hand(given: str | None) -> Hand:
    from sdh_sim.robot import built_in_hand, read_hand_folder

    if given is None:
        return built_in_hand()
    if "/" in given or given.endswith(".toml") or Path(given).is_dir():
        return read_hand_folder(given)
    return built_in_hand(given)


def _joints(kinematics: HandKinematics):
    """Table of the joints: what moves them, limits of that motor."""
    import mujoco

    from sdh_sim.robot import joint_table

    model = kinematics.model
    table = plain_table("joint", "motor", "limit", "range", "speed", text=(0, 1))
    for name, motor, limit, reach, speed in joint_table(kinematics.hand):
        turns = model.joint(name).type[0] == mujoco.mjtJoint.mjJNT_HINGE
        force, length = ("N m", "rad") if turns else ("N", "m")
        table.add_row(
            name,
            motor,
            f"{limit:.4g} {force}",
            f"{_range(reach)} {length}",
            f"{speed:.3g} {length}/s",
        )
    for name in kinematics.passive:
        joint = model.joint(name)
        unit = "rad" if joint.type[0] == mujoco.mjtJoint.mjJNT_HINGE else "m"
        limited = model.jnt_limited[joint.id]
        table.add_row(name, "passive", "", f"{_range(joint.range)} {unit}" if limited else "", "")
    return table


def _pads(hand: Hand):
    table = plain_table("pad", "rows", "columns", "live taxels", "pitch mm")
    for pad in hand.pads:
        rows, columns = pad.array.shape
        live = int(pad.array.live.sum())
        table.add_row(pad.name, str(rows), str(columns), str(live), f"{1e3 * pad.array.pitch:g}")
    return table


def _closings(kinematics: HandKinematics):
    """Table of the closings: how far apart the pads are, how hard they press halfway."""
    from sdh_sim.robot.hand_checks import pad_gaps
    from sdh_sim.sensing.pad_forces import pad_forces

    table = plain_table(
        "closing", "squeezes with", "pads apart mm", "each alone N", "together N", text=(0, 1)
    )
    for name, line in kinematics.hand.closings.items():
        gaps = 1e3 * pad_gaps(kinematics, name)
        forces = pad_forces(kinematics, name)
        motors = [
            m.name for m, used in zip(kinematics.hand.motors, line.squeezes, strict=True) if used
        ]
        alone = sorted(forces.alone.values())
        span = (
            " to ".join(dict.fromkeys(f"{v:.3g}" for v in (alone[0], alone[-1]))) if alone else ""
        )
        together = f"{forces.together:.3g}" if alone else ""
        moved = f"{gaps[0]:.1f} to {gaps.min():.1f}"
        table.add_row(name, ", ".join(motors), moved, span, together)
    return table


def _range(reach: Sequence[float]) -> str:
    return f"{np.round(reach[0], 3) + 0.0:.3f} to {np.round(reach[1], 3) + 0.0:.3f}"


def _say(text: str) -> None:
    output().print(text, markup=False, soft_wrap=True, highlight=False)
