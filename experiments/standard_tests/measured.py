"""Measured values of a user's hand, from a YAML file, to be set beside the simulated ones.

    hand: SDH-2, our laboratory
    values:
      finger_strength:
        thumb, straight, whole finger: 12.8 N
      grasp_strength:
        pinch, 60.3 mm, across: 15.1 N

Protocols and conditions are those of the table; every value is a number and its unit.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from pathlib import Path
from typing import NoReturn

from experiments.standard_tests.result_lines import UNITS, Line
from sdh_sim.errors import SettingsError
from sdh_sim.grasp_files.grasp_entry import FormatError
from sdh_sim.grasp_files.yaml_reader import read_yaml

KEYS = ("hand", "values")
LARGEST_FILE, NODES = 1 << 20, 10_000  # [bytes]


def read_measured(path: Path) -> tuple[str, dict[tuple[str, str], float]]:
    """Name of the measured hand, and its values by protocol and condition.

    Raises:
        SettingsError: a file that cannot be read, an unknown key, or a value that is none.
    """

    def refuse(message: str) -> NoReturn:
        raise SettingsError(f"--measured: {path}: {message}")

    try:
        data = path.read_bytes()
    except OSError as error:
        refuse(f"{error.strerror or error}; give a YAML file")
    if len(data) > LARGEST_FILE:
        refuse(f"{len(data)} bytes; at most {LARGEST_FILE} are read")
    try:
        document = read_yaml(data, NODES)
    except FormatError as error:
        refuse(str(error))
    if not isinstance(document, dict):
        refuse("expected the keys hand and values")
    for key in document:
        if key not in KEYS:
            refuse(f"unknown key {key!r:.80}; known are {', '.join(KEYS)}")
    hand, values = document.get("hand", ""), document.get("values")
    if not isinstance(hand, str):
        refuse(f"hand: got {hand!r:.80}; give a name")
    if not isinstance(values, dict):
        refuse(f"values: got {values!r:.80}; give conditions under {', '.join(UNITS)}")
    found: dict[tuple[str, str], float] = {}
    for protocol, conditions in values.items():
        if protocol not in UNITS:
            refuse(f"values: unknown protocol {protocol!r:.80}; known are {', '.join(UNITS)}")
        if not isinstance(conditions, dict):
            refuse(f"{protocol}: got {conditions!r:.80}; give conditions with their values")
        for condition, value in conditions.items():
            where = f"{protocol}: {condition}"
            found[protocol, str(condition)] = _number(value, UNITS[protocol], where, refuse)
    return hand, found


def _number(value: object, unit: str, where: str, refuse) -> float:
    """A number with its unit."""
    words = value.split() if isinstance(value, str) else []
    example = f"12.3 {unit}"
    if len(words) != 2:
        refuse(f"{where:.200}: got {value!r:.80}; give a number and its unit, as in {example}")
    if words[1] != unit:
        refuse(f"{where:.200}: got the unit {words[1]!r:.20}; give {unit}, as in {example}")
    try:
        number = float(words[0])
    except ValueError:
        number = math.nan
    if not (math.isfinite(number) and number >= 0.0):
        refuse(f"{where:.200}: got {words[0]!r:.40}; give a number of at least 0, as in {example}")
    return number


def check_conditions(
    path: Path, measured: Iterable[tuple[str, str]], conditions: Iterable[tuple[str, str]]
) -> None:
    """Refuse measured values of conditions that no test has.

    Args:
        path: of the file, for the message.
        measured: protocols and conditions of the file.
        conditions: those of the tests that were run or will be.

    Raises:
        SettingsError: a condition that is none.
    """
    known = set(conditions)
    tested = {protocol for protocol, _ in known}
    for protocol, condition in measured:
        if protocol not in tested or (protocol, condition) in known:
            continue
        names = [c for p, c in known if p == protocol]
        near = difflib.get_close_matches(condition, names, 1, 0.0)
        raise SettingsError(
            f"--measured: {path}: {protocol}: unknown condition {condition!r:.120}; the nearest is "
            f"{near[0]!r}"
        )


def conditions_of(lines: Iterable[Line]) -> set[tuple[str, str]]:
    """Protocol and condition of every line."""
    return {(line.protocol, line.condition) for line in lines}
