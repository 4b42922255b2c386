"""Predicted probabilities of success against the shares of perturbed copies that held.

    python -m experiments.probability RUN [--samples 64] [--workers 1]

RUN has ``--repeats`` and errors of perception (``--position-error`` and so on), which are what the
probabilities are over. Beside P(q* > 1) stand P_fc and robust ε over the same copies, and plain
q*; those that are no probability of success are calibrated by logistic regression,
cross-validated, and so are the others once more. Scores are over all copies; intervals resample
trials.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.command_line import Parser, at_least, fail
from experiments.probability_scores import (
    Shares,
    bins_of,
    brier,
    brier_interval,
    calibrated,
    copies_auc,
    least_brier,
    trial_weights,
)
from sdh_sim.analysis.comparison import auc, auc_interval
from sdh_sim.analysis.proportion import wilson_interval
from sdh_sim.analysis.resampling import interval
from sdh_sim.analysis.thresholds import assign_folds
from sdh_sim.cli.worker_pool import run_all
from sdh_sim.errors import RecordError, RunError, SettingsError
from sdh_sim.metrics import grasp_of, read_stored, snapshot_of
from sdh_sim.metrics.probability import SAMPLES, Probabilities, probabilities
from sdh_sim.records import NO_TRUTH
from sdh_sim.report.figure_style import (
    GREY,
    colour_of,
    legend,
    letter,
    light,
    panels,
    save,
    style,
)
from sdh_sim.robot import hand_in, hand_kinematics
from sdh_sim.runs import RunFolder
from sdh_sim.sensing import TrackingErrors
from sdh_sim.settings import TrialSettings
from sdh_sim.user_references import ObjectFolder

NOTHING = Probabilities(0.0, 0.0, 0.0, 0.0)  # of a grasp whose pads feel nothing
LEAST_TRIALS = 10
SHOWN = ("P(q* > 1)", "P_fc", "P(q* > 1), calibrated", "q*, calibrated")
PLAIN, CALIBRATED = "q*", ", calibrated"


class Job(NamedTuple):
    """A trial with repeats."""

    settings: TrialSettings
    row: dict[str, Any]
    folders: dict[str, ObjectFolder]
    samples: int


class Predictor(NamedTuple):
    """One column of predictions.

    Attributes:
        name: in tables.
        scores: what ranks the trials (n,).
        probability: of success (n,); None: it states none.
        colour: in the picture.
    """

    name: str
    scores: np.ndarray
    probability: np.ndarray | None
    colour: str


def predict_job(job: Job) -> Probabilities:
    """What copies of one row's perceived grasp say."""
    settings = job.settings
    kinematics = hand_kinematics(hand_in(settings))
    grasp = grasp_of(job.row, settings.pads, kinematics, job.folders)
    if grasp is None or not grasp.contacts:
        return NOTHING
    return probabilities(grasp, errors_of(settings), job.samples)


def errors_of(settings: TrialSettings) -> TrackingErrors:
    """The errors of perception that a run declares."""
    return TrackingErrors(
        settings.position_error,
        settings.angle_error,
        settings.friction_error,
        settings.mass_error,
    )


def jobs_of(folder: Path, samples: int) -> list[Job]:
    """The trials with an outcome, a snapshot and copies.

    Raises:
        RecordError, RunError, SettingsError: what cannot be used of the run, and why.
    """
    plan = RunFolder(folder).read_plan()
    settings = plan.settings
    if not settings.repeats:
        raise RunError(f"{folder} has no repeats; lift with --repeats 8, say")
    if settings.touch:
        raise RunError(
            f"{folder} has poses corrected by touch, whose errors are not declared; lift without"
            " --touch"
        )
    if not any(vars(errors_of(settings)).values()):
        raise RunError(
            f"{folder} declares no error of perception; lift with --position-error and so on"
        )
    rows = read_stored([RunFolder(folder).table])[1]
    return [
        Job(settings, row, dict(plan.folders), samples)
        for row in rows
        if row["failure"] not in NO_TRUTH and row.get("repeats") and snapshot_of(row) is not None
    ]


