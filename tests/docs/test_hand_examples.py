"""The examples of ``docs/examples/hands``: read, and checked on robosuite's models where they are.

SDH_SIM_ROBOSUITE names the folder ``robosuite/models/assets/grippers`` of a copy that is not
installed.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
from pathlib import Path

import pytest

from sdh_sim.cli import main
from sdh_sim.robot import hand_kinematics, read_hand_folder
from sdh_sim.robot.hand_file import model_of, read_hand_file
from sdh_sim.sensing.pad_forces import pad_forces
from tests.support.repository import ROOT

EXAMPLES = sorted((ROOT / "docs/examples/hands").glob("*/hand.toml"))
TOGETHER = {"panda": 70.0, "robotiq140": 60.0, "robotiq85": 100.0, "xarm7": 30.0}
"""Force of each pad that its file says the maker states, reached halfway within a third [N]."""
PASSIVE = {"robotiq85": 4}


def grippers() -> Path | None:
    """The folder of robosuite's grippers; robosuite is not imported."""
    named = os.environ.get("SDH_SIM_ROBOSUITE")
    if named:
        return Path(named)
    found = importlib.util.find_spec("robosuite")
    origin = found.origin if found else None
    return Path(origin).parent / "models/assets/grippers" if origin else None


def test_there_are_examples_and_the_page_names_them():
    text = (ROOT / "docs/hands.md").read_text(encoding="utf-8")
    assert [path.parent.name for path in EXAMPLES] == sorted(TOGETHER)
    for name in ("| Panda |", "| Robotiq 2F-85 |", "| Robotiq 2F-140 |", "| xArm |"):
        assert name in text


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_an_example_is_a_hand_toml(path):
    data = path.read_bytes()
    motors = re.findall(r"^\[motors\.(\w+)\]", path.read_text(encoding="utf-8"), re.MULTILINE)
    hand = read_hand_file(data, path.parent, lambda _: dict.fromkeys(motors, (-10.0, 10.0)))
    assert hand.name == path.parent.name
    assert model_of(data)[0].endswith(".xml")
    assert len(hand.pads) == len(hand.fingers) == 2


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_an_example_fits_the_model_of_robosuite(path, tmp_path, capsys):
    folder = grippers()
    if folder is None:
        pytest.skip("robosuite is not installed; pip install --no-deps robosuite==1.5.2")
    name = path.parent.name
    model = folder / model_of(path.read_bytes())[0]
    shutil.copy(model, tmp_path)
    for file in set(re.findall(r'file="([^"]+)"', model.read_text(encoding="utf-8"))):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        if (folder / file).is_file():  # a model names one that robosuite lacks, and does not read
            shutil.copy(folder / file, tmp_path / file)
    shutil.copy(path, tmp_path / "hand.toml")
    hand = read_hand_folder(tmp_path)
    kinematics = hand_kinematics(hand)
    assert len(kinematics.passive) == PASSIVE.get(name, 0)
    forces = pad_forces(kinematics, "parallel")
    assert forces.together == pytest.approx(TOGETHER[name], rel=0.34)
    # One motor for two pads alike: each bears twice as much alone.
    assert forces.alone["left"] == pytest.approx(2.0 * forces.together, rel=1e-3)
    assert main(["hand", str(tmp_path)]) == 0
    assert "taxels made" in capsys.readouterr().out
