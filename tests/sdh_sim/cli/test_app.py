"""The command itself: help, version, lists, commands that there are not."""

from __future__ import annotations

import re
import subprocess
import sys

from sdh_sim.cli.app import main
from tests.support.command_line import fails
from tests.support.repository import ROOT


def test_unknown_commands(capsys):
    assert "'fly'" in fails(capsys, "fly")
    assert "--fly" in fails(capsys, "--fly")


def test_lists(capsys):
    assert main(["objects"]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"cylindrical_bottle\s+0\.556\s+0\.60\s", printed)
    assert main(["hand"]) == 0
    printed = capsys.readouterr().out
    assert re.search(r"14\s+6\s+84\s", printed)
    assert "N m" in printed


def test_help_loads_nothing_heavy():
    code = (
        "import sys, sdh_sim.cli as c; c.main(['lift', '--help']); "
        "print(sorted({'mujoco', 'numpy', 'rerun', 'pyarrow', 'scipy'} & set(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert "--torque-limit" in done.stdout
    assert done.stdout.splitlines()[-1] == "[]"


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.strip()
