"""Compare committed model files with what their generator writes."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")


def model_files(folder: Path) -> list[Path]:
    """Meshes, MJCF and descriptions of hands below a folder, relative to it."""
    found = (p for p in folder.rglob("*") if p.suffix in {".obj", ".xml"} or p.name == "hand.toml")
    return sorted(p.relative_to(folder) for p in found)


def assert_same_files(made: Path, kept: Path, names: Iterable[Path], script: str) -> None:
    """Every file written in ``made`` is one of ``names`` in ``kept``, with the same content."""
    written = sorted(p.relative_to(made) for p in made.rglob("*") if p.is_file())
    assert written == sorted(names)
    for path in written:
        new, old = (made / path).read_text(), (kept / path).read_text()
        if new == old:
            continue
        # Other builds of NumPy may round a last digit the other way: nothing more may differ.
        assert NUMBER.sub("", new) == NUMBER.sub("", old), f"{path}: run {script}"
        values = [np.array(NUMBER.findall(text), dtype=float) for text in (new, old)]
        assert values[0] == pytest.approx(values[1], rel=1e-4, abs=2e-6), str(path)
