"""isaac_grasp YAML, version 1.0: the format of Isaac Sim's grasp editor and of GraspGen.

    format: isaac_grasp
    format_version: 1.0
    grasps:
      NAME:
        confidence: 1.0
        position: [0.1, 0.0, 0.05]
        orientation: {w: 1.0, xyz: [0.0, 0.0, 0.0]}
        cspace_position: {spread: 0.0, …}
        pregrasp_cspace_position: {spread: 0.0, …}

Position [m] and orientation are the palm frame in the object's frame; ``cspace_position`` are the
motors' angles of the closed hand, ``pregrasp_cspace_position`` those of the approach [rad]. What we
write has three more keys in a grasp, which other programs pass over: ``preshape``, ``ratio`` and
``object_yaw``. Other keys are passed over here.

Source: "Isaac Grasp File", Isaac ROS documentation, NVIDIA.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from sdh_sim.grasp_files.grasp_entry import (
    CLOSED,
    HAND,
    OPEN,
    PALM,
    EntryError,
    FormatError,
    GraspEntry,
    show,
)
from sdh_sim.grasp_files.yaml_reader import read_yaml
from sdh_sim.robot.sdh2_constants import COUPLED_JOINT

FORMAT, VERSION = "isaac_grasp", 1.0
_VALUES_PER_GRASP = 80  # in a file, on average: 46 in those that are written here
_SAME = 1e-9  # [rad] within which angles are those of a preshape
_CLOSED, _OPEN = "cspace_position", "pregrasp_cspace_position"


def read_rows(data: bytes, max_grasps: int) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Where each grasp stands, and its row of a table by column.

    Args:
        data: content of the file.
        max_grasps: largest number of grasps in it.

    Raises:
        FormatError: the file is none of the format, or a grasp in it.
    """
    document = read_yaml(data, max_grasps * _VALUES_PER_GRASP)
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise FormatError(f"is not isaac_grasp YAML; expected format: {FORMAT} at its top")
    version = document.get("format_version")
    try:
        known = float(version) == VERSION  # pyright: ignore[reportArgumentType]
    except (TypeError, ValueError):
        known = False
    if not known:
        raise FormatError(f"has format_version {show(version)}; expected {VERSION}")
    grasps = document.get("grasps")
    if not isinstance(grasps, dict):
        raise FormatError("has no mapping grasps; expected grasps by name")
    if len(grasps) > max_grasps:
        raise FormatError(f"has {len(grasps)} grasps; allowed are {max_grasps}: split the file")
    for name, grasp in grasps.items():
        where = f"grasp {show(name)}"
        try:
            yield where, _row_of(name, grasp)
        except EntryError as error:
            raise FormatError(f"{where} {error}") from error


def _row_of(name: str, grasp: Any) -> dict[str, Any]:
    """The row of a table with the values of a grasp; raises EntryError."""
    if not isinstance(grasp, dict):
        raise EntryError("is no mapping; expected position, orientation and joint angles")
    turn = grasp.get("orientation")
    if not isinstance(turn, dict):
        raise EntryError("has no orientation {w: …, xyz: […]}")
    pose = (*_three(grasp, "position"), turn.get("w"), *_three(turn, "xyz"))
    row: dict[str, Any] = {"name": name, **dict(zip(PALM, pose, strict=True))}
    for key in ("preshape", "ratio", "object_yaw", "confidence"):
        row[key] = grasp.get(key)
    opened, closed = _angles(grasp, _OPEN), _angles(grasp, _CLOSED)
    if isinstance(row["preshape"], str) and row["preshape"] in HAND.closings:
        _check_preshape(row["preshape"], row["ratio"], opened, closed)
    else:
        row |= zip((*OPEN, *CLOSED), (*opened, *closed), strict=True)
    return row


def _three(values: Mapping[str, Any], key: str) -> list[Any]:
    found = values.get(key)
    if not isinstance(found, list) or len(found) != 3:
        raise EntryError(f"has {key} {show(found)}; expected a list of three numbers")
    return found


