"""``hand.toml``: what a hand's model does not say, read and checked.

The page Extending of the documentation explains every key.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from sdh_sim.errors import HandError
from sdh_sim.robot.closing import Closing, check_posture
from sdh_sim.robot.hand_description import Coupling, Finger, Hand, JointDynamics, Motor, Reach
from sdh_sim.robot.pads import Frame, Pad, TaxelArray
from sdh_sim.robot.toml_table import TomlTable, show

MAX_MOTORS, MAX_FINGERS, MAX_PADS, MAX_CLOSINGS, MAX_JOINTS = 32, 10, 40, 20, 100
MAX_ROWS = 64  # of an array, and columns
PALM_FRAME, PAD_FRAME = "palm_frame", "_frame"  # names of bodies that a model gets for frames


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
    top = _top(data)
    name, model = top.name("name"), top.get("model", str, "the name of an MJCF file")
    _angle(top)  # the model has been read with it
    palm = top.name("palm")
    palm_frame = _frame(top, palm, "palm_pos", "palm_quat")
    groups = top.names("groups", None)
    fingers = [name for name, _ in _peek(top, "fingers", MAX_FINGERS)]
    spans = spans_of(folder / model)
    motors = tuple(
        _motor(n, t, groups, fingers, spans) for n, t in top.tables("motors", MAX_MOTORS)
    )
    names = [motor.name for motor in motors]
    arrays = {n: _array(n, t) for n, t in top.tables("arrays", MAX_PADS, {})}
    pads = tuple(_pad(n, t, arrays) for n, t in top.tables("pads", MAX_PADS, {}))
    found = tuple(_finger(n, t, names) for n, t in top.tables("fingers", MAX_FINGERS))
    closings, reaches = {}, {}
    for n, table in top.tables("closings", MAX_CLOSINGS):
        closings[n] = _closing(n, table, motors)
        reaches[n] = _reach(table)
    joints = {n: _joint(t) for n, t in top.tables("joints", MAX_JOINTS, {})}
    couplings = tuple(
        Coupling(n, t.name("follows"), t.number("ratio", -1e3, 1e3))
        for n, t in top.tables("couplings", MAX_JOINTS, {})
    )
    top.finish()
    if not motors or not found or not closings:
        raise HandError("needs at least one motor, one finger and one closing")
    return Hand(
        name=name,
        model=folder / model,
        palm=PALM_FRAME if palm_frame else palm,
        groups=groups,
        motors=motors,
        fingers=found,
        pads=pads,
        closings=closings,
        reaches=reaches,
        joints=joints,
        couplings=couplings,
        palm_frame=palm_frame,
    )


def model_of(data: bytes) -> tuple[str, str]:
    """The MJCF file that a ``hand.toml`` names, and its unit of angles, empty where not said.

    Raises:
        HandError: as ``read_hand_file``.
    """
    top = _top(data)
    return top.get("model", str, "the name of an MJCF file"), _angle(top)


def _angle(top: TomlTable) -> str:
    angle = top.get("angle", str, "radian or degree", "")
    if angle not in ("", "radian", "degree"):
        raise top.error("angle", f"is {show(angle)}; expected radian or degree")
    return angle


def _top(data: bytes) -> TomlTable:
    try:
        values = tomllib.loads(data.decode())
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise HandError(f"is not TOML ({str(error).splitlines()[0][:100]})") from error
    return TomlTable("", values)


def _peek(top: TomlTable, key: str, most: int) -> list[tuple[str, object]]:
    """Names of the tables below a key, which are read later."""
    found = top.get(key, dict, "tables by name")
    if len(found) > most:
        raise top.error(key, f"has {len(found)} tables; at most {most} are taken")
    return list(found.items())


def _motor(
    name: str, table: TomlTable, groups: Sequence[str], fingers: Sequence[str], spans: Spans
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
        kp=_optional(table, "kp", 1e-6, 1e9),
        kv=_optional(table, "kv", 0.0, 1e9),
    )


def _optional(table: TomlTable, key: str, low: float, high: float) -> float | None:
    return (
        None
        if table.get(key, (int, float), "a number", None) is None
        else (table.number(key, low, high))
    )


def _joint(table: TomlTable) -> JointDynamics:
    return JointDynamics(
        _optional(table, "damping", 0.0, 1e6),
        _optional(table, "armature", 0.0, 1e6),
        _optional(table, "frictionloss", 0.0, 1e6),
    )


def _finger(name: str, table: TomlTable, motors: Sequence[str]) -> Finger:
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


def _pad(name: str, table: TomlTable, arrays: Mapping[str, TaxelArray]) -> Pad:
    body = table.name("body")
    array = arrays[_one_of(table, "array", arrays)]
    frame = _frame(table, body, "pos", "quat")
    replaces = table.names("replaces", None, [])
    return Pad(name, name + PAD_FRAME if frame else body, array, frame, replaces)


def _frame(table: TomlTable, body: str, pos: str, quat: str) -> Frame | None:
    """A frame in a body, as two keys say; None where neither is given."""
    place, turn = table.numbers(pos, 3, None), table.numbers(quat, 4, None)
    if place is None and turn is None:
        return None
    if max(map(abs, place or (0.0,))) > 1.0:
        raise table.error(pos, f"is {show(place)}; expected a place within 1 m of the body")
    length = math.sqrt(sum(v * v for v in turn or (1.0,)))
    if not 0.9 < length < 1.1:
        raise table.error(quat, f"is {show(turn)}; expected a quaternion w, x, y, z of length 1")
    unit = (1.0, 0.0, 0.0, 0.0) if turn is None else tuple(v / length for v in turn)
    return Frame(body, place or (0.0, 0.0, 0.0), unit)


def _array(kind: str, table: TomlTable) -> TaxelArray:
    columns = table.whole("columns", 1, MAX_ROWS)
    pitch = table.number("pitch", 5e-4, 0.05)
    flat = table.whole("rows", 1, MAX_ROWS, 0)
    if flat:  # around the origin of the pad's frame
        heights = 1e3 * pitch * (0.5 * (flat - 1) - np.arange(flat))
        rows = [[0.0, float(z), 0.0] for z in heights]
    else:
        rows = table.get("profile", list, "a list of rows [x mm, z mm, tilt deg], or rows")
    if not 1 <= len(rows) <= MAX_ROWS:
        raise table.error("profile", f"has {len(rows)} rows; allowed are 1 to {MAX_ROWS}")
    profile = np.array([TomlTable("row", {"of": row}).numbers("of", 3) for row in rows])
    live = np.ones((len(rows), columns), dtype=bool)
    for place in table.get("missing", list, "a list of [row, column]", []):
        row, column = TomlTable("missing", {"of": place}).numbers("of", 2)
        if not (0 <= row < len(rows) and 0 <= column < columns):
            raise table.error("missing", f"has {show(place)}, which is outside the array")
        live[int(row), int(column)] = False
    for array in (profile, live):
        array.setflags(write=False)
    return TaxelArray(kind, pitch, profile, live)


def _closing(name: str, table: TomlTable, motors: Sequence[Motor]) -> Closing:
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


def _reach(table: TomlTable) -> Reach:
    precision = table.numbers("precision_depth", 2, None)
    low, high = table.numbers("depth", 2)
    return Reach(
        centre=table.number("centre", -0.2, 0.2, 0.0),
        depth=(low, high),
        precision_depth=None if precision is None else (precision[0], precision[1]),
    )


def _index(table: TomlTable, key: str, known: Sequence[str]) -> int:
    value = table.get(key, str, f"one of {', '.join(known)}")
    if value not in known:
        raise table.error(key, f"is {show(value)}; expected one of {', '.join(known)}")
    return list(known).index(value)


def _one_of(table: TomlTable, key: str, known: Mapping[str, object]) -> str:
    return list(known)[_index(table, key, list(known))]
