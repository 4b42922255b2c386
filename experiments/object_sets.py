"""Sets of objects as others publish them, made into folders that this testbed reads.

A set is a folder of MJCF files (robosuite), of folders with a mesh or MJCF each (YCB, Google
Scanned Objects), or of mesh files. Nothing in it is changed: files are copied to another folder.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from sdh_sim.errors import SettingsError
from sdh_sim.objects import UserObject, object_names, user_object
from sdh_sim.objects.facts import MESHES, MJCF
from sdh_sim.objects.facts_file import MAX_MASS, MIN_MASS, RESERVED

MAX_FILES = 300  # copied for one object
MAX_BYTES = 256 << 20  # of these together
# Of several meshes in an object's folder, the first of these: cleaned scans, then models.
PREFERRED = (
    *("google_16k/nontextured.stl", "google_16k/textured.obj", "nontextured.stl", "textured.obj"),
    *("meshes/model.obj", "model.obj", "collision.obj", "visual.obj"),
)


@dataclass(frozen=True)
class Candidate:
    """A file that may be an object's shape.

    Attributes:
        name: of the object in tables.
        file: with the shape.
        root: folder that the file may refer to.
    """

    name: str
    file: Path
    root: Path


@dataclass(frozen=True)
class Assumed:
    """What a set does not say of its objects.

    Attributes:
        mass: [kg], where an MJCF states none.
        friction: Coulomb's coefficient against the pads.
        scale: metres per unit of the mesh files.
        up: axis that points up.
        shape: what becomes of a shape that is not convex: ``hull``, ``decompose`` or ``refuse``.
    """

    mass: float
    friction: float
    scale: float
    up: str
    shape: str


@dataclass(frozen=True)
class Loaded:
    """An object of a set.

    Attributes:
        obj: as the testbed reads it.
        mass: that it has [kg].
        notes: what was assumed and done.
    """

    obj: UserObject
    mass: float
    notes: tuple[str, ...]


def find_candidates(folder: Path) -> list[Candidate]:
    """The objects of a set, by name; empty where there are none.

    Raises:
        OSError: the folder cannot be read.
    """
    entries = sorted(folder.iterdir())
    files = [path for path in entries if path.is_file()]
    found = [(p.stem, p, folder) for p in files if p.suffix.lower() == MJCF]
    if not found:
        for path in entries:
            shape = _shape_in(path) if path.is_dir() else None
            if shape is not None:
                found.append((path.name, shape, path))
    if not found:
        found = [(p.stem, p, folder) for p in files if p.suffix.lower() in MESHES]
    taken: set[str] = {*object_names(), *RESERVED}
    candidates = []
    for stem, file, root in found:
        name = _usable_name(stem, taken)
        taken.add(name)
        candidates.append(Candidate(name, file, root))
    return candidates


def _shape_in(folder: Path) -> Path | None:
    """The file with the shape in an object's folder."""
    files = [path for path in _files(folder) if path.suffix.lower() in (*MESHES, MJCF)]
    for path in files:
        if path.suffix.lower() == MJCF and path.parent == folder:
            return path
    for wanted in PREFERRED:
        for path in files:
            if path.relative_to(folder).as_posix() == wanted:
                return path
    meshes = [path for path in files if path.suffix.lower() in MESHES]
    return meshes[0] if meshes else None


def _files(folder: Path) -> Iterator[Path]:
    """Files below a folder, those nearer to it first; links are left out."""
    entries = sorted(folder.iterdir())
    yield from (path for path in entries if path.is_file() and not path.is_symlink())
    for path in entries:
        if path.is_dir() and not path.is_symlink():
            yield from _files(path)


def _usable_name(stem: str, taken: set[str]) -> str:
    """A name that a table takes, unlike those taken."""
    name = re.sub(r"[^A-Za-z0-9_-]", "_", stem)[:40]
    if not name[:1].isalpha():
        name = f"object_{name}"
    number, free = 2, name
    while free in taken:
        free, number = f"{name}_{number}", number + 1
    return free


def load(candidate: Candidate, assumed: Assumed, place: Path) -> Loaded:
    """The object of a set in a folder of its own below ``place``.

    It is first tried as it is. A shape that is not convex or falls over is then taken as its hull
    (or what else is assumed) and in its nearest stable pose.

    Raises:
        SettingsError: the testbed cannot take it; the message says why.
        OSError: its files cannot be copied.
    """
    folder = place / candidate.name
    _copy(candidate, folder)
    shape = {"hull": "hull = true", "decompose": "decompose = true"}.get(assumed.shape, "")
    choices = [("",), ('pose = "stable:1"',)]
    choices += [(shape, *choice) for choice in choices] if shape else []
    first: SettingsError | None = None
    for lines in choices:
        try:
            obj = _read(candidate, folder, assumed, lines)
        except SettingsError as error:
            first = first or error
            continue
        notes = tuple(line for line in lines if line)
        if obj.stated_mass is None:
            return Loaded(obj, assumed.mass, notes)
        mass = min(max(obj.stated_mass, MIN_MASS), MAX_MASS)
        if mass != obj.stated_mass:
            notes += (f"the file says {obj.stated_mass:.2g} kg",)
        own = replace(assumed, mass=mass)
        return Loaded(_read(candidate, folder, own, lines), mass, notes)
    assert first is not None
    raise first


def _read(
    candidate: Candidate, folder: Path, assumed: Assumed, lines: tuple[str, ...]
) -> UserObject:
    """The object with what is assumed, and more lines, in its object.toml."""
    file = candidate.file.relative_to(candidate.root).as_posix()
    scale = "" if file.lower().endswith(MJCF) else f"scale = {assumed.scale!r}"
    facts = (
        f'name = "{candidate.name}"',
        f"mass = {assumed.mass!r}",
        f"friction = {assumed.friction!r}",
        f'up = "{assumed.up}"',
        f"model = {_quoted(file)}",
        scale,
        *lines,
    )
    (folder / "object.toml").write_text("\n".join(facts) + "\n", encoding="utf-8")
    return user_object(folder)


def _quoted(text: str) -> str:
    """A text as a string of TOML."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _copy(candidate: Candidate, folder: Path) -> None:
    """Copy a shape and what it may refer to.

    Raises:
        SettingsError: too many files or bytes.
        OSError: a file cannot be copied.
    """
    folder.mkdir(parents=True)
    is_mjcf = candidate.file.suffix.lower() == MJCF
    kinds = (*MESHES, MJCF, ".mtl") if is_mjcf else (".mtl",)
    wanted = [p for p in _files(candidate.root) if p.suffix.lower() in kinds]
    wanted = [candidate.file, *(p for p in wanted if p != candidate.file)]
    size = sum(path.stat().st_size for path in wanted)
    if len(wanted) > MAX_FILES or size > MAX_BYTES:
        raise SettingsError(
            f"object: {candidate.root} holds {len(wanted)} files of {size} bytes for one object; "
            f"at most {MAX_FILES} of {MAX_BYTES} bytes are copied"
        )
    for path in wanted:
        target = folder / path.relative_to(candidate.root)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, target)
