"""The table of grasps on the disk: written grasp by grasp, so that a run can go on."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from experiments.command_line import fail
from experiments.drives.grasps import COLUMNS, DRIVES, Seen

TABLE, CONDITIONS = "drives.csv", "drives.json"


class GraspTable:
    """What a run has found so far.

    Args:
        folder: of the run, made where it is missing.
        conditions: of the run; a folder of others is refused.

    Attributes:
        seen: the grasps found, those with every drive alone.
    """

    def __init__(self, folder: Path, conditions: Mapping[str, object]) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._path, said = folder / TABLE, folder / CONDITIONS
        if said.exists():
            found = _conditions(said)
            if found != dict(conditions):
                fail(f"{said} is of a run with {found}, this one has {dict(conditions)}; choose "
                     "another --out")  # fmt: skip
        else:
            said.write_text(json.dumps(dict(conditions), indent=1) + "\n", encoding="utf-8")
        self.seen = self._read() if self._path.exists() else []
        lines = [",".join(COLUMNS), *(s.line() for s in self.seen)]
        self._path.write_text("\n".join(lines) + "\n", encoding="utf-8")

    @property
    def done(self) -> set[tuple[str, int]]:
        """Object and seed of the grasps found."""
        return {(s.object, s.seed) for s in self.seen}

    def add(self, grasp: Sequence[Seen]) -> None:
        """Write a grasp, with every drive."""
        self.seen += grasp
        with open(self._path, "a", encoding="utf-8") as file:
            file.write("".join(s.line() + "\n" for s in grasp))

    def _read(self) -> list[Seen]:
        """The whole grasps of a table; a line that a kill cut off is left out with its grasp."""
        grasps: dict[tuple[str, int], list[Seen]] = {}
        for line in self._path.read_text(encoding="utf-8", errors="replace").splitlines()[1:]:
            try:
                found = Seen.read(line)
            except ValueError:
                continue
            grasps.setdefault((found.object, found.seed), []).append(found)
        whole = [g for g in grasps.values() if tuple(s.drive for s in g) == DRIVES]
        return [s for grasp in whole for s in grasp]


def _conditions(path: Path) -> object:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except ValueError:
        fail(f"{path} is damaged; choose another --out")
