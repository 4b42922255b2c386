"""The command ``sdh-sim``: its commands and options, and the one line that bad input gets.

What needs MuJoCo, rerun or a table is imported by the command that uses it: help stays quick.
"""

from __future__ import annotations

import os
import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from sdh_sim.thread_limits import limit_threads

app = typer.Typer(
    help="Grasp, lift and compare: trials of the Schunk SDH-2 hand in MuJoCo.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

_OPTIONS = (
    *("object", "trials", "seed", "workers", "rerun", "torque_limit"),
    *("executor", "scheduler", "metric"),
)


def _version(wanted: bool) -> None:
    if wanted:
        import importlib.metadata

        try:
            print(importlib.metadata.version("sdh-sim"))
        except importlib.metadata.PackageNotFoundError:
            print("sdh-sim from a checkout, not installed")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


@app.command()
def lift(
    out: Annotated[
        # Text, since Path("") is the current folder: an empty variable in a script would fill it.
        str, typer.Option(metavar="FOLDER", help="Folder of the run, for example runs/box.")
    ],
    object: Annotated[
        list[str] | None,
        typer.Option(
            help='Object to lift, or the folder of your own; give it again for more, or "all". '
            "See: sdh-sim objects"
        ),
    ] = None,
    trials: Annotated[
        int | None, typer.Option(help="Trials per object.", show_default="20")
    ] = None,
    seed: Annotated[
        int | None, typer.Option(help="Seed that decides every trial.", show_default="0")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(help="Worker processes.", show_default="one per core")
    ] = None,
    torque_limit: Annotated[
        tuple[float, float] | None,
        typer.Option(
            help="Torque limits [N m]: spread and proximal joints, distal joints.",
            show_default="1.6401 1.0934",
        ),
    ] = None,
    sensor: Annotated[
        str | None,
        typer.Option(help="dsa: as the real arrays read; ideal: the pressure.", show_default="dsa"),
    ] = None,
    pads: Annotated[
        str | None,
        typer.Option(help="Pads the prediction uses: all or distal.", show_default="all"),
    ] = None,
    preset: Annotated[
        str | None,
        typer.Option(
            help="paper: fingertip grasps until each object has the paper's share of stable and "
            "unstable ones. fast: a time step of 4 ms, to explore."
        ),
    ] = None,
    grasps: Annotated[
        str | None,
        typer.Option(help="any, or precision: fingertips alone.", show_default="any"),
    ] = None,
    arm: Annotated[
        str | None, typer.Option(help="servo, or rigid: nothing moves it.", show_default="servo")
    ] = None,
    timestep: Annotated[
        float | None, typer.Option(help="Simulation step [s].", show_default="0.002")
    ] = None,
    pad_modulus: Annotated[
        float | None, typer.Option(help="Young's modulus of the pads [Pa].", show_default="1e6")
    ] = None,
    load_test: Annotated[
        str | None,
        typer.Option(
            help="Load each grasp until it gives way: gravity (column q_sim), or directions "
            "for forces and moments along the hand's axes too.",
            show_default="none",
        ),
    ] = None,
    disturbance: Annotated[
        str | None,
        typer.Option(
            help="After the lift turn the wrist 120 degrees either way, or shake the hand.",
            show_default="none",
        ),
    ] = None,
    repeats: Annotated[
        int | None,
        typer.Option(
            help="Perturbed copies of each trial, for a probability of success.", show_default="0"
        ),
    ] = None,
    repeat_position: Annotated[
        float | None, typer.Option(help="Their position noise [m].", show_default="0.002")
    ] = None,
    repeat_angle: Annotated[
        float | None, typer.Option(help="Their roll noise [rad].", show_default="0.02")
    ] = None,
    repeat_friction: Annotated[
        float | None, typer.Option(help="Their relative friction noise.", show_default="0.05")
    ] = None,
    position_error: Annotated[
        float | None,
        typer.Option(help="Error of the object's tracked position [m].", show_default="0"),
    ] = None,
    angle_error: Annotated[
        float | None,
        typer.Option(help="Error of its tracked rotation [rad].", show_default="0"),
    ] = None,
    friction_error: Annotated[
        float | None,
        typer.Option(help="Relative error of the friction assumed.", show_default="0"),
    ] = None,
    mass_error: Annotated[
        float | None, typer.Option(help="Relative error of the mass assumed.", show_default="0")
    ] = None,
    metric: Annotated[
        list[str] | None,
        typer.Option(
            help="Metric of your own: module:function, file.py:function or an installed entry "
            "point; give it again for more."
        ),
    ] = None,
    rerun: Annotated[
        str | None,
        typer.Option(
            help="Trials that leave a rerun recording: all, failures or none.", show_default="none"
        ),
    ] = None,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume",
            help="Continue the run in --out with its own settings; --trials may be raised.",
        ),
    ] = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the run in --out.")
    ] = False,
    retry_errors: Annotated[
        bool,
        typer.Option("--retry-errors", help="With --resume: run trials again that ended as error."),
    ] = False,
    executor: Annotated[
        str | None,
        typer.Option(
            help="What runs the trials: processes or dask (see also --scheduler).",
            show_default="processes",
        ),
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(
            help="Address or scheduler file of a running Dask cluster.",
            show_default="a cluster on this machine",
        ),
    ] = None,
) -> None:
    """Run random grasp-and-lift trials.

    FOLDER/trials.parquet gets one row per trial, FOLDER/run.json what it takes to repeat them.
    """
    from sdh_sim.cli import lift as cli_lift

    asked = {
        "torque_limit": torque_limit,
        "sensor": sensor,
        "pads": pads,
        "grasps": grasps,
        "arm": arm,
        "timestep": timestep,
        "pad_modulus": pad_modulus,
        "load_test": load_test,
        "disturbance": disturbance,
        "repeats": repeats,
        "repeat_position": repeat_position,
        "repeat_angle": repeat_angle,
        "repeat_friction": repeat_friction,
        "position_error": position_error,
        "angle_error": angle_error,
        "friction_error": friction_error,
        "mass_error": mass_error,
    }
    cli_lift.lift_preset(
        preset,
        out,
        cli_lift.Asked(
            objects=tuple(object or ()),
            trials=trials,
            seed=seed,
            settings={name: value for name, value in asked.items() if value is not None},
            metrics=tuple(metric or ()),
        ),
        workers=workers,
        rerun=rerun,
        resume=resume,
        overwrite=overwrite,
        retry_errors=retry_errors,
        executor=executor,
        scheduler=scheduler,
        command=shlex.join(["sdh-sim", *sys.argv[1:]]),
    )


