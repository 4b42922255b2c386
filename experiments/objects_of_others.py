"""Which objects of a set that others published are loaded, and how often random grasps lift them.

    python -m experiments.objects_of_others FOLDER --trials 10

One line for each object. Sets seldom say mass and friction; the options do. Trials have the seeds
of ``sdh-sim lift``.
"""

from __future__ import annotations

import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from experiments.command_line import Parser, at_least, fail
from experiments.object_sets import Assumed, Candidate, Loaded, find_candidates, load
from sdh_sim.analysis.proportion import Proportion
from sdh_sim.cli.worker_pool import run_all
from sdh_sim.errors import SettingsError
from sdh_sim.objects.facts_file import MAX_MASS, MIN_MASS
from sdh_sim.runs.plan import trial_seed
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import run_trial


@dataclass(frozen=True)
class Job:
    """One trial: settings with the object, and seed."""

    settings: TrialSettings
    seed: int


def outcome(job: Job) -> str:
    """How a trial ended: ``lifted``, a failure of the table, or ``error``."""
    try:
        failure = run_trial(job.settings, job.seed).row.failure
    except RuntimeError:  # no feasible grasp
        return "error"
    return "lifted" if failure == "none" else str(failure)


def main(argv: list[str] | None = None) -> None:
    """Print the lines."""
    parser = Parser(__doc__)
    parser.add_argument("folder", type=Path, help="with the set; nothing in it is changed")
    parser.add_argument("--mass", type=float, default=0.2, help="kg, if no MJCF states it [0.2]")
    parser.add_argument("--friction", type=float, default=0.6, help="against the pads [0.6]")
    parser.add_argument("--scale", type=float, default=1.0, help="metres per unit of a mesh [1]")
    parser.add_argument("--up", choices=("x", "y", "z"), default="z", help="axis that is up [z]")
    parser.add_argument(
        "--shape",
        choices=("hull", "decompose", "refuse"),
        default="hull",
        help="what is not convex becomes its hull, is decomposed, or is refused [hull]",
    )
    parser.add_argument("--trials", type=int, default=10, help="for each object [10]")
    parser.add_argument("--seed", type=int, default=0, help="of the run [0]")
    args = parser.parse_args(argv)
    at_least(parser, args, trials=0, seed=0)
    if not MIN_MASS <= args.mass <= MAX_MASS:
        parser.error(f"--mass must be {MIN_MASS:g} to {MAX_MASS:g} kg, got {args.mass:g}")
    try:
        candidates = find_candidates(args.folder)
    except OSError as error:
        fail(f"cannot read {args.folder}: {error.strerror}; give a folder with a set of objects")
    if not candidates:
        fail(f"{args.folder} holds no MJCF, no mesh and no folder with one; give a set of objects")
    assumed = Assumed(args.mass, args.friction, args.scale, args.up, args.shape)
    with tempfile.TemporaryDirectory() as place:
        loaded = [_load(candidate, assumed, Path(place)) for candidate in candidates]
        jobs = [
            Job(
                TrialSettings(found.obj.name, folder=found.obj.reference),
                trial_seed(args.seed, found.obj.name, index),
            )
            for found in loaded
            if isinstance(found, Loaded)
            for index in range(args.trials)
        ]
        outcomes = iter(run_all(outcome, jobs, "trials") if jobs else [])
        width = max(len(candidate.name) for candidate in candidates)
        for candidate, found in zip(candidates, loaded, strict=True):
            if isinstance(found, str):
                print(f"{candidate.name:{width}}  not loaded: {found}")
                continue
            counts = Counter(next(outcomes) for _ in range(args.trials))
            print(f"{candidate.name:{width}}  {_line(found, counts)}")
    count = sum(isinstance(found, Loaded) for found in loaded)
    print(f"{count} of {len(candidates)} loaded")


def _load(candidate: Candidate, assumed: Assumed, place: Path) -> Loaded | str:
    """The object, or why it is not loaded."""
    try:
        return load(candidate, assumed, place)
    except SettingsError as error:
        return str(error).removeprefix(f"object: {place / candidate.name}: ")
    except OSError as error:
        return f"its files cannot be copied: {error.strerror}"


def _line(found: Loaded, counts: Counter[str]) -> str:
    """What became of an object: mass, shapes, share lifted, failures and notes."""
    shapes = f"{found.obj.parts} collision shape{'s'[: found.obj.parts > 1]}"
    text = f"loaded, {found.mass:.3f} kg, {shapes}"
    total = sum(counts.values())
    if total:
        share = Proportion(counts["lifted"], total)
        low, high = share.interval or (0.0, 1.0)
        text += f", lifted {share.k} of {total} ({100 * low:.0f}–{100 * high:.0f} %)"
    failures = [f"{name} {n}" for name, n in counts.most_common() if name != "lifted"]
    notes = [*found.notes, *(n for n in found.obj.reference.notes if not n.startswith("ignored"))]
    return "; ".join([text, *([", ".join(failures)] if failures else []), *notes])


if __name__ == "__main__":
    main()
