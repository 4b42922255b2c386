"""MJCF files of users as a tree: bounded, with what they include from inside the folder."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import PurePosixPath
from typing import TYPE_CHECKING
from xml.parsers import expat

from sdh_sim.errors import MjcfError

if TYPE_CHECKING:
    from sdh_sim.user_files.folder import Folder

MAX_MJCF = 1 << 20  # [bytes]
MAX_ELEMENTS = 2000
MAX_DEPTH = 16


def read_tree(folder: Folder, file: str) -> ET.Element:
    """The root of an MJCF file, with the content of what it includes in place.

    Args:
        folder: to read from.
        file: name of the MJCF relative to it; included files are named relative to this one.

    Raises:
        MjcfError: not XML, not MJCF, or over the bounds.
        SettingsError: an included file that cannot be read, or lies outside the folder.
    """
    root = _parse(folder.read(file, MAX_MJCF))
    if root.tag != "mujoco":
        raise MjcfError(f"is not MJCF: its root is <{root.tag:.40}>, expected <mujoco>")
    seen = {str(PurePosixPath(file))}
    _include(folder, PurePosixPath(file).parent, root, seen)
    _check_size(root)
    return root


def _include(folder: Folder, place: PurePosixPath, parent: ET.Element, seen: set[str]) -> None:
    """Replace every <include> below an element by the children of the file's root.

    Args:
        folder: to read from.
        place: of the MJCF file.
        parent: the element; changed in place.
        seen: names of the files included so far; each may come once, as MuJoCo has it.
    """
    for child in list(parent):
        if child.tag != "include":
            _include(folder, place, child, seen)
            continue
        name = str(place / child.attrib.get("file", ""))
        if name in seen:
            raise MjcfError(f"includes {name!r:.80} twice; MuJoCo takes each file once")
        seen.add(name)
        try:
            root = _parse(folder.read(name, MAX_MJCF))
        except MjcfError as error:
            raise MjcfError(f"includes {name!r:.80}, which {error}") from error
        if root.tag not in ("mujoco", "mujocoinclude"):
            raise MjcfError(
                f"includes {name!r:.80}, whose root is <{root.tag:.40}>, expected <mujoco> or "
                "<mujocoinclude>"
            )
        _include(folder, place, root, seen)
        at = list(parent).index(child)
        parent[at : at + 1] = list(root)


def _check_size(root: ET.Element) -> None:
    """Bounds on the whole, since included files add up."""
    for count, _ in enumerate(_with_depth(root, 1), start=1):
        if count > MAX_ELEMENTS:
            raise _too_large()


def _with_depth(element: ET.Element, depth: int) -> Iterator[int]:
    """The depth of each element of a tree; raises MjcfError where it is too deep."""
    if depth > MAX_DEPTH:
        raise _too_large()
    yield depth
    for child in element:
        yield from _with_depth(child, depth + 1)


def _too_large() -> MjcfError:
    return MjcfError(
        f"is deeper than {MAX_DEPTH} elements or has more than {MAX_ELEMENTS}; take out what is no "
        "shape"
    )


def _parse(data: bytes) -> ET.Element:
    """The tree of one file."""
    _check_text(data)
    try:
        return ET.fromstring(data)
    except (ET.ParseError, ValueError, LookupError) as error:
        raise MjcfError(f"is not XML: {error}") from error


def _check_text(data: bytes) -> None:
    """Refuse entities, and too many or too deep elements, before a tree is built of them."""
    depth = count = 0

    def start(name: str, attributes: object) -> None:
        nonlocal depth, count
        depth += 1
        count += 1
        if depth > MAX_DEPTH or count > MAX_ELEMENTS:
            raise _too_large()

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
