"""``sdh-sim demo``: a short real run over all objects, compared, drawn and recorded."""

from __future__ import annotations

from pathlib import Path

from sdh_sim.cli.compare import compare
from sdh_sim.cli.console import errors, output
from sdh_sim.cli.lift import lift
from sdh_sim.cli.lift_request import LiftRequest
from sdh_sim.cli.show import show
from sdh_sim.errors import RenderError, RunError
from sdh_sim.run_options import RunOptions, default_workers
from sdh_sim.runs import RunFolder

TRIALS, SEED = 8, 0


def run_demo(out: Path) -> None:
    """Run 8 trials on each object into ``out/run``, print the comparison, draw and record one.

    A demo that was there before is replaced; a folder that holds something else is refused.

    Args:
        out: folder for the run, ``trial.png`` and ``trial.rrd``.

    Raises:
        RunError: the folder cannot be used.
    """
    run = out / "run"
    folder = RunFolder(run)
    options = RunOptions(
        workers=default_workers(),
        overwrite=folder.holds_run(),
        command=f"sdh-sim demo --out {out}",
    )
    errors().print("the first run here compiles the metrics: half a minute", soft_wrap=True)
    lift(LiftRequest(str(run), ("all",), TRIALS, SEED, options=options))
    compare([run])
    rows = folder.read_rows(folder.read_plan())
    held = [trial for trial, row in sorted(rows.items()) if row["success"]]
    trial = held[-1] if held else 0
    try:
        show(run, [trial], save=out / "trial.rrd", png=out / "trial.png")
    except RunError as error:
        if not isinstance(error.__cause__, RenderError):
            raise
        errors().print(f"no picture: {error}", markup=False, soft_wrap=True)
    output().print(f"open the recording with: rerun {out / 'trial.rrd'}", markup=False)
