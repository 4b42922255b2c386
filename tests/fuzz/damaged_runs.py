"""Damaged trials.parquet, shards and run.json; ``frame`` says how to run this by hand.

Only RunError, RecordError and SettingsError with one line each may come out.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from sdh_sim.errors import RecordError, RunError, SettingsError
from sdh_sim.records import normalise, read_rows, read_table, write_rows
from sdh_sim.runs import RunFolder
from tests.fuzz.frame import Target, main, mutated
from tests.support.trial_stand_ins import make_row, plan

PLAN = plan(4)


_ODD: list[Any] = [
    *(None, True, -1, 0, 1, 2**31, 2**63, 2**64, 1e308, float("inf"), float("nan"), 0.5),
    *("", "box", "x" * 5000, "\n", "\ud800", [], {}, [[]], {"a": 1}, ["box", "box"], 10**400),
    *([1, 2], [1, "2"], ["box"] * 100_000),
]


def odd_json(document: Any, rng: np.random.Generator) -> Any:
    """The document with one value replaced, one key dropped or one added, anywhere in it."""
    if isinstance(document, dict) and document and rng.integers(5):
        out = dict(document)
        key = str(rng.choice(list(out)))
        match int(rng.integers(8)):
            case 0:
                del out[key]
            case 1:
                out[str(rng.choice(["", "object", "x", "format"]))] = _odd(rng)
            case _:
                out[key] = odd_json(out[key], rng)
        return out
    if isinstance(document, list) and document and rng.integers(3):
        out = list(document)
        at = int(rng.integers(len(out)))
        out[at] = odd_json(out[at], rng)
        return out
    return _odd(rng)


def _odd(rng: np.random.Generator) -> Any:
    return _ODD[int(rng.integers(len(_ODD)))]


def odd_table(table: pa.Table, rng: np.random.Generator) -> pa.Table:
    """A sound parquet table that is none of ours: types, nulls, values, columns, rows."""
    at = int(rng.integers(table.num_columns))
    name = table.column_names[at]
    count = table.num_rows
    values: list[Any] = [
        *([None] * count, [2**62] * count, [float("nan")] * count, [True] * count),
        *(["\n" * 9] * count, ["none"] * count, [-1] * count, [b"\xff"] * count),
        *([[1.0] * 7] * count, [[]] * count),
    ]
    match int(rng.integers(5)):
        case 0:
            return table.remove_column(at)
        case 1:
            return table.append_column(name, table.column(name))
        case 2:
            return table.take(pa.array(rng.integers(count, size=int(rng.integers(1, 20)))))
        case 3:
            column = pa.array(values[int(rng.integers(len(values)))])
            return table.set_column(at, name, column)
        case _:
            kind = table.schema.field(at).type
            column = pa.nulls(count, kind)
            if rng.integers(2) and pa.types.is_integer(kind):
                column = pa.array(rng.integers(-(2**63), 2**63 - 1, size=count), kind)
            elif pa.types.is_string(kind):
                column = pa.array(["\ud7ff" * 3] * count, kind)
            return table.set_column(at, pa.field(name, kind), column)


class DamagedRun(Target):
    """A small run folder and the ways to damage and read it."""

    refusals = (RecordError, RunError, SettingsError)

    def __init__(self, path: Path) -> None:
        self.folder = RunFolder(path)
        rows = [
            normalise({**make_row(j.settings.object, j.seed), "trial": j.trial})
            for j in PLAN.jobs()
        ]
        write_rows(rows[:6], self.folder.table)
        self.folder.open_finished(PLAN).append(rows[6:])
        self.folder.write_info(PLAN, [{"state": "running", "versions": {"python": "3"}}])
        (self.shard,) = self.folder.shards.iterdir()
        self.good = {p: p.read_bytes() for p in (self.folder.table, self.folder.info, self.shard)}
        self.table = read_table(self.folder.table)
        self.document = json.loads(self.good[self.folder.info])

    def damage(self, rng: np.random.Generator) -> str:
        """Make all files sound again, then damage one; says which and how."""
        for path, data in self.good.items():
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(data)
        table, info = self.folder.table, self.folder.info
        match int(rng.integers(6)):
            case 0 | 1:
                table.write_bytes(mutated(self.good[table], rng))
                return "table bytes"
            case 2:
                pq.write_table(odd_table(self.table, rng), table)
                return "table content"
            case 3:
                info.write_bytes(mutated(self.good[info], rng))
                return "run.json bytes"
            case 4:
                info.write_text(json.dumps(odd_json(self.document, rng)))
                return "run.json content"
            case _:
                self.shard.write_bytes(mutated(self.good[self.shard], rng))
                return "shard bytes"

    def readers(self) -> list[Callable[[], object]]:
        """Everything that reads a run."""
        folder = self.folder

        def by_plan() -> object:
            stored = folder.read_plan()
            stored.changes_from(PLAN)
            return [next(folder.finished(stored), None), folder.open_finished(stored, True).kept]

        return [
            lambda: read_rows(folder.table),
            lambda: read_table(folder.table, ["object", "success", "failure"]),
            lambda: list(folder.finished(PLAN)),
            by_plan,
        ]


if __name__ == "__main__":
    main(DamagedRun)
