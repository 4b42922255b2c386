"""A user's hand: a folder with ``hand.toml``, its MJCF and meshes, read and checked once.

The page Extending of the documentation says what a folder must hold.
"""

from __future__ import annotations

import dataclasses
from functools import lru_cache
from pathlib import Path

import mujoco

from sdh_sim.errors import HandError, MjcfError, SettingsError, one_line
from sdh_sim.robot.hand import built_in_hand
from sdh_sim.robot.hand_checks import check_hand, exclude_overlaps
from sdh_sim.robot.hand_description import Hand
from sdh_sim.robot.hand_file import model_of, read_hand_file
from sdh_sim.robot.hand_mjcf import read_mjcf
from sdh_sim.robot.hand_model import complete, make_servos, name_parts, spans_of
from sdh_sim.robot.toml_table import FILE
from sdh_sim.user_files.folder import Folder, FolderKind
from sdh_sim.user_references import HandFolder

HAND_KIND = FolderKind("hand", HandError, f"{FILE} and the MJCF file that it names")
MAX_TOML = 64 << 10  # [bytes]
LONGEST_NOTE = 1000  # characters


def read_hand_folder(path: str | Path) -> Hand:
    """The hand of a folder.

    Args:
        path: of the folder, or of the file in it that is its ``hand.toml``, by another name where
            the folder has the models of several hands.

    Raises:
        HandError: anything in it that cannot be used, in one line.
    """
    given = Path(path)
    named = given.suffix == ".toml"
    folder = Folder(given.parent if named else given, HAND_KIND)
    toml = given.name if named else FILE
    text = folder.read(toml, MAX_TOML)
    try:
        file, angle = model_of(text)
    except HandError as error:
        raise folder.error(f"{toml}: {error}") from error
    try:
        spec, dropped = read_mjcf(folder, file, angle)
    except MjcfError as error:
        raise folder.error(f"{file} {error}") from error
    notes = [f"ignored, as it is no shape or mechanics: {', '.join(dropped)}"] if dropped else []
    try:
        name_parts(spec)
        make_servos(spec)
        spans = spans_of(_compiled(spec))
        described = read_hand_file(text, folder.path, lambda _: spans)
        notes += complete(spec, described)
        _compiled(spec)
        hand = dataclasses.replace(described, made=spec)
        notes += exclude_overlaps(spec, hand)
        check_hand(hand)
    except (SettingsError, MjcfError) as error:
        raise folder.error(f"{error}" if _says_file(error) else f"{toml}: {error}") from error
    place = folder.path / toml if named else folder.path
    reference = HandFolder(str(place), folder.sha256(), tuple(map(_printable, notes)))
    return dataclasses.replace(hand, folder=reference)


@lru_cache(maxsize=8)
def hand_of(reference: HandFolder) -> Hand:
    """The hand of a reference, read once per process.

    Raises:
        HandError: the folder cannot be used, or holds another hand than it did.
    """
    hand = read_hand_folder(reference.path)
    if hand.folder is None or hand.folder.sha256 != reference.sha256:
        raise HandError(
            f"hand: {reference.path}: its files have changed since the run began; put them back, "
            "or begin another run"
        )
    return hand


def hand_named(name: str, folder: HandFolder | None = None) -> Hand:
    """The hand of a setting: a user's folder where there is one, else a built-in one by its name.

    Raises:
        HandError: no such hand, or a folder that cannot be used.
    """
    return hand_of(folder) if folder is not None else built_in_hand(name)


def _compiled(spec: mujoco.MjSpec) -> mujoco.MjModel:
    try:
        return spec.copy().compile()
    except (ValueError, TypeError, mujoco.FatalError, mujoco.UnexpectedError) as error:
        reason = " ".join(str(error).split())[:160]
        raise MjcfError(f"the model cannot be compiled: {reason}") from error


def _says_file(error: Exception) -> bool:
    return str(error).startswith("the model")


def _printable(text: str) -> str:
    """A note in one line of a length that a reference may have."""
    clean = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)
    return one_line(clean, LONGEST_NOTE)
