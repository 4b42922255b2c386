"""MJCF files of users: parsed and checked here; MuJoCo gets what was checked alone.

An object needs little of what MJCF can describe: one body with shapes, and their meshes. All else
(includes, plugins, files elsewhere, actuators, contact settings, …) is refused by name and not
ignored, because whoever wrote it expects it to have an effect.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from xml.parsers import expat

from sdh_sim.errors import MjcfError

MAX_ELEMENTS = 2000
MAX_DEPTH = 16
MAX_GEOMS = 64
MAX_MESHES = 64
SHAPES = ("sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh")
DROPPED = ("site", "freejoint")  # the scene has its own

_CHILDREN = {
    "mujoco": ("compiler", "default", "asset", "worldbody"),
    "default": ("default", "geom", "site"),
    "asset": ("mesh", "material"),
    "worldbody": ("body",),
    "body": ("geom", "site", "freejoint"),
}
_NAME = re.compile(r"[A-Za-z0-9_.-]{1,64}")
_TEXT = re.compile(r"[^<>&]{0,128}")
# What an attribute may be: so many numbers at most, one of some words, or text of a pattern.
Attribute = int | tuple[str, ...] | re.Pattern[str]
_POSE = {"pos": 3, "quat": 4, "axisangle": 4, "euler": 3, "xyaxes": 6, "zaxis": 3}
_ATTRIBUTES: dict[str, dict[str, Attribute]] = {
    "mujoco": {"model": _TEXT},
    "compiler": {
        "angle": ("radian", "degree"),
        "eulerseq": re.compile("[xyzXYZ]{3}"),
        "meshdir": _TEXT,
        "assetdir": _TEXT,
    },
    "default": {"class": _NAME},
    "mesh": {"name": _NAME, "file": _TEXT, "scale": 3},
    "material": {"name": _NAME, "rgba": 4, "specular": 1, "shininess": 1, "reflectance": 1},
    "body": {"name": _NAME, "childclass": _NAME, "pos": 3},
    "geom": {
        **{"name": _NAME, "class": _NAME, "mesh": _NAME, "material": _NAME},
        **{"type": SHAPES, "size": 3, "fromto": 6, "rgba": 4, "group": 1},
        **{"contype": 1, "conaffinity": 1},
        **_POSE,
    },
}
_REASONS = {
    "include": "it would read another file",
    "plugin": "it would run other code",
    "extension": "it would run other code",
    "inertial": "mass, com and inertia stand in object.toml",
    "joint": "the scene joins the object to the world by a free joint",
    "actuator": "an object moves nothing by itself",
    "keyframe": "the scene decides where the object is",
    "texture": "materials have colours only",
    "hfield": "shapes are " + ", ".join(SHAPES),
    "quat": "object.toml says which axis is up",
}


def parse_mjcf(data: bytes) -> ET.Element:
    """The checked tree of a user's MJCF: one body, its shapes and assets, nothing else.

    Raises:
        MjcfError: not XML, or anything in it that an object may not have.
    """
    _check_text(data)
    try:
        root = ET.fromstring(data)
    except (ET.ParseError, ValueError, LookupError) as error:
        raise MjcfError(f"is not XML: {error}") from error
    if root.tag != "mujoco":
        raise MjcfError(f"is not MJCF: its root is <{root.tag:.40}>, expected <mujoco>")
    _check(root)
    bodies = root.findall("worldbody/body")
    if len(bodies) != 1:
        raise MjcfError(f"has {len(bodies)} bodies in its worldbody; an object is one body")
    for tag, limit in (("geom", MAX_GEOMS), ("mesh", MAX_MESHES)):
        if (count := len(root.findall(f".//{tag}"))) > limit:
            raise MjcfError(f"has {count} elements <{tag}>; at most {limit} are taken")
    if not bodies[0].findall("geom"):
        raise MjcfError("has a body without geoms")
    for mesh in root.iter("mesh"):
        if "file" not in mesh.attrib:
            raise MjcfError("has a <mesh> without a file")
    for parent in list(root.iter()):
        for child in [c for c in parent if c.tag in DROPPED]:
            parent.remove(child)
    bodies[0].set("name", "object")
    bodies[0].attrib.pop("pos", None)
    return root


def _check_text(data: bytes) -> None:
    """Refuse entities, and too many or too deep elements, before a tree is built of them."""
    depth = count = 0

    def start(name: str, attributes: object) -> None:
        nonlocal depth, count
        depth += 1
        count += 1
        if depth > MAX_DEPTH or count > MAX_ELEMENTS:
            raise MjcfError(
                f"is deeper than {MAX_DEPTH} elements or has more than {MAX_ELEMENTS}; take out "
                "what is no shape"
            )

    def end(name: str) -> None:
        nonlocal depth
        depth -= 1

    def doctype(*_: object) -> None:
        raise MjcfError("declares a document type; entities are not taken: write values out")

    parser = expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except (expat.ExpatError, ValueError, LookupError) as error:
        if isinstance(error, MjcfError):
            raise
        raise MjcfError(f"is not XML: {error}") from error


def _check(element: ET.Element) -> None:
    """Raise MjcfError where an element, or one below it, has what an object may not have."""
    tag = element.tag
    allowed = _ATTRIBUTES.get(tag, {})
    if tag not in DROPPED:
        for name, value in element.attrib.items():
            where = f"{name!r:.40} of <{tag}>"
            if name not in allowed:
                raise MjcfError(f"has {where}, which an object may not have{_reason(name, tag)}")
            if not _is_valid(value, allowed[name]):
                raise MjcfError(f"has {value!r:.60} as {where}; {_expected(allowed[name])}")
    for child in element:
        name = child.tag
        if name not in _CHILDREN.get(tag, ()):
            raise MjcfError(
                f"has <{name:.40}> in <{tag}>, which an object may not have{_reason(name, tag)}"
            )
        if name in DROPPED and len(child):
            raise MjcfError(f"has <{child[0].tag:.40}> in <{name}>")
        _check(child)


def _reason(name: str, tag: str) -> str:
    """Why an element or attribute is refused, as the end of a message; may be empty."""
    if tag == "geom" and name not in _REASONS:
        return ": object.toml says mass and friction, the scene how contacts behave"
    if name == "body":
        return ": an object is one body"
    return f": {_REASONS[name]}" if name in _REASONS else ""


def _is_valid(value: str, expected: Attribute) -> bool:
    if isinstance(expected, tuple):
        return value in expected
    if isinstance(expected, re.Pattern):
        return value.isprintable() and expected.fullmatch(value) is not None
    try:
        numbers = [float(number) for number in value.split()]
    except ValueError:
        return False
    return 0 < len(numbers) <= expected and all(math.isfinite(n) and abs(n) <= 1e6 for n in numbers)


def _expected(expected: Attribute) -> str:
    if isinstance(expected, tuple):
        return f"give one of {', '.join(expected)}"
    if isinstance(expected, re.Pattern):
        return "give letters, digits, _ . -" if expected is _NAME else "it cannot be used"
    return f"give {expected} finite numbers" if expected > 1 else "give a finite number"
