"""``sdh-sim hand`` for built-in hands and users' folders."""

from __future__ import annotations

from sdh_sim.cli import main
from tests.support.hand_folders import GRIPPER, TOML, write_hand


def run(capsys, *words):
    code = main(["hand", *map(str, words)])
    printed = capsys.readouterr()
    return code, printed.out, printed.err


def test_a_built_in_hand(capsys):
    code, out, _ = run(capsys)
    assert code == 0
    assert "spread_coupled     0 (coupled)   2.1 N m    0.000 to 1.571 rad" in out
    assert "finger1_distal       13         6            68        3.4" in out
    code, out, _ = run(capsys, "parallel_jaw")
    assert code == 0
    # One motor of 100 N: each jaw alone bears all of it, both together half each.
    row = next(line.split() for line in out.splitlines() if line.strip().startswith("parallel "))
    assert row == ["parallel", "grip", "140.0", "to", "0.0", "100", "50"]


def test_a_folder_is_checked_and_described(capsys, tmp_path):
    code, out, _ = run(capsys, write_hand(tmp_path / "gripper"))
    assert code == 0
    lines = [line.split() for line in out.splitlines()]
    # Pads 80 mm apart, each jaw 40 mm of travel; 60 N on the tendon of both.
    assert ["parallel", "grip", "80.0", "to", "0.0", "60", "30"] in lines
    assert "pads.left: 20 taxels made" in out
    assert "gripper: motor groups grip" in out


def test_passive_joints_are_named(capsys, tmp_path):
    flap = GRIPPER.replace(
        '<geom name="left_box" class="finger"/>',
        '<geom name="left_box" class="finger"/><body name="flap" pos="0 0.1 0">'
        '<joint name="flap" axis="0 0 1" stiffness="0.1"/><geom size="0.01"/></body>',
    )
    code, out, _ = run(capsys, write_hand(tmp_path / "hand", flap))
    assert code == 0
    assert "passive, held by spring or stop: flap" in out


def test_what_is_wrong_is_said_in_one_line(capsys, tmp_path):
    bad = TOML.replace("travel = [0.04]", "travel = [0.0]")
    code, out, err = run(capsys, write_hand(tmp_path / "hand", toml=bad))
    assert code == 2
    assert out == ""
    assert "closings.parallel does not close" in err
    assert err.count("\n") == 1
    code, _, err = run(capsys, "claw")
    assert code == 2
    assert "got 'claw'; choose one of parallel_jaw, schunk_sdh2" in err
