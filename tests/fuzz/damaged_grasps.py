"""Damaged files of grasps in every format; ``frame`` says how to run this by hand.

Only GraspFileError with one line may come out, within bounded time and memory.
"""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from sdh_sim.errors import GraspFileError
from sdh_sim.grasp_files import read_grasps, write_grasps
from sdh_sim.grasp_files.grasp_entry import COLUMNS
from tests.fuzz.damaged_runs import odd_json, odd_table
from tests.fuzz.frame import Target, main, mutated
from tests.support.grasp_entries import entries

MEMORY = 4 << 30  # [bytes] of address space: a claim of more must be refused, not tried
OBJECTS = ("box", "oval_bottle")
FORMATS = ("parquet", "csv", "json", "yaml")
_WORDS = (
    *("nan", "inf", "-1e308", "1e-300", "1_0", "0x1p3", "९", "1e5", "99999999999999999999", ""),
    *("~", "null", "true", "[]", "{}", "[[", "]", "{", "}", ":", "? ", "- ", "|", ">", "%YAML 3"),
    *("&a", "*a", "!!binary aGk=", "!!python/name:os.abort", "<<", "---", "...", "'", '"', "\t"),
    *("\n", "\r", "\0", "\x1b", "\ufeff", "\u202e", "\u2028", "é", "\\ud800", "\\x00", '"\\', ";"),
    *("palm_x", "preshape", "open_spread", "object", "name", "spread_coupled", "parallel", "fist"),
    *("format", "grasps", "cspace_position", "x" * 5000, "," * 300, "[" * 2000, "{a: " * 200),
)


def words_changed(data: bytes, rng: np.random.Generator) -> bytes:
    """The text with a few of its parts replaced by words that mean something to a format."""
    for _ in range(int(rng.integers(1, 4))):
        at = int(rng.integers(len(data) + 1))
        end = min(len(data), at + int(rng.integers(0, 25)))
        if rng.integers(2):  # a whole value
            stops = [data.find(s, at) for s in (b",", b"\n", b":")]
            end = min((s for s in stops if s >= 0), default=end)
        word = _WORDS[int(rng.integers(len(_WORDS)))].encode()
        data = data[:at] + word + data[end:]
    return data


class DamagedGrasps(Target):
    """A file of grasps in one of the formats and the ways to damage and read it."""

    refusals = (GraspFileError,)

    def __init__(self, path: Path) -> None:
        self.folder = path
        self.good: dict[str, bytes] = {}
        for kind in FORMATS:
            file = path / f"grasps.{kind}"
            write_grasps(entries(6, OBJECTS if kind != "yaml" else OBJECTS[:1]), file)
            self.good[kind] = file.read_bytes()
        self.table = pq.read_table(io.BytesIO(self.good["parquet"]))
        self.rows = json.loads(self.good["json"])
        self.path = path

    def damage(self, rng: np.random.Generator) -> str:
        """Write one damaged file; says which and how."""
        kind = FORMATS[int(rng.integers(len(FORMATS)))]
        how = ("bytes", "content")[int(rng.integers(2))]
        self.path = self.folder / f"grasps.{kind}"
        if how == "bytes":
            data = mutated(self.good[kind], rng)
        elif kind == "parquet":
            sink = pa.BufferOutputStream()
            pq.write_table(odd_table(self.table, rng), sink)
            data = sink.getvalue().to_pybytes()
        elif kind == "json" and rng.integers(2):
            # Python writes NaN and lone surrogates that are no JSON: a reader meets them, too.
            text = json.dumps(odd_json(self.rows, rng), ensure_ascii=bool(rng.integers(2)))
            data = text.encode("utf-8", "surrogatepass")
        else:
            data = words_changed(self.good[kind], rng)
        self.path.write_bytes(data)
        return f"{kind} {how}"

    def readers(self) -> list[Callable[[], object]]:
        """Reading with and without names of objects; what is read can be written."""

        def read_and_write() -> None:
            objects = OBJECTS if self.path.suffix != ".yaml" else OBJECTS[:1]
            found = read_grasps(self.path, objects)
            assert found
            for entry in found:
                assert entry.object in objects
                assert np.isfinite(entry.palm_pose).all()
                assert abs(np.linalg.norm(entry.palm_pose[3:]) - 1) < 2e-6
                assert set(entry.values()) == set(COLUMNS)
            again = self.folder / f"again{self.path.suffix}"
            write_grasps(found, again)
            second = [entry.values() for entry in read_grasps(again, objects)]
            assert second == [entry.values() for entry in found] or self.path.suffix == ".yaml"

        return [read_and_write, lambda: read_grasps(self.path)]

    def check_message(self, text: str) -> None:
        """It says that the file is at fault, and can be printed."""
        assert text.startswith(f"grasps: {self.path}: ")
        assert text.isprintable()
        assert len(text) < 1000


if __name__ == "__main__":
    main(DamagedGrasps, MEMORY)