@app.command()
def compare(
    runs: Annotated[list[Path], typer.Argument(help="Run folders (the --out of a lift).")],
    csv: Annotated[Path | None, typer.Option(help="Write the numbers to this CSV file.")] = None,
    every: Annotated[
        bool, typer.Option("--all", help="All metrics, not q* under L∞ and L1 alone.")
    ] = False,
    report: Annotated[
        Path | None,
        typer.Option(help="Folder of the report with figures.", show_default="report in RUN"),
    ] = None,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no report.")] = False,
) -> None:
    """Compare predicted with simulated success.

    RUN/report/index.html shows it in figures; the numbers lie beside it as CSV and Parquet.
    """
    from sdh_sim.cli import compare as cli_compare

    cli_compare.compare(runs, csv, every=every, report=report, pages=not no_report)


@app.command()
def show(
    run: Annotated[Path, typer.Argument(help="Run folder (the --out of a lift).")],
    trial: Annotated[list[int], typer.Option(help="Number of the trial; again for more.")],
    save: Annotated[
        Path | None, typer.Option(help="Write a rerun recording here, open no viewer.")
    ] = None,
    png: Annotated[Path | None, typer.Option(help="Render a picture here, open no viewer.")] = None,
) -> None:
    """Run trials of a run again and look at them."""
    from sdh_sim.cli import show as cli_show

    cli_show.show(run, trial, save, png)


