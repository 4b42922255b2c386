"""Is the simulation right? Closed-form checks of contact, friction, forces, motion and numerics.

    python -m experiments.validation [--short] [--preset fast] [--out DIR] [--only NAME ...]

Each line compares what mechanics predicts with what MuJoCo does on the project's own hand, pads
and rubber. A line marked *noted* is a known deviation of the contact model with the bound expected
of it (*beyond* where it is larger); it is reported and decides nothing. The exit status is 1 if a
line fails. With ``--out`` a picture is drawn for every check that gains from one, and the table is
written as ``validation.csv``. ``--reasons`` says why each tolerance is what it is.
"""

from __future__ import annotations

import argparse
import csv
import math
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from rich.table import Table

from experiments.command_line import Parser
from experiments.validation import (
    carrying,
    forces,
    friction,
    jaw,
    motion,
    pads,
    sensor,
    torsion,
    turning,
)
from experiments.validation.result_rows import Result, Row
from experiments.validation.rigs import HONEST, Spoil, timestep_in_use
from sdh_sim.campaign.paper_preset import FAST_SETTINGS
from sdh_sim.cli.console import errors, output

Check = Callable[[bool, Spoil], Result]

CHECKS: dict[str, tuple[str, Check]] = {
    "pad_onset": ("Friction onset on a pad: F = μ N", friction.pad_onset),
    "clamp_drop": ("Drop of a clamped box: μ = m g / ΣN", friction.clamp_drop),
    "torsion_onset": ("Torsional slip of a patch: τ* of equation 7", torsion.torsion_onset),
    "torsion_overload": ("Spin of an overloaded patch: (τ - τ*) / (μ² c Σ (l - l̄)²)",
                         torsion.torsion_overload),
    "friction_creep": ("Creep of regularised friction: F (1 - d) A / (impratio b)",
                       friction.friction_creep),
    "single_finger": ("One pad: f = J⁻ᵀ τ̄", forces.single_finger),
    "two_pads": ("Two pads of a finger: Σ Jᵀ f = τ̄", forces.two_pads),
    "tactile_total": ("Total tactile force of two fingers", forces.tactile_total),
    "whole_grasp": ("Whole grasps in the workcell: Σ Jᵀ f = τ of all motors", motion.whole_grasp),
    "plate": ("Stiffness of a pad under a plate", pads.plate),
    "ball": ("Ball pressed into a pad: elastic foundation", pads.ball),
    "modulus": ("Effect of the rubber's modulus", pads.modulus),
    "recoil": ("A plate let go by a pad", pads.recoil),
    "release": ("Released object: momentum, energy, spin", motion.release),
    "sensor_creep": ("Creep of the tactile arrays: p (1 - a exp(-t / T))", sensor.sensor_creep),
    "numerics": ("Independence of time step, tolerance and impratio", motion.numerics),
    "jaw_force": ("Parallel jaw: F / 2 on each pad", jaw.jaw_force),
    "jaw_torsion": ("Parallel jaw: torsional slip of a flat patch, equation 7", jaw.jaw_torsion),
    "jaw_creep": ("Parallel jaw: creep of regularised friction", jaw.jaw_creep),
    "jaw_step": ("Parallel jaw: independence of the time step", jaw.jaw_step),
    "turning_base": ("Slip in a hand whose base turns: ω² r / b", turning.turning_base),
    "carry": ("Independence of the time step while the arm moves", carrying.carry),
}  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the checks; 0 if all judged lines pass, 1 if not."""
    options = _parser().parse_args(arguments)
    step = FAST_SETTINGS["timestep"] if options.preset else timestep_in_use.get()
    usual = timestep_in_use.set(step)
    try:
        return _run(options)
    finally:
        timestep_in_use.reset(usual)


def _run(options: argparse.Namespace) -> int:
    folder = None if options.out is None else Path(options.out)
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
    console, progress = output(), errors()
    results, begin = {}, time.perf_counter()
    for name in options.only or CHECKS:
        progress.print(f"{name} …", style="dim")
        results[name] = CHECKS[name][1](options.short, HONEST)
        if folder is not None and (drawn := _draw(name, results[name], folder)):
            progress.print(f"  {drawn}", style="dim")
    console.print(table(results, options.reasons))
    if folder is not None:
        write_csv(results, folder / "validation.csv")
    judged = [row for result in results.values() for row in result.rows if row.judged]
    failed = [row for row in judged if not row.passed]
    others = [row for result in results.values() for row in result.rows if not row.judged]
    beyond = sum(not row.passed for row in others)
    console.print(
        f"{len(judged) - len(failed)} of {len(judged)} lines pass; {len(others)} noted, {beyond} "
        f"of them beyond their bound; {time.perf_counter() - begin:.0f} s",
        style="red" if failed else "green",
    )
    return 1 if failed else 0


def verdict(row: Row) -> str:
    """``pass`` or ``FAIL``; a line that decides nothing is ``noted``, or ``beyond`` its bound."""
    if row.judged:
        return "pass" if row.passed else "FAIL"
    return "noted" if row.passed else "beyond"


def table(results: dict[str, Result], reasons: bool = False) -> Table:
    """The lines of all checks; ``reasons`` adds why each tolerance is what it is."""
    colours = {"pass": "green", "FAIL": "bold red", "noted": "yellow", "beyond": "bold yellow"}
    heads = ("check", "predicted", "simulated", "unit", "deviation", "tolerance", "result")
    drawn = Table(box=None, pad_edge=False, header_style="bold")
    for head in (*heads, "because") if reasons else heads:
        right = head in ("predicted", "simulated", "deviation", "tolerance")
        text = head in ("check", "because")
        drawn.add_column(head, justify="right" if right else "left", no_wrap=not text)
    for name, result in results.items():
        drawn.add_row(f"[bold]{CHECKS[name][0]}[/bold]")
        for row in result.rows:
            word = verdict(row)
            cells = [
                f"  {row.quantity}", _number(row.predicted), _number(row.simulated), row.unit,
                _percent(row.deviation, "+"), _percent(row.tolerance, ""),
                f"[{colours[word]}]{word}[/]",
            ]  # fmt: skip
            drawn.add_row(*cells, *([row.reason] if reasons else []))
    return drawn


def write_csv(results: dict[str, Result], path: Path) -> None:
    """All lines with their reasons."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(
            ("check", "quantity", "unit", "predicted", "simulated", "deviation", "tolerance",
             "result", "reason")
        )  # fmt: skip
        for name, result in results.items():
            for row in result.rows:
                writer.writerow(
                    (name, row.quantity, row.unit, row.predicted, row.simulated, row.deviation,
                     row.tolerance, verdict(row), row.reason)
                )  # fmt: skip


