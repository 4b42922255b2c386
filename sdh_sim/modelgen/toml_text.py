"""Values and tables of a TOML file as text."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def toml_value(value: object) -> str:
    """A string, number or list as TOML has it; floats to 17 decimals, no negative zero."""
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    if isinstance(value, float):
        return repr(round(value, 17) + 0.0)
    return str(value)


def toml_table(name: str, values: dict[str, object]) -> list[str]:
    """Lines of a table, after an empty one."""
    return ["", f"[{name}]", *(f"{key} = {toml_value(value)}" for key, value in values.items())]


def toml_array(
    kind: str,
    columns: int,
    pitch: float,
    profile: np.ndarray,
    missing: Sequence[Sequence[int]] = (),
) -> list[str]:
    """Lines of a kind of tactile array in ``hand.toml``.

    Args:
        kind: its name.
        columns: how many.
        pitch: between two columns [m].
        profile: per row from the tip down x [mm], z [mm] and tilt [deg], (rows, 3).
        missing: row and column of each taxel that does not exist.
    """
    lines = toml_table(f"arrays.{kind}", {"columns": columns, "pitch": pitch})
    lines.append("profile = [  # per row from the tip down: x mm, z mm, tilt deg")
    lines += [f"    {toml_value(list(map(float, row)))}," for row in profile]
    lines.append("]")
    if missing:
        lines.append(f"missing = {toml_value(missing)}")
    return lines
