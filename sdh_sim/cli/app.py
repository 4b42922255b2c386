"""The command ``sdh-sim``: its commands and options, and the one line that bad input gets.

What needs MuJoCo, rerun or a table is imported by the command that uses it: help stays quick.
"""

from __future__ import annotations

import itertools
import os
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from sdh_sim.cli.lift_request import LiftRequest
from sdh_sim.cli.options import options_from
from sdh_sim.errors import CampaignError, RecordError, RunError, SettingsError
from sdh_sim.run_options import RunOptions
from sdh_sim.setting_table import settings_of
from sdh_sim.settings import TrialSettings
from sdh_sim.thread_limits import limit_threads

app = typer.Typer(
    help="Grasp, lift and compare: trials of the Schunk SDH-2 hand in MuJoCo.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
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
@options_from(LiftRequest, TrialSettings, RunOptions)
def lift(**given: Any) -> None:
    """Run grasp-and-lift trials, of random grasps or those of a file.

    FOLDER/trials.parquet gets one row per trial, FOLDER/run.json what it takes to repeat them.
    """
    from sdh_sim.cli import lift as cli_lift

    cli_lift.lift(LiftRequest.from_command_line(given))


@app.command()
def compare(
    runs: Annotated[list[Path], typer.Argument(help="Run folders (the --out of a lift).")],
    csv: Annotated[Path | None, typer.Option(help="Write the numbers to this CSV file.")] = None,
    every: Annotated[
        bool, typer.Option("--all", help="All metrics, not q* under L∞ and L1 alone.")
    ] = False,
    by_hand: Annotated[
        bool, typer.Option("--by-hand", help="Take runs of different hands, and show them apart.")
    ] = False,
    report: Annotated[
        Path | None,
        typer.Option(help="Folder of the report with figures.", show_default="report in RUN"),
    ] = None,
    no_report: Annotated[bool, typer.Option("--no-report", help="Write no report.")] = False,
    metrics: Annotated[
        list[str] | None,
        typer.Option(
            help="Rank these metrics on the stored grasps, too: all, field, names, or your own as "
            "file.py:function; again or with commas for more."
        ),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(min=1, help="Processes for --metrics.", show_default="one per core"),
    ] = None,
    pictures: Annotated[
        int,
        typer.Option(
            min=0, help="Run this many of the worst mispredictions again and show their pictures."
        ),
    ] = 0,
) -> None:
    """Compare predicted with simulated success.

    RUN/report/index.html shows it in figures; the numbers lie beside it as CSV and Parquet.
    """
    from sdh_sim.cli import compare as cli_compare

    cli_compare.compare(
        runs, csv, every=every, by_hand=by_hand, report=report, pages=not no_report,
        metrics=metrics or (), workers=workers, pictures=pictures,
    )  # fmt: skip


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
def grasps(
    run: Annotated[Path, typer.Argument(help="Run folder (the --out of a lift).")],
    out: Annotated[
        Path, typer.Option(help="File to write: .parquet, .csv, .json or .yaml (isaac_grasp).")
    ],
    object: Annotated[
        list[str] | None, typer.Option(help="Grasps of this object alone; again for more.")
    ] = None,
    success: Annotated[bool, typer.Option("--success", help="Only grasps that held.")] = False,
) -> None:
    """Write the grasps of a run to a file, which lift --grasps takes again."""
    from sdh_sim.cli import grasps as cli_grasps

    cli_grasps.write(run, out, object or (), only_held=success)


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
    grasps: Annotated[
        Path | None, typer.Option(help="File with the grasp, in place of a random one.")
    ] = None,
    grasp: Annotated[
        str | None, typer.Option(help="Its name in the file.", show_default="the first")
    ] = None,
) -> None:
    """Open MuJoCo's own viewer on the cell, the hand before a grasp."""
    from sdh_sim.cli import render as cli_render

    cli_render.view(object, seed, grasps, grasp)


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
def hand(
    given: Annotated[
        str | None,
        typer.Argument(
            metavar="[HAND]", help="A hand's name, or the folder of your own, to check."
        ),
    ] = None,
) -> None:
    """Show a hand: motors, joints, tactile pads, closings and how hard its pads press."""
    from sdh_sim.cli import hand as cli_hand

    cli_hand.hand(given)


_OPTION_OF = {
    name: line.flag
    for table in (TrialSettings, RunOptions, LiftRequest)
    for name, line in settings_of(table).items()
    if line.option
}


def main(arguments: list[str] | None = None) -> int:
    """Run the command line.

    Args:
        arguments: command and options; None takes them from the process.

    Returns:
        exit status: 0 done; 2 bad input, named in one line on stderr; 130 Ctrl-C; 1 the program's
        own failure.
    """
    limit_threads()
    arguments = one_by_one(sys.argv[1:] if arguments is None else arguments, "--torque-limit")
    try:
        status = app(args=arguments, prog_name="sdh-sim", standalone_mode=False)
        sys.stdout.flush()
        return status if isinstance(status, int) else 0
    except BrokenPipeError:  # the reader (head, less) has ended: no error
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        return _say("interrupted", 130)
    except Exception as error:
        return _explain(error)


def one_by_one(arguments: list[str], option: str) -> list[str]:
    """The arguments with an option that takes several numbers given again for each of them."""
    found: list[str] = []
    taking = False
    for before, word in itertools.pairwise(["", *arguments]):
        if word == option:
            taking = True
        elif not (taking and _is_number(word)):
            taking = False
        elif before != option:
            found.append(option)
        found.append(word)
    return found


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _explain(error: Exception) -> int:
    """One line for what the user can correct; anything else is a bug and is raised."""
    if type(error).__name__ == "Abort":  # how older typer passes on Ctrl-C
        return _say("interrupted", 130)
    if type(error).__name__ == "NoArgsIsHelpError":
        print(error)
        return 2
    message = getattr(error, "format_message", None)
    if message is not None:  # typer's own: an unknown option, a word where a number belongs
        return _say(f"{message()} (sdh-sim --help lists the commands and options)", 2)

    if isinstance(error, CampaignError):
        if error.details and os.environ.get("SDH_SIM_TRACEBACK"):
            print(error.details, file=sys.stderr)
        return _say(str(error), error.status)
    if isinstance(error, SettingsError):
        name, colon, rest = str(error).partition(":")
        return _say(_OPTION_OF.get(name, name) + colon + rest, 2)
    if isinstance(error, (RunError, RecordError)):
        return _say(str(error), 2)
    if isinstance(error, OSError):
        name = f"{error.filename}: " if error.filename else ""
        return _say(f"{name}{error.strerror or error}; choose a path that can be used", 2)
    raise error


def _say(message: str, status: int) -> int:
    print("sdh-sim: " + " ".join(message.split()), file=sys.stderr)
    return status
