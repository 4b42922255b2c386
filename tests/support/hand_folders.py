"""Folders of small hands, written by the tests."""

from __future__ import annotations

from pathlib import Path

GRIPPER = """<mujoco model="gripper">
  <compiler angle="radian" meshdir="parts"/>
  <option timestep="0.004"/>
  <default>
    <geom density="500"/>
    <default class="finger">
      <geom type="box" size="0.01 0.012 0.04" friction="3" contype="1" conaffinity="1"/>
      <joint type="slide" range="0 0.04" armature="0.5" damping="5"/>
    </default>
  </default>
  <asset><mesh name="shell" file="shell.stl"/></asset>
  <worldbody>
    <light pos="0 0 1"/>
    <body name="base">
      <geom type="box" size="0.06 0.02 0.02" pos="0 0 0.02"/>
      <geom type="mesh" mesh="shell" contype="0" conaffinity="0"/>
      <body name="left" pos="-0.05 0 0.08">
        <joint name="left" class="finger" axis="1 0 0"/>
        <geom name="left_box" class="finger"/>
      </body>
      <body name="right" pos="0.05 0 0.08">
        <joint name="right" class="finger" axis="-1 0 0"/>
        <geom name="right_box" class="finger"/>
      </body>
    </body>
  </worldbody>
  <tendon>
    <fixed name="pull"><joint joint="left" coef="0.5"/><joint joint="right" coef="0.5"/></fixed>
  </tendon>
  <equality><joint joint1="right" joint2="left" polycoef="0 1 0 0 0"/></equality>
  <actuator>
    <position name="grip" tendon="pull" kp="4000" kv="100" ctrlrange="0 0.05"/>
  </actuator>
</mujoco>
"""

TOML = """name = "gripper"
model = "gripper.xml"
palm = "base"
groups = ["grip"]

[motors.grip]
group = "grip"
finger = "left"
rated = 60.0
speed = 0.1
closing_speed = 0.05

[fingers.left]
bodies = ["left"]
stops = ["grip"]
tip = "left"
tip_position = [0.0, 0.0, 0.04]
pad_ahead = 0.01

[fingers.right]
bodies = ["right"]
stops = ["grip"]
tip = "right"
tip_position = [0.0, 0.0, 0.04]
pad_ahead = 0.01

[arrays.flat]
rows = 5
columns = 4
pitch = 0.004

[pads.left]
body = "left"
array = "flat"
pos = [0.01, 0.0, 0.02]
replaces = ["left_box"]

[pads.right]
body = "right"
array = "flat"
pos = [-0.01, 0.0, 0.02]
quat = [0.0, 0.0, 0.0, 1.0]

[closings.parallel]
open = [0.0]
travel = [0.04]
rate = 1.0
squeeze = ["grip"]
depth = [0.08, 0.12]
"""

TETRAHEDRON = b"""solid t
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0 0.02 0
vertex 0.02 0 0
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0.02 0 0
vertex 0 0 0.02
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0 0 0
vertex 0 0 0.02
vertex 0 0.02 0
endloop
endfacet
facet normal 0 0 0
outer loop
vertex 0.02 0 0
vertex 0 0.02 0
vertex 0 0 0.02
endloop
endfacet
endsolid t
"""


def write_hand(folder: Path, model: str = GRIPPER, toml: str = TOML) -> Path:
    """A folder with a gripper: two jaws on one tendon, tied by an equality, and a shell of a mesh.

    Args:
        folder: made where it is missing.
        model: content of ``gripper.xml``.
        toml: content of ``hand.toml``.
    """
    (folder / "parts").mkdir(parents=True, exist_ok=True)
    (folder / "gripper.xml").write_text(model, encoding="utf-8")
    (folder / "hand.toml").write_text(toml, encoding="utf-8")
    (folder / "parts" / "shell.stl").write_bytes(TETRAHEDRON)
    return folder