def _angles(grasp: Mapping[str, Any], key: str) -> list[Any]:
    """Angles of the motors, in their order, as they stand in the file."""
    found = grasp.get(key)
    if not isinstance(found, dict):
        raise EntryError(f"has no {key}; expected angles by joint")
    for joint in found:
        if joint not in (*HAND.motor_names, COUPLED_JOINT):
            raise EntryError(
                f"has the joint {show(joint)} in {key}; this hand has {', '.join(HAND.motor_names)}"
            )
    for joint in HAND.motor_names:
        if found.get(joint) is None:
            raise EntryError(f"has no {joint} in {key}; give all of {', '.join(HAND.motor_names)}")
    coupled = found.get(COUPLED_JOINT, found["spread"])
    if coupled != found["spread"] and _number(coupled) != _number(found["spread"]):
        raise EntryError(
            f"has {COUPLED_JOINT} {show(coupled)} in {key}; it always has the angle of spread: "
            "leave it out"
        )
    return [found[joint] for joint in HAND.motor_names]


def _check_preshape(preshape: str, ratio: Any, opened: list[Any], closed: list[Any]) -> None:
    """Raise EntryError where the angles are not the preshape's: an edit of them would be lost."""
    start = 0.0 if ratio is None else _number(ratio)
    for key, angles, at in ((_OPEN, opened, start), (_CLOSED, closed, 1.0)):
        if not 0.0 <= at <= 1.0:
            continue  # who makes the entry says so
        stated = np.array([_number(angle) for angle in angles])
        if not np.allclose(stated, HAND.closing(preshape).angles(at), rtol=0.0, atol=_SAME):
            raise EntryError(
                f"has preshape {preshape}, but other angles in {key}; remove the preshape and the "
                "ratio to take the angles"
            )


def _number(value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        return float("nan")


def write_text(entries: Iterable[GraspEntry], object_name: str) -> str:
    """The file of one object's grasps."""
    lines = [
        f"format: {FORMAT}",
        f"format_version: {VERSION}",
        f"object_frame: {_quoted(object_name)}",
        "gripper_frame: palm",
        "grasps:",
    ]
    for entry in entries:
        lines += _lines(entry)
    if lines[-1] == "grasps:":
        lines[-1] = "grasps: {}"
    return "\n".join(lines) + "\n"


def _lines(entry: GraspEntry) -> Iterator[str]:
    x, y, z, w, *axis = map(_float, entry.palm_pose.tolist())
    opened, closed = entry.open, entry.closed
    if opened is None or closed is None:
        closing = HAND.closing(entry.preshape)
        opened, closed = closing.angles(entry.ratio or 0.0), closing.angles(1.0)
    yield f"  {_quoted(entry.name)}:"
    # Other programs ask for a confidence; 0 is the least that it can be.
    yield f"    confidence: {_float(entry.confidence or 0.0)}"
    yield f"    position: [{x}, {y}, {z}]"
    yield f"    orientation: {{w: {w}, xyz: [{', '.join(axis)}]}}"
    for key, angles in ((_CLOSED, closed), (_OPEN, opened)):
        yield f"    {key}:"
        for joint, angle in zip(HAND.motor_names, angles.tolist(), strict=True):
            yield f"      {joint}: {_float(angle)}"
    if entry.preshape:
        yield f"    preshape: {entry.preshape}"
    if entry.ratio is not None:
        yield f"    ratio: {_float(entry.ratio)}"
    if entry.object_yaw is not None:
        yield f"    object_yaw: {_float(entry.object_yaw)}"


def _quoted(text: str) -> str:
    """Text as YAML and JSON both write it; what is printed has no need of JSON's escapes."""
    return json.dumps(text, ensure_ascii=False)


def _float(value: float) -> str:
    """A number with all its digits, as YAML 1.1 knows one: with a point before the exponent."""
    mantissa, exponent, power = repr(float(value)).partition("e")
    return (mantissa if "." in mantissa else f"{mantissa}.0") + exponent + power
