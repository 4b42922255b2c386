"""Damaged folders of hands (TOML, MJCF, mesh); ``frame`` says how to run this by hand.

Only HandError with one line may come out, within bounded time and memory.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np

from sdh_sim.errors import SettingsError
from sdh_sim.robot import HandKinematics, hand_spec, read_hand_folder
from tests.fuzz.damaged_objects import words_changed
from tests.fuzz.frame import Target, main, mutated
from tests.support.hand_folders import GRIPPER, TETRAHEDRON, TOML, write_hand

MEMORY = 6 << 30  # [bytes] of address space: a claim of more must be refused, not tried

# Passive joints, a spring and an include, besides what the gripper has.
MODEL = GRIPPER.replace(
    '<geom name="left_box" class="finger"/>',
    '<geom name="left_box" class="finger"/><body name="flap" pos="0 0.02 0">'
    '<joint name="flap" axis="0 0 1" stiffness="0.1" range="-1 1"/>'
    '<geom type="capsule" size="0.004 0.01" mass="0.01"/></body>',
).replace("<light pos", '<include file="more.xml"/><light pos')
MORE = """<mujocoinclude>
  <body name="cap" pos="0 0 0">
    <inertial pos="0 0 0" mass="0.1" diaginertia="1e-4 1e-4 1e-4"/>
    <geom type="cylinder" size="0.03 0.01" quat="1 0 0 0" rgba="1 0 0 1"/>
  </body>
</mujocoinclude>
"""
TOML_MORE = """
[joints.flap]
damping = 0.01
armature = 1e-4
"""


def numbers_changed(text: bytes, rng: np.random.Generator) -> bytes:
    """The text with one of its numbers a little different: most hands go on from there."""
    found = list(re.finditer(rb"-?\d+\.\d+", text))
    at = found[int(rng.integers(len(found)))]
    value = float(at[0]) * rng.uniform(0.8, 1.2)
    return text[: at.start()] + f"{value:.6g}".encode() + text[at.end() :]


class DamagedHand(Target):
    """A folder of a hand and the ways to damage and read it."""

    refusals = (SettingsError,)

    def __init__(self, path: Path) -> None:
        self.path = path / "gripper"

    def damage(self, rng: np.random.Generator) -> str:
        """Write a folder with one damaged file; says which."""
        write_hand(self.path, MODEL, TOML + TOML_MORE)
        (self.path / "more.xml").write_text(MORE, encoding="utf-8")
        change = (words_changed, mutated, numbers_changed)[int(rng.integers(3))]
        what, file, good = (
            ("toml", "hand.toml", (TOML + TOML_MORE).encode()),
            ("toml", "hand.toml", (TOML + TOML_MORE).encode()),
            ("mjcf", "gripper.xml", MODEL.encode()),
            ("mjcf", "gripper.xml", MODEL.encode()),
            ("mjcf include", "more.xml", MORE.encode()),
            ("mesh", "parts/shell.stl", TETRAHEDRON),
        )[int(rng.integers(6))]
        (self.path / file).write_bytes(change(good, rng))
        return what

    def readers(self) -> list[Callable[[], object]]:
        """The one reader of hands, MuJoCo's compiler and the kinematics after it."""

        def read() -> None:
            hand = read_hand_folder(self.path)
            model = hand_spec(hand).compile()
            assert np.isfinite(model.body_mass).all()
            assert model.nplugin == model.nkey == model.nsensor == model.nlight == 0
            closing = next(iter(hand.closings.values()))
            joints = HandKinematics(hand).joint_positions(closing.closed)
            assert np.isfinite(joints).all()

        return [read]

    def check_message(self, text: str) -> None:
        """It says that the hand is at fault, and can be printed."""
        assert text.startswith("hand: ")
        assert text.isprintable()
        assert len(text) < 1500


if __name__ == "__main__":
    main(DamagedHand, MEMORY)