def _draw(name: str, result: Result, folder: Path) -> Path | None:
    from experiments.validation.pictures import save  # matplotlib is slow to load

    return save(name, result.curves, folder)


def _number(value: float) -> str:
    return f"{value:.4g}" if math.isfinite(value) else str(value)


def _percent(share: float, sign: str) -> str:
    """A share as percent with as many digits as say something."""
    value = 100.0 * share
    if not math.isfinite(value):
        return str(value)
    if value == 0.0 or abs(value) >= 0.1:
        return f"{value:{sign}.1f} %"
    return f"{value:{sign}.2f} %" if abs(value) >= 0.01 else f"{value:{sign}.0e} %"


def _parser() -> argparse.ArgumentParser:
    parser = Parser(__doc__)
    parser.add_argument("--short", action="store_true", help="fewer cases, under 20 s on one core")
    parser.add_argument("--preset", choices=("fast",), help="as of sdh-sim lift: its time step")
    parser.add_argument("--out", metavar="DIR", help="write pictures and validation.csv there")
    parser.add_argument("--only", nargs="+", choices=list(CHECKS), metavar="NAME",
                        help=f"some of: {', '.join(CHECKS)}")  # fmt: skip
    parser.add_argument("--reasons", action="store_true", help="say why each tolerance is given")
    return parser


if __name__ == "__main__":
    raise SystemExit(main())
