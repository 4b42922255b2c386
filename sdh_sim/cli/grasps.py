"""``sdh-sim grasps``: the grasps of a run as a file, to edit, share and lift again."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from sdh_sim.cli.console import errors, output
from sdh_sim.errors import RunError
from sdh_sim.grasp_files import GraspEntry, check_ending, write_grasps
from sdh_sim.records import NO_TRUTH, TrialRow
from sdh_sim.runs import RunFolder
from sdh_sim.settings import DEFAULT_HAND


def write(run: Path, out: Path, objects: Sequence[str] = (), *, only_held: bool = False) -> None:
    """Write the grasps of a run's finished trials, each once, in the order of the table.

    Ratio and yaw are those that the trial had, so that lifting them again repeats it; the
    confidence is the share of a grasp's trials that held.

    Args:
        run: run folder.
        out: file to write.
        objects: names of the objects whose grasps are written; none: all.
        only_held: leave out grasps of which no trial held.

    Raises:
        RunError: no such run or object, no grasp to write, or a file that cannot be written.
        GraspFileError: the file's ending is no format, or grasps of several objects in YAML.
    """
    check_ending(out)
    folder = RunFolder(run)
    plan = folder.read_plan()
    if plan.settings.hand != DEFAULT_HAND:
        raise RunError(
            f"{run} has the hand {plan.settings.hand}; files of grasps are for {DEFAULT_HAND} alone"
        )
    if strange := [name for name in objects if name not in plan.objects]:
        raise RunError(f"--object: got {strange[0]!r:.80}; {run} has {', '.join(plan.objects)}")
    tried, lost = _grasps_of(folder.finished(plan), objects)
    found = [one.entry() for one in tried if one.held or not only_held]
    if not found:
        held = "no trial that held" if only_held else "no finished trial with a grasp in its row"
        raise RunError(f"{run} has {held}; nothing was written")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        write_grasps(found, out)
    except OSError as error:
        raise RunError(
            f"cannot write {out}: {error.strerror or error}; choose another --out"
        ) from error
    counts = Counter(entry.object for entry in found)
    said = ", ".join(f"{name} {count}" for name, count in counts.items())
    output().print(f"{out}: {len(found)} grasps ({said})", markup=False, soft_wrap=True)
    if lost:
        errors().print(f"note: {lost} trials ended as error and have no grasp", soft_wrap=True)


@dataclass
class _Tried:
    """A grasp of the run, as its first trial had it, and how its trials ended."""

    grasp: GraspEntry
    held: int = 0
    known: int = 0  # trials that tell something about the grasp

    def entry(self) -> GraspEntry:
        confidence = self.held / self.known if self.known else None
        return dataclasses.replace(self.grasp, confidence=confidence)


def _grasps_of(rows: Iterator[TrialRow], objects: Sequence[str]) -> tuple[list[_Tried], int]:
    """The grasps of rows in the order of their first trial, and how many trials have none."""
    found: dict[tuple[str, str], _Tried] = {}
    lost = 0
    for row in rows:
        if objects and row.object not in objects:
            continue
        if row.plan_palm_pose_object is None:
            lost += 1
            continue
        entry = _entry_of(row)
        one = found.setdefault((entry.object, entry.name), _Tried(entry))
        one.held += bool(row.success)
        one.known += row.failure not in NO_TRUTH
    return list(found.values()), lost


def _entry_of(row: TrialRow) -> GraspEntry:
    assert row.object is not None
    assert row.plan_palm_pose_object is not None
    return GraspEntry(
        object=row.object,
        name=row.grasp_name or f"trial_{row.trial}",
        palm_pose=row.plan_palm_pose_object,
        preshape=row.preshape or "",
        ratio=row.plan_opening if row.preshape else None,
        open=None if row.preshape else row.plan_open_rad,
        closed=None if row.preshape else row.plan_closed_rad,
        object_yaw=row.object_yaw_rad,
    )
