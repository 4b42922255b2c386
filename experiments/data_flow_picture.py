"""The picture of the data flow: which room makes what, from the plan of a grasp to the report.

    python -m experiments.data_flow_picture [--out docs/images/data_flow.svg]

A box is a room, the names inside are what it makes, an arrow leads to where that is read. The names
stand here once; a test looks each of them up in the source and compares the picture.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from pathlib import Path

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "images" / "data_flow.svg"


@dataclass(frozen=True)
class Room:
    """A box of the picture.

    Attributes:
        name: its package.
        question: that it answers.
        made: what it makes, ``module:name`` or a file, in the order of making.
    """

    name: str
    question: str
    made: tuple[str, ...] = ()


TRIAL = (
    Room(
        "grasping",
        "how to grasp?",
        ("sdh_sim.grasping.grasp_plan:GraspPlan", "sdh_sim.grasping.motion_plan:MotionPlan"),
    ),
    Room("cell", "what happens?", ("sdh_sim.cell.simulation:Simulation",)),
    Room(
        "sensing",
        "what is felt?",
        (
            "sdh_sim.sensing.snapshot:TactileSnapshot",
            "sdh_sim.sensing.perceived_grasp:PerceivedGrasp",
        ),
    ),
    Room("metrics", "will it hold?", ("sdh_sim.metrics.prediction:Prediction",)),
    Room("trial", "did it hold?", ("sdh_sim.records.trial_row:TrialRow",)),
)
RUN = (
    Room("campaign", "many trials", ("sdh_sim.campaign.campaign:run_campaign",)),
    Room("runs", "a run on the disk", ("trials.parquet", "run.json")),
    Room("analysis", "which metric is good?", ("sdh_sim.analysis.comparison:Comparison",)),
    Room("report", "a page to read", ("report/index.html",)),
    Room("viewing", "to look at a trial", ("trial.rrd", "trial.png")),
)
BELOW = (
    Room("grasp_files", "a user's grasps"),
    Room("robot", "hand, arm, pads"),
    Room("objects", "what is grasped"),
    Room("records", "columns and rows"),
    Room("graspq", "contacts → q*, ε, V"),
)

# Opaque boxes; lines and words outside them in colours that show on white and on black.
BOX, HEAD, INK, PAPER, GREY, ORANGE = (
    "#e4f1ef",
    "#0f766e",
    "#10302c",
    "#ffffff",
    "#7c8b8a",
    "#e06c2e",
)
FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, 'DejaVu Sans'"
WIDTH, HEIGHT = 1100, 606
LEFT, BOX_WIDTH, COLUMN = 24, 184, 217  # of the first box; from one box to the next
TOP, BOX_HEIGHT, HEADING = (52, 330), 172, 58  # of the two rows
PILL, STEP = 32, 52  # height of a name's frame, from one to the next
LOWEST = 536


def picture() -> str:
    """The picture as SVG."""
    return "\n".join(_lines()) + "\n"


def _lines() -> Iterator[str]:
    yield (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" '
        f'font-family="{FONT}" text-anchor="middle" role="img">'
    )
    yield "<title>Data flow of sdh-sim by room</title>"
    yield "<defs>"
    for name, colour in (("grey", GREY), ("orange", ORANGE)):
        yield (
            f'<marker id="{name}" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="5.5" '
            f'markerHeight="5.5" orient="auto"><path d="M0,0 L10,5 L0,10 z" fill="{colour}"/>'
            "</marker>"
        )
    yield "</defs>"
    bottom = TOP[0] + BOX_HEIGHT
    yield (
        f'<rect x="8" y="8" width="{WIDTH - 16}" height="{bottom + 44 - 8}" rx="12" fill="none" '
        f'stroke="{GREY}" stroke-width="1.5" stroke-dasharray="7 5"/>'
    )
    yield _words(LEFT, 37, "one trial: Trial(settings, seed)", 17, GREY, "start", bold=True)
    for rooms, top in ((TRIAL, TOP[0]), (RUN, TOP[1])):
        for k, room in enumerate(rooms):
            yield from _box(room, _left(k), top, BOX_HEIGHT)
    for top, pairs in ((TOP[0], 4), (TOP[1], 3)):
        for k in range(pairs):
            y = top + HEADING + (BOX_HEIGHT - HEADING) / 2
            yield _arrow("grey", (_left(k) + BOX_WIDTH + 2, y), (_left(k + 1) - 2, y))
    yield from _between_rows(bottom)
    yield _words(LEFT, LOWEST - 10, "what these stand on:", 16, GREY, "start")
    for k, room in enumerate(BELOW):
        yield from _box(room, _left(k), LOWEST, HEADING)
    yield "</svg>"


def _between_rows(bottom: float) -> Iterator[str]:
    """From the simulation to the outcome, from the trial to the run and to its pictures."""
    cell, last = _left(1) + BOX_WIDTH / 2, _left(4)
    low = bottom + 22
    yield _arrow("orange", (cell, bottom), (cell, low), (last + 34, low), (last + 34, bottom + 3))
    words = "the lift: how far the object moves in the hand"
    yield _words((cell + last) / 2, low - 7, words, 14.5, ORANGE)
    row, middle = last + BOX_WIDTH / 2 - 10, (bottom + 44 + TOP[1]) / 2
    first = _left(0) + BOX_WIDTH / 2
    yield _arrow("grey", (row, bottom), (row, middle), (first, middle), (first, TOP[1] - 3))
    yield _words(_left(2) + BOX_WIDTH / 2, middle - 7, "one row for each trial", 14.5, GREY)
    log = last + BOX_WIDTH - 34
    yield _arrow("grey", (log, bottom), (log, TOP[1] - 3))
    yield _words(log + 8, TOP[1] - 14, "log", 14.5, GREY, "start")


def _left(column: int) -> float:
    return LEFT + COLUMN * column


def _box(room: Room, x: float, y: float, height: float) -> Iterator[str]:
    """A room with what it makes."""
    middle = x + BOX_WIDTH / 2
    if room.made:
        yield _rectangle(x, y, BOX_WIDTH, height, 9, BOX)
    yield _rectangle(x, y, BOX_WIDTH, HEADING, 9, HEAD)
    yield _words(middle, y + 25, f"{room.name}/", 18, PAPER, bold=True)
    yield _words(middle, y + 46, room.question, 14.5, PAPER)
    first = y + HEADING + (height - HEADING - PILL - STEP * (len(room.made) - 1)) / 2
    for k, made in enumerate(room.made):
        top = first + k * STEP
        if k and ":" in made:
            yield _arrow("grey", (middle, top - STEP + PILL), (middle, top - 1))
        yield _rectangle(x + 12, top, BOX_WIDTH - 24, PILL, 6, PAPER)
        yield _words(middle, top + 21, made.rpartition(":")[2], 15, INK)


def _rectangle(x: float, y: float, width: float, height: float, round: float, fill: str) -> str:
    return (
        f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="{round:g}" '
        f'fill="{fill}"/>'
    )


def _words(
    x: float, y: float, words: str, size: float, fill: str, anchor: str = "", bold: bool = False
) -> str:
    more = f' text-anchor="{anchor}"' if anchor else ""
    more += ' font-weight="bold"' if bold else ""
    return (
        f'<text x="{x:g}" y="{y:g}" font-size="{size:g}" fill="{fill}"{more}>{escape(words)}</text>'
    )


def _arrow(name: str, *points: tuple[float, float]) -> str:
    path = " ".join(f"{x:g},{y:g}" for x, y in points)
    colour = ORANGE if name == "orange" else GREY
    return (
        f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2.5" '
        f'marker-end="url(#{name})"/>'
    )


def main(argv: list[str] | None = None) -> None:
    """Write the picture."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--out", type=Path, default=PICTURE, help="file to write")
    path = parser.parse_args(argv).out
    path.write_text(picture(), encoding="utf-8")
    print(path)


if __name__ == "__main__":
    main()
