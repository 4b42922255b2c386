"""Reading the trials to compare from several files, and which of them count."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from sdh_sim.analysis.cases import SOURCE
from sdh_sim.errors import RecordError
from sdh_sim.records import HAND_NAME, NO_TRUTH, added_in, columns_of, is_metric, read_table
from sdh_sim.settings import DEFAULT_HAND

COMPARED = ("q_linf", "q_l1")  # metrics that every comparison needs
SURPLUS = "surplus"  # column of trials that a preset ran beyond an object's share


def user_metrics(paths: Sequence[Path]) -> dict[str, float | None]:
    """Columns of users' metrics that all the files have, each with the threshold it states.

    None where it states no threshold, or the files state different ones.
    """
    found: dict[str, set[float | None]] = {}
    for number, path in enumerate(paths):
        try:
            schema = pq.read_schema(path)
        except (pa.ArrowException, OSError):  # read_trials reports what is wrong
            return {}
        mine = {c.name: c.threshold for c in added_in(schema) if is_metric(c.name)}
        if number == 0:
            found = {name: set() for name in mine}
        found = {name: found[name] | {mine[name]} for name in found if name in mine}
    return {name: next(iter(t)) if len(t) == 1 else None for name, t in found.items()}


def hand_of(path: Path) -> str:
    """Name of the hand whose trials a file has; raises RecordError where it has no table."""
    if not columns_of([path], (HAND_NAME,)):
        return DEFAULT_HAND
    found = {name for name in read_table(path, [HAND_NAME]).column(0).to_pylist() if name}
    return found.pop() if len(found) == 1 else DEFAULT_HAND


def read_trials(
    paths: Sequence[Path], extra: Sequence[str] = (), by_hand: bool = False
) -> pa.Table:
    """The columns that a comparison needs, of the trials of several files.

    Among them are ``surplus``, whether a trial exceeds its object's share in a preset, and
    ``source``, the number of its file among those given.

    Args:
        paths: files of trials.
        extra: further columns, which every file must have.
        by_hand: trials of several hands are told apart by the name of the object, which then begins
            with that of the hand.

    Raises:
        RecordError: a file is no table of trials, or the files are of several hands unasked.
    """
    columns = ("object", "success", "failure", *dict.fromkeys((*COMPARED, *extra)))
    hands = [hand_of(path) for path in paths]
    if len(set(hands)) > 1 and not by_hand:
        raise RecordError(
            f"{paths[0]} and the others are trials of different hands "
            f"({', '.join(sorted(set(hands)))}); compare each by itself, or all with --by-hand"
        )
    tables = [_with_surplus(path, columns) for path in paths]
    if by_hand:
        tables = [_of_hand(table, hand) for table, hand in zip(tables, hands, strict=True)]
    return pa.concat_tables(_with_source(table, number) for number, table in enumerate(tables))


def _with_source(table: pa.Table, number: int) -> pa.Table:
    return table.append_column(SOURCE, pa.repeat(number, table.num_rows))


def _of_hand(table: pa.Table, hand: str) -> pa.Table:
    names = [f"{hand} {name}" for name in table.column("object").to_pylist()]
    at = table.column_names.index("object")
    return table.set_column(at, table.field(at), pa.array(names, pa.string()))


def _with_surplus(path: Path, columns: Sequence[str]) -> pa.Table:
    wanted = [name for name in columns if name != SURPLUS]
    if columns_of([path], (SURPLUS,)):
        return read_table(path, [*wanted, SURPLUS])
    table = read_table(path, wanted)
    return table.append_column(SURPLUS, pa.nulls(table.num_rows, pa.bool_()))


def groups_of(table: pa.Table) -> dict[str, np.ndarray]:
    """Which trials (n,) belong to each object, in order of appearance, and to ``overall``, last.

    With one object only there is no ``overall``.
    """
    names = np.array(table.column("object").to_pylist(), dtype=object)
    groups = {name: names == name for name in dict.fromkeys(names.tolist())}
    if len(groups) != 1:
        groups["overall"] = np.ones(len(names), dtype=bool)
    return groups


def without_truth(table: pa.Table) -> np.ndarray:
    """Trials without an outcome: infeasible, unstable, or ended as error; (n,) bool."""
    return np.array([f in NO_TRUTH for f in table.column("failure").to_pylist()], dtype=bool)


def infeasible_of(table: pa.Table) -> np.ndarray:
    """Trials whose given grasp could not be tried; (n,) bool."""
    return np.array([f == "infeasible" for f in table.column("failure").to_pylist()], dtype=bool)


def surplus_of(table: pa.Table) -> np.ndarray:
    """Trials that exceed their object's share in a preset and do not count; (n,) bool.

    Tables of earlier versions flag trials without an outcome too; they are not taken for surplus.
    """
    if SURPLUS not in table.column_names:
        return np.zeros(table.num_rows, dtype=bool)
    flags = np.array([bool(value) for value in table.column(SURPLUS).to_pylist()], dtype=bool)
    return flags & ~without_truth(table)


def without_surplus(table: pa.Table) -> pa.Table:
    """The trials that are not surplus."""
    return table.filter(pa.array(~surplus_of(table)))
