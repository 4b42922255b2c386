"""The clearest mispredictions of a run: pictures, recordings, and what happened in each.

    python -m experiments.gallery RUN [--metric q_linf] [--each 3] [--out FOLDER] [--no-pictures]

Two kinds: predicted stable (metric > 1) but not held, and predicted failing but held; the ones
furthest on the wrong side come first. Writes a page ``gallery.md`` beside them.
"""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.command_line import Parser
from experiments.stored_runs import read_runs
from sdh_sim.errors import RecordError, RenderError
from sdh_sim.records import NO_TRUTH
from sdh_sim.runs import RunFolder
from sdh_sim.trial import TrialLog, run_trial
from sdh_sim.viewing.render import render_trial

MOVED_MM = 2.0  # of the object in the hand: from then on it is on its way out
SHOWN = ("q_linf", "q_l1", "q_capability", "q_held", "q_whole_hand")


def mispredicted(
    rows: Sequence[Mapping[str, Any]], metric: str, each: int
) -> dict[str, list[Mapping[str, Any]]]:
    """The clearest trials of both kinds, clearest first."""
    known = [r for r in rows if r["failure"] not in NO_TRUTH and r.get(metric) is not None]
    false_alarm = [r for r in known if r["success"] and r[metric] <= 1.0]
    missed = [r for r in known if not r["success"] and r[metric] > 1.0]
    return {
        "predicted stable, did not hold": sorted(missed, key=lambda r: -r[metric])[:each],
        "predicted to fail, held": sorted(
            false_alarm, key=lambda r: (r[metric], r["displacement_mm"])
        )[:each],
    }


def mechanism(row: Mapping[str, Any], log: TrialLog) -> str:
    """One sentence on what happened, from the trial's own time series."""
    sentences = []
    unsensed = row.get("unsensed_force_n") or 0.0
    total = unsensed + (row.get("sensed_force_n") or 0.0)
    if total > 0.0 and unsensed > 0.25 * total:
        sentences.append(
            f"{100 * unsensed / total:.0f} % of the grip's normal force is on parts without sensor"
        )
    if row["contacts"] is not None and row["contacts"] < 2:
        felt = "only one of the pads used" if row["contacts"] else "none of the pads used"
        sentences.append(f"{felt} felt the object")
    saturated = np.abs(row["motor_torque_nm"]) > 0.95 * np.asarray(row["torque_limit_nm"])
    sentences.append(f"{int(saturated.sum())} of 7 motors at their limit in the grip")
    if row["success"]:
        sentences.append(
            f"it settled by {row['displacement_mm']:.1f} mm and {row['rotation_deg']:.1f}° and held"
        )
    else:
        sentences.append(_way_out(row, log))
    return "; ".join(sentences) + "."


def _way_out(row: Mapping[str, Any], log: TrialLog) -> str:
    phases = np.array(log.phase)
    lifted = np.flatnonzero((phases == "lift") | (phases == "hold"))
    if not len(lifted):
        return f"ended as {row['failure']} before the lift"
    away = _displacement(log)[lifted]
    first = lifted[np.argmax(away > MOVED_MM)] if (away > MOVED_MM).any() else lifted[-1]
    since = log.time[first] - log.time[lifted[0]]
    grow = away[(away > MOVED_MM) & (away < 10.0)]
    pace = "crept out" if len(grow) > 15 else "slipped out at once"
    return (
        f"{pace}: 2 mm after {since:.1f} s of the {log.phase[first]}, turned by "
        f"{min(row['rotation_deg'], 180):.0f}° in the end ({row['failure']})"
    )


def _displacement(log: TrialLog) -> np.ndarray:
    """How far the object is from its place in the hand at the end of the rest [mm] (n,)."""
    scene = log.scene
    rest = np.flatnonzero(np.array(log.phase) == "rest")[-1]
    place = []
    for position, quat in zip(log.body_position, log.body_quat, strict=True):
        w, v = quat[scene.palm, 0], -quat[scene.palm, 1:]
        apart = position[scene.object_body] - position[scene.palm]
        place.append(apart + 2.0 * np.cross(v, np.cross(v, apart) + w * apart))
    return 1e3 * np.linalg.norm(np.array(place) - place[rest], axis=1)


def show(row: Mapping[str, Any], folder: RunFolder, name: str, out: Path, draw: bool) -> str:
    """Repeat a trial, write its picture and recording, return its paragraph."""
    from sdh_sim.viewing.recording import write_recording

    job = folder.read_plan().job(int(row["trial"]))
    # Users' metrics are not evaluated again: code that a run names is not run unasked.
    log = run_trial(dataclasses.replace(job.settings, metrics=()), job.seed, log=True).log
    assert log is not None
    write_recording(log, out / f"{name}.rrd")
    picture = ""
    if draw:
        render_trial(log, out / f"{name}.png")
        picture = f"![pre-grasp, grip and end]({name}.png)\n\n"
    q_sim = row.get("q_sim")
    held = f", held {q_sim:.2f} weights" if q_sim is not None and math.isfinite(q_sim) else ""
    return (
        f"### {row['object']}, trial {row['trial']}\n\n{picture}"
        f"q* L∞ {row['q_linf']:.2f}, L1 {row['q_l1']:.2f}{held}. {row['approach']} grasp, "
        f"{row['preshape']}. {mechanism(row, log)}\n"
    )


def main(argv: list[str] | None = None) -> int:
    """Make the gallery."""
    parser = Parser(__doc__)
    parser.add_argument("run", type=Path, help="run folder of sdh-sim lift")
    parser.add_argument("--metric", default="q_linf", choices=SHOWN)
    parser.add_argument("--each", type=int, default=3, help="trials of each kind [3]")
    parser.add_argument("--out", type=Path, help="where to write [RUN/report/gallery]")
    parser.add_argument("--no-pictures", action="store_true", help="recordings alone")
    args = parser.parse_args(argv)
    try:
        folder = RunFolder(args.run)
        rows = read_runs([args.run]).rows
        out = args.out or args.run / "report" / "gallery"
        out.mkdir(parents=True, exist_ok=True)
        page = [f"# Mispredictions of {args.run}\n", f"Metric {args.metric}, threshold 1.\n"]
        for title, found in mispredicted(rows, args.metric, args.each).items():
            page.append(f"## {title}\n")
            page += [
                show(row, folder, f"trial_{row['trial']:06d}", out, not args.no_pictures)
                for row in found
            ] or ["None in this run.\n"]
        (out / "gallery.md").write_text("\n".join(page), encoding="utf-8")
    except (RecordError, RenderError, OSError, ValueError) as error:
        print(f"gallery: {error}", file=sys.stderr)
        return 2
    print(out / "gallery.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
