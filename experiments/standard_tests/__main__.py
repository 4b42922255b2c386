"""Standard load protocols on a hand: finger strength, grasp strength, slip, touch sensitivity.

    python -m experiments.standard_tests --out standard_tests
    python -m experiments.standard_tests --hand path/to/folder --measured measured.yaml

The protocols are those of NIST's draft SP 1227 and of ASTM WK83863. Every quantity stands beside
its closed form, and beside a measured value where a file gives one.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from rich.console import Console

from experiments.command_line import Parser, at_least, fail
from experiments.standard_tests.album import Album, draw
from experiments.standard_tests.finger_strength import finger_strength
from experiments.standard_tests.grasp_strength import grasp_strength, held_cylinders
from experiments.standard_tests.load_objects import CELL, write_objects
from experiments.standard_tests.measured import check_conditions, conditions_of, read_measured
from experiments.standard_tests.result_lines import TITLES, Line, csv_of, tables_of
from experiments.standard_tests.slip_resistance import slip_resistance
from experiments.standard_tests.specimen import Specimen, specimens
from experiments.standard_tests.touch_sensitivity import touch_sensitivity
from sdh_sim.atomic_files import write_atomic
from sdh_sim.errors import SettingsError


def test(
    specimen: Specimen, folders: dict[str, Path], wanted: list[str], seed: int, album: Album
) -> list[Line]:
    """The protocols wanted, on one hand.

    Args:
        specimen: the hand.
        folders: of the test objects, by name.
        wanted: protocols.
        seed: of the sensor's noise.
        album: that takes pictures.
    """
    lines: list[Line] = []
    if "finger_strength" in wanted:
        lines += finger_strength(specimen, folders[CELL], album)
    if {"grasp_strength", "slip_resistance"} & set(wanted):
        held = held_cylinders(specimen, folders, seed, album)
        if "grasp_strength" in wanted:
            lines += grasp_strength(specimen, held)
        if "slip_resistance" in wanted:
            lines += slip_resistance(specimen, held, album)
    if "touch_sensitivity" in wanted:
        lines += touch_sensitivity(specimen, folders[CELL], seed, album)
    return lines


def main(argv: list[str] | None = None) -> None:
    """Print the tables, draw a figure for each protocol."""
    parser = Parser(__doc__)
    parser.add_argument("--hand", help="name, or folder of your own; default: SDH-2, parallel jaw")
    parser.add_argument("--only", nargs="*", choices=list(TITLES), help="protocols [all]")
    parser.add_argument("--drive", choices=("yield", "hold", "lock"), default="yield",
                        help="of the motors [yield]")  # fmt: skip
    parser.add_argument("--seed", type=int, default=0, help="of the sensor's noise [0]")
    parser.add_argument("--measured", type=Path, help="YAML file of measured values")
    parser.add_argument("--no-pictures", action="store_true", help="charts alone")
    parser.add_argument("--out", type=Path, default=Path("standard_tests"), help="folder")
    args = parser.parse_args(argv)
    at_least(parser, args, seed=0)
    wanted = args.only or list(TITLES)
    console = Console(width=150)
    try:
        name, measured = read_measured(args.measured) if args.measured else ("", {})
        hands = specimens(args.hand, args.drive)
        folders = write_objects(args.out / "objects")
        album = Album(not args.no_pictures)
        lines: list[Line] = []
        for specimen in hands:
            lines += test(specimen, folders, wanted, args.seed, album)
        if args.measured:
            check_conditions(args.measured, measured, conditions_of(lines))
        for table in tables_of(lines, measured):
            console.print(table)
        if name:
            print(f"measured: {name}")
        write_atomic(args.out / "standard_tests.csv", csv_of(lines, measured).encode())
        about = {"seed": args.seed, "settings": {h.name: h.settings.to_dict() for h in hands}}
        write_atomic(args.out / "standard_tests.json", json.dumps(about, indent=1).encode())
        print(f"table: {args.out / 'standard_tests.csv'}; settings: standard_tests.json beside it")
        for protocol in wanted:
            own = [line for line in lines if line.protocol == protocol]
            if own:
                print(f"figure: {draw(protocol, own, measured, album, args.out / protocol)}")
        if album.lost and not args.no_pictures:
            print(f"no pictures of the tests: {album.lost}", file=sys.stderr)
    except SettingsError as error:
        fail(str(error))
    except OSError as error:
        fail(f"cannot write to {args.out}: {error.strerror or error}; choose another --out")
    if any(line.agrees is False for line in lines):
        print("! marks what is further from its closed form than its tolerance")


if __name__ == "__main__":
    main()