def predictors_of(jobs: list[Job], found: list[Probabilities], shares: Shares) -> list[Predictor]:
    """All predictions of the trials, in the order of the table."""
    q = np.array([job.row["q_linf"] for job in jobs], dtype=float)
    p, closure, epsilon, median = np.array(found).T
    strata = np.array([f"{job.row['object']} {job.row['success']}" for job in jobs])
    fold = assign_folds(strata, np.random.default_rng(0))
    raw = [
        Predictor("P(q* > 1)", p, p, "#CC3311"),
        Predictor("P_fc", closure, closure, "#009988"),
        Predictor("robust ε", epsilon, None, colour_of("epsilon_l1")),
        Predictor("median q*", median, None, GREY),
        Predictor(PLAIN, np.nan_to_num(q, nan=0.0, posinf=np.inf), None, colour_of("q_linf")),
    ]
    return raw + [
        Predictor(r.name + CALIBRATED, r.scores, calibrated(r.scores, shares, fold), r.colour)
        for r in raw
    ]


def table_of(predictors: list[Predictor], shares: Shares, success: np.ndarray) -> Table:
    """One line per predictor."""
    table = Table(title=f"{len(success)} grasps, {int(shares.copies.sum())} copies")
    heads = ("AUC, copies", "AUC, the trial", "Brier score", "reliability", "resolution")
    for head in ("predictor", *heads):
        table.add_column(head, justify="left" if head == "predictor" else "right")
    weights = trial_weights(len(success), np.random.default_rng(0))
    for one in predictors:
        areas = copies_auc(one.scores, shares, weights)
        low, high = interval(areas[np.isfinite(areas)])
        cells = [
            f"{copies_auc(one.scores, shares)[0]:.3f} ({low:.3f}–{high:.3f})",
            _trial_area(one.scores, success),
        ]
        if one.probability is None:
            cells += ["-"] * 3
        else:
            b = brier(one.probability, shares)
            low, high = brier_interval(one.probability, shares, np.random.default_rng(0))
            cells += [f"{b.score:.3f} ({low:.3f}–{high:.3f})"]
            cells += [f"{b.reliability:.3f}", f"{b.resolution:.3f}"]
        table.add_row(one.name, *cells)
    return table


def gains(predictors: list[Predictor], shares: Shares) -> str:
    """By how much each ranks the copies better than plain q*, over the same resamples."""
    weights = trial_weights(len(shares.copies), np.random.default_rng(0))
    plain = next(one for one in predictors if one.name == PLAIN)
    cells = []
    for one in predictors:
        if (one.probability is not None and one.name.endswith(CALIBRATED)) or one is plain:
            continue
        areas = copies_auc(one.scores, shares, weights) - copies_auc(plain.scores, shares, weights)
        low, high = interval(areas[np.isfinite(areas)])
        gain = copies_auc(one.scores, shares)[0] - copies_auc(plain.scores, shares)[0]
        cells.append(f"{one.name} {gain:+.3f} ({low:+.3f} to {high:+.3f})")
    return f"AUC over copies less that of {PLAIN}: {', '.join(cells)}."


def by_bins(one: Predictor, shares: Shares) -> str:
    """What the copies did, by what was predicted of them."""
    assert one.probability is not None
    cells = [
        f"{b.predicted:.2f}: {b.observed:.2f} ({int(b.members.sum())})"
        for b in bins_of(one.probability, shares)
    ]
    return f"{one.name}, predicted: share of copies that held (trials): {', '.join(cells)}."


def _trial_area(scores: np.ndarray, success: np.ndarray) -> str:
    area = auc(scores, success)
    if area is None:
        return "-"
    found = auc_interval(scores, success)
    return f"{area:.3f}" + (f" ({found[0]:.3f}–{found[1]:.3f})" if found else "")