@app.command()
def render(
    run: Annotated[Path, typer.Argument(help="Run folder (the --out of a lift).")],
    trial: Annotated[int, typer.Option(help="Number of the trial.")],
    out: Annotated[Path, typer.Option(help="A .png (three moments) or an .mp4 (all of it).")],
    width: Annotated[int, typer.Option(help="Of a picture [pixels].")] = 960,
    height: Annotated[int, typer.Option(help="Of a picture [pixels].")] = 720,
    azimuth: Annotated[float, typer.Option(help="Of the camera about the object [deg].")] = 125.0,
) -> None:
    """Run one trial of a run again and draw it, without a screen."""
    from sdh_sim.cli import render as cli_render

    cli_render.render(run, trial, out, (width, height), azimuth)


@app.command()
def view(
    object: Annotated[str, typer.Argument(help="Object, or the folder of your own.")] = "box",
    seed: Annotated[int, typer.Option(help="Seed of the grasp.")] = 0,
) -> None:
    """Open MuJoCo's own viewer on the cell, the hand before a grasp."""
    from sdh_sim.cli import render as cli_render

    cli_render.view(object, seed)


@app.command()
def demo(
    out: Annotated[Path, typer.Option(help="Folder for what it makes.")] = Path("demo"),
) -> None:
    """Make a short run over all objects and look at it.

    It ends with the comparison, one rendered picture and one rerun recording.
    """
    from sdh_sim.cli.demo import run_demo

    run_demo(out)


@app.command()
def objects(
    folders: Annotated[
        list[str] | None, typer.Argument(help="Folders of your own objects, to check.")
    ] = None,
) -> None:
    """List the objects: mass, friction, size."""
    from sdh_sim.cli import lists as cli_lists

    cli_lists.objects(folders or ())


@app.command()
def hand() -> None:
    """List the hand's joints with their limits and its tactile pads."""
    from sdh_sim.cli import lists as cli_lists

    cli_lists.hand()


def main(arguments: list[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: command and options; None takes them from the process.

    Returns:
        exit status: 0 done; 2 bad input, named in one line on stderr; 130 Ctrl-C; 1 the program's
        own failure.
    """
    limit_threads()
    try:
        status = app(args=arguments, prog_name="sdh-sim", standalone_mode=False)
        sys.stdout.flush()
        return status if isinstance(status, int) else 0
    except BrokenPipeError:  # the reader (head, less) left: not an error of ours
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        return _say("interrupted", 130)
    except Exception as error:
        return _explain(error)


def _explain(error: Exception) -> int:
    """One line for what the user can mend; anything else is a fault of ours and is raised."""
    if type(error).__name__ == "Abort":  # how older typer passes on Ctrl-C
        return _say("interrupted", 130)
    if type(error).__name__ == "NoArgsIsHelpError":
        print(error)
        return 2
    message = getattr(error, "format_message", None)
    if message is not None:  # typer's own: an unknown option, a word where a number belongs
        return _say(f"{message()} (sdh-sim --help lists the commands and options)", 2)

    from sdh_sim.errors import CampaignError, RecordError, RunError, SettingsError
    from sdh_sim.settings import CHOICES, RANGES

    if isinstance(error, CampaignError):
        if error.details and os.environ.get("SDH_SIM_TRACEBACK"):
            print(error.details, file=sys.stderr)
        return _say(str(error), error.status)
    if isinstance(error, SettingsError):
        name, colon, rest = str(error).partition(":")
        option = "--" + name.replace("_", "-") if name in (*_OPTIONS, *CHOICES, *RANGES) else name
        return _say(option + colon + rest, 2)
    if isinstance(error, (RunError, RecordError)):
        return _say(str(error), 2)
    if isinstance(error, OSError):
        name = f"{error.filename}: " if error.filename else ""
        return _say(f"{name}{error.strerror or error}; choose a path that can be used", 2)
    raise error


def _say(message: str, status: int) -> int:
    print("sdh-sim: " + " ".join(message.split()), file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())
