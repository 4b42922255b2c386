"""One grasp of a file, and what its values must be."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from sdh_sim.errors import SettingsError, one_line
from sdh_sim.robot import Closing, built_in_hand

HAND = built_in_hand()
PALM = tuple(f"palm_{name}" for name in ("x", "y", "z", "qw", "qx", "qy", "qz"))
OPEN = tuple(f"open_{name}" for name in HAND.motor_names)
CLOSED = tuple(f"closed_{name}" for name in HAND.motor_names)
TEXTS = ("object", "name", "preshape")
NUMBERS = (*PALM, "ratio", *OPEN, *CLOSED, "object_yaw", "confidence")
COLUMNS = ("object", "name", *PALM, "preshape", "ratio", *OPEN, *CLOSED, "object_yaw", "confidence")
"""Columns of a table of grasps, in the order in which they are written."""

MAX_NAME = 100  # letters
_FARTHEST = 10.0  # [m] palm from object: more is a length in other units
_UNIT = 1e-6  # how far the length of a quaternion may be from 1


class FormatError(ValueError):
    """Content that is no file of grasps; the message says why, but not of which file."""


class EntryError(ValueError):
    """Values that are no grasp; the message is the end of a sentence about where they stand."""


@dataclass(frozen=True, eq=False)
class GraspEntry:
    """One grasp of a file.

    Attributes:
        object: name of the object.
        name: of the grasp, one of its own among those of the object.
        palm_pose: pose of the palm frame in the object's frame when the hand closes: x y z [m] and
            a quaternion w x y z whose length is 1 within 1e-6; (7,).
        preshape: of the fingers; empty where the angles are given.
        ratio: closing ratio of the preshape during the approach; None: the most closed one that
            touches nothing.
        open, closed: motor angles between which the hand closes (7,) [rad], the first during the
            approach; None with a preshape.
        object_yaw: of the object on the table [rad]; None: chosen so that the arm can do it.
        confidence: what the file says of the grasp; None: nothing.
    """

    object: str
    name: str
    palm_pose: np.ndarray
    preshape: str = ""
    ratio: float | None = None
    open: np.ndarray | None = None
    closed: np.ndarray | None = None
    object_yaw: float | None = None
    confidence: float | None = None

    @property
    def closing(self) -> Closing:
        """How the fingers close."""
        if self.preshape:
            return HAND.closing(self.preshape)
        assert self.open is not None
        assert self.closed is not None
        return HAND.closing_between(self.open, self.closed)

    @property
    def opening(self) -> float | None:
        """Closing ratio during the approach; None: the most closed one that touches nothing."""
        return self.ratio if self.preshape else 0.0

    def values(self) -> dict[str, Any]:
        """The row of a table by column: text, a number, or None where there is no value."""
        row: dict[str, Any] = dict.fromkeys(COLUMNS)
        row |= {"object": self.object, "name": self.name, "preshape": self.preshape or None}
        row |= zip(PALM, self.palm_pose.tolist(), strict=True)
        for names, angles in ((OPEN, self.open), (CLOSED, self.closed)):
            if angles is not None:
                row |= zip(names, angles.tolist(), strict=True)
        return row | {
            "ratio": self.ratio,
            "object_yaw": self.object_yaw,
            "confidence": self.confidence,
        }


def entry_of(values: Mapping[str, Any], object_name: str, name: str) -> GraspEntry:
    """The grasp of a row.

    Args:
        values: by column; text, numbers, or None or nothing where there is no value.
        object_name, name: of the object and the grasp where the row does not name them.

    Raises:
        EntryError: a value is missing or cannot be used.
    """
    preshape = text_of(values, "preshape") or ""
    given = [column for column in (*OPEN, *CLOSED) if values.get(column) is not None]
    ratio = _number(values, "ratio", 0.0, 1.0)
    if preshape:
        if preshape not in HAND.closings:
            raise EntryError(
                f"has preshape {show(preshape)}; choose one of {', '.join(HAND.closings)}"
            )
        if given:
            raise EntryError(f"has a preshape and {given[0]}; give a preshape or angles, not both")
        angles = None, None
    else:
        if not given:
            raise EntryError(
                f"has neither a preshape nor angles; give preshape, or {OPEN[0]} … {CLOSED[-1]}"
            )
        if ratio is not None:
            raise EntryError("has a ratio without a preshape; with angles, open_… are taken")
        angles = _angles(values, OPEN), _angles(values, CLOSED)
    entry = GraspEntry(
        object=text_of(values, "object") or object_name,
        name=text_of(values, "name") or name,
        palm_pose=_palm_pose(values),
        preshape=preshape,
        ratio=ratio,
        open=angles[0],
        closed=angles[1],
        object_yaw=_number(values, "object_yaw", -2 * math.pi, 2 * math.pi, "rad"),
        confidence=_number(values, "confidence", -math.inf, math.inf),
    )
    try:
        _ = entry.closing  # who makes closings checks angles
    except SettingsError as error:
        raise EntryError(f"cannot close: {error}") from error
    return entry


def _palm_pose(values: Mapping[str, Any]) -> np.ndarray:
    found = [_number(values, name, -_FARTHEST, _FARTHEST, "m") for name in PALM]
    for name, value in zip(PALM, found, strict=True):
        if value is None:
            raise EntryError(f"has no {name}; the palm's pose needs {', '.join(PALM)}")
    pose = np.array(found, dtype=float)
    length = float(np.linalg.norm(pose[3:]))
    if abs(length - 1.0) > _UNIT:
        raise EntryError(
            f"has a quaternion {PALM[3]} … {PALM[6]} of length {length:.9g}; expected 1: divide "
            "it by its length"
        )
    return pose


def _angles(values: Mapping[str, Any], names: tuple[str, ...]) -> np.ndarray:
    found = [_number(values, name, -math.inf, math.inf) for name in names]
    for name, value in zip(names, found, strict=True):
        if value is None:
            raise EntryError(f"has no {name}; give all seven angles of open_… and closed_…")
    return np.array(found, dtype=float)


def text_of(values: Mapping[str, Any], name: str) -> str | None:
    """The text of a column, None where there is none; raises EntryError."""
    value = values.get(name)
    if value is None or value == "":
        return None
    if not isinstance(value, str) or not value.isprintable() or len(value) > MAX_NAME:
        raise EntryError(
            f"has {name} {show(value)}; expected text that can be printed, at most {MAX_NAME} "
            "letters"
        )
    return value


def _number(
    values: Mapping[str, Any], name: str, low: float, high: float, unit: str = ""
) -> float | None:
    value = values.get(name)
    if value is None:
        return None
    try:
        if isinstance(value, bool):
            raise TypeError
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise EntryError(f"has {name} {show(value)}; expected a number") from error
    if not math.isfinite(number):
        raise EntryError(f"has {name} {number}; expected a finite number")
    if not low <= number <= high:
        raise EntryError(
            f"has {name} {number:.9g}; allowed is {low:.4g} to {high:.4g} {unit}".rstrip()
        )
    return number


def show(value: object, length: int = 60) -> str:
    """A user's value in a message: without control characters, cut to a length."""
    return one_line(repr(value)[: 2 * length], length)