def draw(predictors: list[Predictor], shares: Shares, stem: Path) -> Path:
    """Reliability diagrams of the probabilities: predicted against observed shares."""
    stated = {one.name: one for one in predictors if one.probability is not None}
    shown = [stated[name] for name in SHOWN]
    with style():
        figure, axes = panels(2, 6.2, 2, sharex=True, sharey=True)
        for k, (panel, one) in enumerate(zip(axes, shown, strict=True)):
            assert one.probability is not None
            panel.plot([0, 1], [0, 1], color=GREY, lw=0.8, ls="--", zorder=1)
            dodge = 0.02 * np.random.default_rng(0).uniform(-1, 1, len(shares.copies))
            panel.plot(
                one.probability, np.clip(shares.value + dodge, -0.03, 1.03), "o", ms=3,
                mew=0, color=light(one.colour, 0.35), label="a trial's copies", zorder=2,
            )  # fmt: skip
            for b in bins_of(one.probability, shares):
                # Copies of one trial are alike: Wilson's interval takes the number of trials.
                trials = int(b.members.sum())
                low, high = wilson_interval(round(b.observed * trials), trials)
                panel.plot([b.predicted] * 2, [low, high], color=one.colour, lw=1.4, zorder=3)
            found = bins_of(one.probability, shares)
            panel.plot(
                [b.predicted for b in found], [b.observed for b in found], "o-", ms=5,
                color=one.colour, label="all of a bin", zorder=4,
            )  # fmt: skip
            score = brier(one.probability, shares).score
            letter(panel, k, f"{one.name}: Brier {score:.3f}")
            panel.set_xlim(-0.05, 1.05)
            panel.set_ylim(-0.05, 1.05)
            panel.label_outer()
        for panel in axes[2:]:
            panel.set_xlabel("predicted probability")
        for panel in axes[::2]:
            panel.set_ylabel("share of copies that held")
        legend(axes[0], loc="lower right")
        _, png = save(figure, stem)
    return png


def main(argv: list[str] | None = None) -> None:
    """Print the table and draw the picture."""
    parser = Parser(__doc__)
    parser.add_argument("run", type=Path, help="run folder")
    parser.add_argument("--samples", type=int, default=SAMPLES, help="copies per grasp")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    parser.add_argument("--out", type=Path, help="folder of the picture (RUN/probability)")
    args = parser.parse_args(argv)
    at_least(parser, args, samples=1, workers=1)
    try:
        jobs = jobs_of(args.run, args.samples)
    except (RecordError, RunError, SettingsError) as error:
        fail(str(error))
    if len(jobs) < LEAST_TRIALS:
        fail(
            f"{args.run} has {len(jobs)} trials with a snapshot and repeats, expected at least"
            f" {LEAST_TRIALS}; lift with more --trials"
        )
    count = np.array([job.row["repeats"] for job in jobs])
    share = np.array([job.row["success_probability"] for job in jobs])
    shares = Shares(np.round(share * count).astype(int), count)
    success = np.array([job.row["success"] for job in jobs])
    if args.workers == 1:
        found = [predict_job(job) for job in jobs]
    else:
        found = run_all(predict_job, jobs, "grasps", args.workers)
    predictors = predictors_of(jobs, found, shares)
    Console(width=120).print(table_of(predictors, shares, success))
    print(gains(predictors, shares))
    print(by_bins(predictors[0], shares))
    base = shares.held.sum() / count.sum()
    print(
        f"{100 * base:.0f} % of the copies held; predicting that for each has a Brier score of"
        f" {base * (1 - base):.3f}, predicting each trial's own share {least_brier(shares):.3f}."
        f" {np.mean((share > 0) & (share < 1)) * 100:.0f} % of the trials have copies of both"
        f" kinds; {np.mean((share > 0.5) == success) * 100:.0f} % agree with most of their copies."
    )
    out = args.out or args.run / "probability"
    out.mkdir(parents=True, exist_ok=True)
    print(draw(predictors, shares, out / "reliability"))


if __name__ == "__main__":
    main()
