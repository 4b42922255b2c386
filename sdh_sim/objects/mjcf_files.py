"""MJCF files of users: checked here, and brought to one body; MuJoCo gets what was checked alone.

``mjcf_words`` says what counts, what is ignored and what is refused.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from typing import TYPE_CHECKING

from sdh_sim.errors import MjcfError
from sdh_sim.objects.mjcf_words import (
    ATTRIBUTES,
    CHILDREN,
    IGNORED_ATTRIBUTES,
    IGNORED_ELEMENTS,
    NAME,
    NEUTRAL,
    POSE,
    REASONS,
    SHAPES,
    Attribute,
)
from sdh_sim.user_files.mjcf_tree import read_tree

if TYPE_CHECKING:
    from sdh_sim.user_files.folder import Folder

MAX_GEOMS = 64
MAX_MESHES = 64
_TURNS = tuple(name for name in POSE if name != "pos")


@dataclass(frozen=True)
class ObjectTree:
    """A user's MJCF as one body with its shapes and assets.

    Attributes:
        root: of the tree; its worldbody has the body ``object`` and nothing else. Every geom has a
            name.
        ignored: names of the elements and attributes that do not count.
    """

    root: ET.Element
    ignored: tuple[str, ...]


def parse_mjcf(folder: Folder, file: str) -> ObjectTree:
    """The checked tree of a user's MJCF.

    Args:
        folder: to read from.
        file: name of the MJCF relative to it.

    Raises:
        MjcfError: not MJCF, or something in it that an object may not have.
        ObjectError: a file that cannot be read.
    """
    root = read_tree(folder, file)
    ignored: set[str] = set()
    _take_out_floors(root, ignored)
    _check(root, ignored)
    for tag, limit in (("geom", MAX_GEOMS), ("mesh", MAX_MESHES)):
        if (count := len(root.findall(f".//{tag}"))) > limit:
            raise MjcfError(f"has {count} elements <{tag}>; at most {limit} are taken")
    _to_one_body(root, ignored)
    for mesh in root.findall("asset/mesh"):
        if "file" not in mesh.attrib and "vertex" not in mesh.attrib:
            raise MjcfError("has a <mesh> without a file or vertex")
    for number, geom in enumerate(root.find("worldbody").iter("geom")):  # type: ignore[union-attr]
        geom.attrib.setdefault("name", f"geom:{number}")
    return ObjectTree(root, tuple(sorted(ignored)))


def _take_out_floors(root: ET.Element, ignored: set[str]) -> None:
    """Take planes out of the worldbody, also those that a default class makes planes."""
    kinds: dict[str, str] = {}

    def read(default: ET.Element, inherited: str) -> None:
        own = [g.attrib["type"] for g in default.findall("geom") if "type" in g.attrib]
        kind = own[-1] if own else inherited
        kinds[default.get("class", "main")] = kind
        for child in default.findall("default"):
            read(child, kind)

    for default in root.findall("default"):
        read(default, kinds.get("main", "sphere"))
    for world in root.findall("worldbody"):
        for geom in world.findall("geom"):
            kind = kinds.get(geom.get("class", "main"), "sphere")
            if geom.get("type", kind) == "plane":
                world.remove(geom)
                ignored.add("plane")


def _to_one_body(root: ET.Element, ignored: set[str]) -> None:
    """Make the fixed bodies and geoms of the worldbody one body ``object``.

    Bodies inside others become frames, which is what fixed bodies are.
    """
    worlds = root.findall("worldbody")
    every = [element for world in worlds for element in world]
    top = [element for element in every if next(element.iter("geom"), None) is not None]
    moving = [element for element in top if _takes_free_joint(element)]
    if moving:
        ignored.add("freejoint")
    if len(moving) > 1:
        raise MjcfError(
            f"has {len(moving)} bodies that move; an object is one body: keep one of them"
        )
    if moving and len(top) > 1:
        raise MjcfError(
            "has a body that moves beside what is fixed to the world; an object is one body: keep "
            "the one or the other"
        )
    for element in top:
        _check_fixed(element)
    if len(top) == 1 and top[0].tag == "body":
        body = _as_object(top[0])
    else:
        body = ET.Element("body", {"name": "object"})
        body.extend(_as_frame(element) for element in top)
    if body.find(".//geom") is None:
        raise MjcfError("has no geom in its worldbody; an object is one body of geoms")
    for world in worlds:
        root.remove(world)
    ET.SubElement(root, "worldbody").append(body)


def _takes_free_joint(element: ET.Element) -> bool:
    """Remove the free joint of a body at the top; whether it had one."""
    joints = [child for child in element if child.tag in ("joint", "freejoint")]
    free = [j for j in joints if j.tag == "freejoint" or j.get("type") == "free"]
    for joint in free:
        element.remove(joint)
    return bool(free)


def _check_fixed(element: ET.Element) -> None:
    """Raise MjcfError where something below an element moves by itself."""
    for joint in [*element.iter("joint"), *element.iter("freejoint")]:
        raise MjcfError(f"has <{joint.tag}> in a body inside another{_reason('joint')}")


def _as_object(body: ET.Element) -> ET.Element:
    """The only body of a file as the object: where it is does not count, how it is turned does."""
    made = ET.Element("body", {"name": "object"})
    if "childclass" in body.attrib:
        made.set("childclass", body.attrib["childclass"])
    turn = {name: value for name, value in body.attrib.items() if name in _TURNS}
    inside = ET.SubElement(made, "frame", turn) if turn else made
    inside.extend(_as_frame(child) for child in body)
    return made


def _as_frame(element: ET.Element) -> ET.Element:
    """An element with the bodies in it as frames; a geom stays as it is."""
    if element.tag == "geom":
        return element
    kept = {k: v for k, v in element.attrib.items() if k in POSE or k == "childclass"}
    frame = ET.Element("frame", kept)
    frame.extend(_as_frame(child) for child in element)
    return frame


def _check(element: ET.Element, ignored: set[str], parent: str = "") -> None:
    """Take out of an element, and of those below it, what does not count.

    Args:
        element: changed in place.
        ignored: names of what was taken out; added to.
        parent: what the element stands in.

    Raises:
        MjcfError: it has what an object may not have.
    """
    tag = element.tag
    allowed = ATTRIBUTES.get(tag, {})
    if (parent, tag) == ("default", "geom"):
        allowed = {**allowed, "type": (*SHAPES, "plane")}  # of floors, which were taken out
    for name, value in list(element.attrib.items()):
        where = f"{name!r:.40} of <{tag}>"
        if name in allowed:
            if not _is_valid(value, allowed[name]):
                reason = _reason("joint") if tag == "joint" else f"; {_expected(allowed[name])}"
                raise MjcfError(f"has {value!r:.60} as {where}{reason}")
            if name in ("mass", "density"):
                ignored.add(name)
        elif tag in ("joint", "freejoint") or _is_ignored(tag, name, value):
            del element.attrib[name]
            if tag not in ("joint", "freejoint"):
                ignored.add(name)
        else:
            raise MjcfError(f"has {where}, which an object may not have{_reason(name)}")
    if tag == "joint" and element.get("type") != "free":
        raise MjcfError(f"has <joint> of a type that is not free{_reason('joint')}")
    for child in list(element):
        name = child.tag
        if name in IGNORED_ELEMENTS.get(tag, ()):
            element.remove(child)
            ignored.add(name)
        elif name in CHILDREN.get(tag, ()):
            _check(child, ignored, tag)
        else:
            raise MjcfError(
                f"has <{name:.40}> in <{tag}>, which an object may not have{_reason(name)}"
            )


def _is_ignored(tag: str, name: str, value: str) -> bool:
    if (tag, name) not in NEUTRAL:
        return name in IGNORED_ATTRIBUTES.get(tag, ())
    neutral = NEUTRAL[tag, name]
    try:
        return value in neutral or float(value) in neutral
    except ValueError:
        return False


def _reason(name: str) -> str:
    """Why an element or attribute is refused, as the end of a message; may be empty."""
    return f": {REASONS[name]}" if name in REASONS else ""


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
        return "give letters, digits, _ . -" if expected is NAME else "it cannot be used"
    return f"give {expected} finite numbers" if expected > 1 else "give a finite number"
