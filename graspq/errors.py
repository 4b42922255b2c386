"""The one error class of the library, and the checks that raise it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

UNIT_TOLERANCE = 1e-6


class GraspError(ValueError):
    """Bad input, or a result that cannot be vouched for; the message names what came."""


def as_array(name: str, value: Any, shape: tuple[int | None, ...], hint: str = "") -> np.ndarray:
    """Return ``value`` as a finite float array of ``shape`` (None matches any length)."""
    try:
        array = np.array(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise GraspError(
            f"{name}: expected numbers of shape {_text(shape)}, got {value!r}{_hint(hint)}"
        ) from error
    matches = array.ndim == len(shape) and all(
        want is None or want == have for want, have in zip(shape, array.shape, strict=True)
    )
    if not matches:
        raise GraspError(f"{name}: expected shape {_text(shape)}, got {array.shape}{_hint(hint)}")
    if not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise GraspError(f"{name}: every entry must be finite, got {array[where]} at {where}")
    return array


def as_number(name: str, value: Any, *, positive: bool = False) -> float:
    """Return ``value`` as a finite float that is >= 0 (or > 0 when ``positive``)."""
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise GraspError(f"{name}: expected one number, got {value!r}") from error
    bound = "> 0" if positive else ">= 0"
    if not math.isfinite(number) or number < 0 or (positive and number == 0):
        raise GraspError(f"{name}: expected a finite number {bound}, got {number}")
    return number


def as_unit(name: str, value: Any) -> np.ndarray:
    """Return ``value`` as a (3,) vector of length 1 within ``UNIT_TOLERANCE``."""
    vector = as_array(name, value, (3,))
    length = float(np.linalg.norm(vector))
    if abs(length - 1.0) > UNIT_TOLERANCE:
        raise GraspError(
            f"{name}: expected a unit vector, got length {length:.9g}; divide it by its norm"
        )
    return vector


def as_choice(name: str, value: Any, choices: tuple[str, ...]) -> str:
    """Return ``value`` when it is one of ``choices``."""
    if value not in choices:
        raise GraspError(f"{name}: expected one of {', '.join(choices)}; got {value!r}")
    return value


def _text(shape: tuple[int | None, ...]) -> str:
    names = iter("nmk")
    parts = [str(size) if size is not None else next(names) for size in shape]
    return "(" + ", ".join(parts) + ("," if len(parts) == 1 else "") + ")"


def _hint(hint: str) -> str:
    return f"; {hint}" if hint else ""
