"""``object.toml``, where a user states mass, friction and other facts; every key is checked."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable
from dataclasses import asdict
from pathlib import PurePosixPath
from typing import Any

from sdh_sim.objects.facts import DEFAULT_SPREAD, FACTS, MESHES, MJCF, Facts, Spread
from sdh_sim.user_files.folder import Folder, show
from sdh_sim.user_references import NAME

MAX_FACTS = 16 << 10  # [bytes]
MIN_MASS, MAX_MASS = 0.01, 5.0  # [kg]
MAX_POSE = 50  # number of a stable pose
RESERVED = ("all", "overall")  # names that mean all objects


def read_facts(folder: Folder) -> Facts:
    """``object.toml`` of a folder.

    Raises:
        ObjectError: it is missing, no TOML, has an unknown key or a value out of range.
    """
    text = folder.read(FACTS, MAX_FACTS)
    try:
        data = tomllib.loads(text.decode())
    except (ValueError, RecursionError) as error:
        raise folder.error(f"{FACTS} is not TOML: {show(str(error), 160)}") from error
    grasp = data.pop("grasp", None)
    values = _values(folder, data, _FIELDS, "")
    for name in ("mass", "friction"):
        if name not in values:
            raise folder.error(f"{FACTS} lacks {name}; {_FIELDS[name][1]}")
    if grasp is not None:
        if not isinstance(grasp, dict):
            raise folder.error(f"{FACTS}: grasp is {show(grasp)}; expected a table [grasp]")
        spread = _values(folder, grasp, _GRASP, "grasp.")
        values["spread"] = Spread(**{**asdict(DEFAULT_SPREAD), **spread})
    if values.get("hull") and values.get("decompose"):
        raise folder.error(f"{FACTS}: hull and decompose are both true; choose one")
    values.setdefault("name", folder.path.name)
    if not NAME.fullmatch(values["name"]) or values["name"] in RESERVED:
        raise folder.error(
            f"the name {show(values['name'])} cannot be used; set name in {FACTS}: letters, "
            f"digits, _ and -, at most 48, the first a letter, not {' or '.join(RESERVED)}"
        )
    return Facts(**values)


Check = tuple[Callable[[Any], Any], str]
"""Makes a value of what TOML gives, or raises ValueError; and what a message asks the user for."""


def _number(low: float, high: float, unit: str) -> Check:
    """A number within bounds."""

    def check(value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ValueError
        if not low <= value <= high:  # NaN fails too
            raise ValueError
        return float(value)

    return check, f"give a number {low:g} to {high:g} {unit}".rstrip()


def _numbers(count: int, size: float, meaning: str) -> Check:
    """A list of numbers from -``size`` to ``size``."""

    def check(value: Any) -> tuple[float, ...]:
        if not isinstance(value, list) or len(value) != count:
            raise ValueError
        one, _ = _number(-size, size, "")
        return tuple(one(v) for v in value)

    return check, f"give {count} numbers [{meaning}]"


def _text(value: Any) -> str:
    if not isinstance(value, str) or not value:
        raise ValueError
    return value


def _flag(value: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError
    return value


def _axis(value: Any) -> str:
    if value not in ("x", "y", "z"):
        raise ValueError
    return str(value)


def _pose(value: Any) -> int:
    word, _, number = value.partition(":") if isinstance(value, str) else ("", "", "")
    if word != "stable" or not re.fullmatch(r"[0-9]{1,3}", number):
        raise ValueError
    if not 1 <= int(number) <= MAX_POSE:
        raise ValueError
    return int(number)


_FIELDS: dict[str, Check] = {
    "name": (_text, "give a text"),
    "mass": _number(MIN_MASS, MAX_MASS, "kg"),
    "friction": _number(0.05, 2.0, ""),
    "com": _numbers(3, 1.0, "x, y, z in m"),
    "inertia": _numbers(6, 1.0, "xx, yy, zz, xy, xz, yz in kg m^2"),
    "model": (_text, "give the name of a file in the folder"),
    "scale": _number(1e-6, 1e6, "(metres per unit of the mesh file)"),
    "up": (_axis, 'give "x", "y" or "z"'),
    "pose": (_pose, f'give "stable:1" to "stable:{MAX_POSE}"'),
    "hull": (_flag, "give true or false"),
    "decompose": (_flag, "give true or false"),
}
_GRASP: dict[str, Check] = {
    "side": _number(0.0, 1.0, ""),
    "wide": _number(0.0, 1.0, ""),
    "offset": _number(0.0, 0.1, "m"),
    "yaw": _number(0.0, math.pi, "rad"),
}


def _values(
    folder: Folder, data: dict[str, Any], known: dict[str, Check], prefix: str
) -> dict[str, Any]:
    """The values of a table of TOML by key, checked.

    Args:
        folder: the object's, for messages.
        data: the table.
        known: check for every key that it may have.
        prefix: of the keys in messages.

    Raises:
        ObjectError: an unknown key or a value out of range.
    """
    found: dict[str, Any] = {}
    for name, value in data.items():
        if name not in known:
            also = ", grasp" if not prefix else ""
            raise folder.error(
                f"{FACTS}: unknown key {show(prefix + name)}; known are {', '.join(known)}{also}"
            )
        check, request = known[name]
        try:
            found[name] = check(value)
        except (ValueError, OverflowError) as error:
            raise folder.error(f"{FACTS}: {prefix}{name} is {show(value)}; {request}") from error
    return found


def model_file(folder: Folder, facts: Facts) -> str:
    """Name of the file with the object's shape.

    Raises:
        ObjectError: none, or several and ``model`` names none.
    """
    if facts.model is not None:
        name = facts.model
        if PurePosixPath(name).suffix.lower() not in (*MESHES, MJCF):
            raise folder.error(
                f"{FACTS}: model is {show(name)}; its name must end in one of "
                f"{', '.join((*MESHES, MJCF))}"
            )
        return name
    names = folder.names()
    for endings in ((MJCF,), MESHES):
        found = [n for n in names if PurePosixPath(n).suffix.lower() in endings]
        if len(found) == 1:
            return found[0]
        if found:
            raise folder.error(
                f"it holds {show(found)}; say in {FACTS} which is the object: model = "
                f"{show(found[0])}"
            )
    raise folder.error(
        f"no mesh and no MJCF in it; put a file in it that ends in one of "
        f"{', '.join((*MESHES, MJCF))}"
    )
