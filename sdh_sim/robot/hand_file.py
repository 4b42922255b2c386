"""``hand.toml``: what a hand's model does not say, read and checked.

The page Extending of the documentation explains every key.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sdh_sim.errors import HandError
from sdh_sim.robot.closing import Closing, check_posture
from sdh_sim.robot.hand_description import Finger, Hand, Motor, Pad, Reach, TaxelArray

FILE = "hand.toml"
MAX_MOTORS, MAX_FINGERS, MAX_PADS, MAX_CLOSINGS = 32, 10, 40, 20
MAX_ROWS = 64  # of an array, and columns
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,47}")


class Reader:
    """A table of the file: values of a type each, every key asked for once.

    Args:
        where: the table in messages.
        values: by key.
    """

    def __init__(self, where: str, values: object) -> None:
        if not isinstance(values, dict):
            raise HandError(f"{where or FILE} is {_show(values)}; expected a table")
        self._where, self._values, self._asked = where, values, set[str]()

    def error(self, key: str, problem: str) -> HandError:
        """The error for a key."""
        return HandError(f"{self._where}.{key}".lstrip(".") + f" {problem}")

    def get(
        self, key: str, kind: type | tuple[type, ...], expected: str, default: Any = ...
    ) -> Any:
        """The value of a key; ``default`` where it may be left out."""
        self._asked.add(key)
        if key not in self._values:
            if default is ...:
                raise self.error(key, f"is missing; expected {expected}")
            return default
        value = self._values[key]
        if not isinstance(value, kind) or (isinstance(value, bool) and bool not in _types(kind)):
            raise self.error(key, f"is {_show(value)}; expected {expected}")
        return value

    def name(self, key: str, default: Any = ...) -> str:
        """A name."""
        value = self.get(key, str, "a name", default)
        if value is not default and not _NAME.fullmatch(value):
            raise self.error(key, f"is {_show(value)}; a name has letters, digits, _ and -")
        return value

    def number(self, key: str, low: float, high: float, default: Any = ...) -> float:
        """A finite number within bounds."""
        value = self.get(key, (int, float), "a number", default)
        if value is not default and not low <= value <= high:
            raise self.error(key, f"is {_show(value)}; allowed is {low:g} to {high:g}")
        return float(value)

    def whole(self, key: str, low: int, high: int, default: Any = ...) -> int:
        """A whole number within bounds."""
        value = self.get(key, int, "a whole number", default)
        if not low <= value <= high:
            raise self.error(key, f"is {_show(value)}; allowed is {low} to {high}")
        return value

    def numbers(self, key: str, count: int, default: Any = ...) -> tuple[float, ...]:
        """So many finite numbers."""
        value = self.get(key, list, f"a list of {count} numbers", default)
        if value is default:
            return value
        good = all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in value)
        if len(value) != count or not good or not all(map(math.isfinite, value)):
            raise self.error(key, f"is {_show(value)}; expected {count} finite numbers")
        return tuple(map(float, value))

    def names(self, key: str, known: Sequence[str] | None, default: Any = ...) -> tuple[str, ...]:
        """A list of names, of those known where that is given."""
        value = self.get(key, list, "a list of names", default)
        for item in value:
            if not isinstance(item, str) or (known is not None and item not in known):
                hint = "a name" if known is None else f"one of {', '.join(known)}"
                raise self.error(key, f"has {_show(item)}; expected {hint}")
        return tuple(value)

    def tables(self, key: str, most: int, default: Any = ...) -> Iterator[tuple[str, Reader]]:
        """The tables below a key by name, in the order of the file."""
        found = self.get(key, dict, "tables by name", default)
        if len(found) > most:
            raise self.error(key, f"has {len(found)} tables; at most {most} are taken")
        for name, values in found.items():
            if not _NAME.fullmatch(name):
                raise self.error(key, f"has {_show(name)}; a name has letters, digits, _ and -")
            below = Reader(f"{self._where}.{key}.{name}".lstrip("."), values)
            yield name, below
            below.finish()

    def finish(self) -> None:
        """Raise HandError where the table has a key that nobody asked for."""
        for key in self._values:
            if key not in self._asked:
                raise self.error(
                    _show(key, 40), f"is not known; known here are {', '.join(sorted(self._asked))}"
                )


Spans = Mapping[str, tuple[float, float]]


def read_hand_file(data: bytes, folder: Path, spans_of: Callable[[Path], Spans]) -> Hand:
    """The hand that a ``hand.toml`` describes.

    Args:
        data: content of the file.
        folder: that it lies in.
        spans_of: gives the ranges of the actuators of a model by name.

    Raises:
        HandError: not TOML, or a key that is missing, unknown or not what it should be.
    """
    try:
        values = tomllib.loads(data.decode())
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise HandError(f"is not TOML ({str(error).splitlines()[0][:100]})") from error
    top = Reader("", values)
    name, model = top.name("name"), top.get("model", str, "the name of an MJCF file")
    palm = top.name("palm")
    groups = top.names("groups", None)
    fingers = [name for name, _ in _peek(top, "fingers", MAX_FINGERS)]
    spans = spans_of(folder / model)
    motors = tuple(
        _motor(n, t, groups, fingers, spans) for n, t in top.tables("motors", MAX_MOTORS)
    )
    names = [motor.name for motor in motors]
    arrays = {n: _array(n, t) for n, t in top.tables("arrays", MAX_PADS, {})}
    pads = tuple(
        Pad(n, t.name("body"), arrays[_one_of(t, "array", arrays)])
        for n, t in top.tables("pads", MAX_PADS, {})
    )
    found = tuple(_finger(n, t, names) for n, t in top.tables("fingers", MAX_FINGERS))
    closings, reaches = {}, {}
    for n, table in top.tables("closings", MAX_CLOSINGS):
        closings[n] = _closing(n, table, motors)
        reaches[n] = _reach(table)
    top.finish()
    if not motors or not found or not closings:
        raise HandError("needs at least one motor, one finger and one closing")
    return Hand(name, folder / model, palm, groups, motors, found, pads, closings, reaches)


def _peek(top: Reader, key: str, most: int) -> list[tuple[str, object]]:
    """Names of the tables below a key, which are read later."""
    found = top.get(key, dict, "tables by name")
    if len(found) > most:
        raise top.error(key, f"has {len(found)} tables; at most {most} are taken")
    return list(found.items())


def _motor(
    name: str, table: Reader, groups: Sequence[str], fingers: Sequence[str], spans: Spans
) -> Motor:
    if name not in spans:
        raise HandError(
            f"motors.{name}: the model has no actuator of that name with a ctrlrange; it has "
            f"{', '.join(spans) or 'none'}"
        )
    rated = table.number("rated", 1e-6, 1e6)
    speed = table.number("speed", 1e-6, 1e3)
    return Motor(
        name=name,
        group=groups[_index(table, "group", groups)],
        rated=rated,
        speed=speed,
        closing_speed=table.number("closing_speed", 1e-6, 1e3),
        span=spans[name],
        finger=_index(table, "finger", fingers),
        flexes=table.whole("flexes", -1, 1, 1),
    )


def _finger(name: str, table: Reader, motors: Sequence[str]) -> Finger:
    stops = table.names("stops", motors)
    tip, position = table.name("tip"), table.numbers("tip_position", 3)
    return Finger(
        name=name,
        bodies=table.names("bodies", None),
        stops=tuple(motors.index(motor) for motor in stops),
        tip=tip,
        tip_position=position,
        pad_ahead=table.number("pad_ahead", 0.0, 0.2, 0.0),
    )


def _array(kind: str, table: Reader) -> TaxelArray:
    columns = table.whole("columns", 1, MAX_ROWS)
    pitch = table.number("pitch", 5e-4, 0.05)
    rows = table.get("profile", list, "a list of rows [x mm, z mm, tilt deg]")
    if not 1 <= len(rows) <= MAX_ROWS:
        raise table.error("profile", f"has {len(rows)} rows; allowed are 1 to {MAX_ROWS}")
    profile = np.array([Reader("row", {"of": row}).numbers("of", 3) for row in rows])
    live = np.ones((len(rows), columns), dtype=bool)
    for place in table.get("missing", list, "a list of [row, column]", []):
        row, column = Reader("missing", {"of": place}).numbers("of", 2)
        if not (0 <= row < len(rows) and 0 <= column < columns):
            raise table.error("missing", f"has {_show(place)}, which is outside the array")
        live[int(row), int(column)] = False
    for array in (profile, live):
        array.setflags(write=False)
    return TaxelArray(kind, pitch, profile, live)


def _closing(name: str, table: Reader, motors: Sequence[Motor]) -> Closing:
    names = [motor.name for motor in motors]
    ranges = np.array([motor.span for motor in motors])
    start = check_posture(f"closings.{name}.open", table.get("open", list, "a list"), names, ranges)
    travel = np.array(table.numbers("travel", len(motors)))
    squeeze = table.names("squeeze", names)
    if not squeeze:
        raise table.error("squeeze", "is empty; name the motors that hold the object in the end")
    fingers = np.array([motor.finger for motor in motors])
    squeezes = np.array([n in squeeze for n in names])
    for array in (start, travel, squeezes):
        array.setflags(write=False)
    return Closing(name, start, travel, table.number("rate", 1e-3, 10.0), squeezes, fingers, ranges)


def _reach(table: Reader) -> Reach:
    precision = table.numbers("precision_depth", 2, None)
    low, high = table.numbers("depth", 2)
    return Reach(
        centre=table.number("centre", -0.2, 0.2, 0.0),
        depth=(low, high),
        precision_depth=None if precision is None else (precision[0], precision[1]),
    )


def _index(table: Reader, key: str, known: Sequence[str]) -> int:
    value = table.get(key, str, f"one of {', '.join(known)}")
    if value not in known:
        raise table.error(key, f"is {_show(value)}; expected one of {', '.join(known)}")
    return list(known).index(value)


def _one_of(table: Reader, key: str, known: Mapping[str, object]) -> str:
    return list(known)[_index(table, key, list(known))]


def _types(kind: type | tuple[type, ...]) -> tuple[type, ...]:
    return kind if isinstance(kind, tuple) else (kind,)


def _show(value: object, length: int = 60) -> str:
    """A value in a message, cut to a length."""
    text = repr(value)
    return text if len(text) <= length else text[: length - 1] + "…"
