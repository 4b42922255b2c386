"""The hand that settings or a user's words mean."""

from __future__ import annotations

import os
from pathlib import Path

from sdh_sim.errors import HandError
from sdh_sim.robot.hand import built_in_hand, built_in_hands
from sdh_sim.robot.hand_description import Hand
from sdh_sim.robot.hand_folder import hand_named, read_hand_folder
from sdh_sim.settings import TrialSettings
from sdh_sim.user_references import HandFolder


def hand_in(settings: TrialSettings) -> Hand:
    """The hand of a trial's settings; raises HandError as ``hand_named``."""
    return hand_named(settings.hand, settings.hand_folder)


def find_hand(word: str) -> tuple[str, HandFolder | None]:
    """Name of the hand that a user asks for, and the folder of the user's own.

    Args:
        word: name of a built-in hand, or a path.

    Raises:
        HandError: no such hand, a folder that cannot be used, or the name of a built-in hand.
    """
    if "/" not in word and os.sep not in word and not Path(word).is_dir():
        return built_in_hand(word).name, None
    hand = read_hand_folder(word)
    if hand.name in built_in_hands():
        raise HandError(
            f"hand: {word}: the name {hand.name!r} is a built-in hand's; set another name in its "
            "hand.toml"
        )
    return hand.name, hand.folder
