"""Write models/parallel_jaw: MJCF, hand.toml and meshes of the gripper, from jaw_numbers.

Run ``python -m sdh_sim.modelgen.parallel_jaw`` in a checkout; the output is committed.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sdh_sim.modelgen import jaw_numbers as j
from sdh_sim.modelgen.jaw_meshes import jaw_meshes
from sdh_sim.modelgen.lofts import write_model
from sdh_sim.modelgen.object_parts import numbers
from sdh_sim.modelgen.toml_text import toml_array, toml_table, toml_value

HEADER = """<mujoco model="parallel_jaw">
  <!-- A parallel-jaw gripper. Written by `python -m sdh_sim.modelgen.parallel_jaw` from the tables
       in sdh_sim/modelgen/jaw_numbers.py; README.md says where each number comes from.
       Contact bits: 1 object and table, 2 taxel, 4 hand structure, 8 arm. Pad friction and taxel
       stiffness are set by the scene. -->
  <compiler angle="radian" meshdir="assets" autolimits="true"/>
  <option integrator="Euler" cone="elliptic" impratio="1000" tolerance="1e-10"
          timestep="0.002">
    <flag eulerdamp="disable"/>
  </option>

  <default>
    <default class="jaw">
      <geom condim="3" density="0"/>
"""
CLASSES = """      <default class="jaw_visual">
        <geom type="mesh" contype="0" conaffinity="0" group="2" material="jaw_aluminium"/>
      </default>
      <default class="jaw_structure">
        <geom type="box" contype="4" conaffinity="12" group="3" rgba="0.4 0.6 0.9 0.4"/>
      </default>
      <default class="jaw_taxel">
        <geom type="sphere" contype="2" conaffinity="0" group="4" priority="1"
              rgba="0.9 0.5 0.1 0.3"/>
      </default>
    </default>
  </default>

  <asset>
    <material name="jaw_aluminium" rgba="0.70 0.71 0.73 1" specular="0.6" shininess="0.5"/>
    <material name="jaw_dark" rgba="0.16 0.17 0.19 1" specular="0.4" shininess="0.3"/>
    <material name="jaw_rubber" rgba="0.07 0.07 0.08 1" specular="0.1" shininess="0.1"/>
"""
# The jaws slide in the guide, and the fingers stand on it: neither meets the palm.
END = """  </worldbody>

  <equality>
    <joint name="jaw_coupling" joint1="right_slide" joint2="left_slide" polycoef="0 1 0 0 0"
           solref="0.005 1" solimp="0.9999 0.9999 0.001"/>
  </equality>

  <contact>
    <exclude body1="palm" body2="left_jaw"/>
    <exclude body1="palm" body2="right_jaw"/>
  </contact>

  <actuator>
    <position name="grip" joint="left_slide" class="jaw"/>
  </actuator>
</mujoco>
"""
TOML_HEADER = """# Parallel jaw: what the model parallel_jaw.xml does not say. Written by
# `python -m sdh_sim.modelgen.parallel_jaw`
# from the tables in sdh_sim/modelgen/jaw_numbers.py. Lengths in m, forces in N.
"""


def _inertial(*parts: tuple[float, j.Box]) -> str:
    mass, com, inertia = j.inertia(*parts)
    tensor = numbers(inertia[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)], digits=10)
    return f'<inertial pos="{numbers(com)}" mass="{mass:g}" fullinertia="{tensor}"/>'


def _box(name: str, corners: j.Box) -> str:
    low, high = np.array(corners)
    return (
        f'<geom class="jaw_structure" name="{name}" pos="{numbers((low + high) / 2)}" '
        f'size="{numbers((high - low) / 2)}"/>'
    )


def _taxels(side: str) -> list[str]:
    """One sphere per taxel, its apex on the pad's surface at the taxel's centre."""
    lines = []
    for row in range(j.TAXEL_ROWS):
        for column in range(j.TAXEL_COLUMNS):
            radius = round(j.taxel_radius(row, column), 6)
            y = (column - 0.5 * (j.TAXEL_COLUMNS - 1)) * j.TAXEL_PITCH
            centre = (j.PAD_SURFACE - radius, y, 1e-3 * j.PROFILE[row, 1])
            lines.append(
                f'<geom class="jaw_taxel" name="{side}_pad_r{row:02d}_c{column}" '
                f'pos="{numbers(centre)}" size="{radius:g}"/>'
            )
    return lines


def _jaw(side: str, away: float, quat: str) -> list[str]:
    """The body of a jaw; with the jaws open its origin is at x = ``away`` in the palm frame."""
    servo = f' damping="{j.DAMPING:g}"' if side == "left" else ""
    parts = (j.CARRIAGE_MASS, j.CARRIAGE), (j.FINGER_MASS, j.FINGER)
    tip = numbers((0, 0, j.FINGER_LENGTH))
    inside = [
        _inertial(*parts),
        f'<joint name="{side}_slide" class="jaw"{servo}/>',
        '<geom class="jaw_visual" mesh="carriage" material="jaw_dark"/>',
        '<geom class="jaw_visual" mesh="finger"/>',
        '<geom class="jaw_visual" mesh="pad" material="jaw_rubber"/>',
        _box(f"{side}_carriage", j.CARRIAGE),
        f'<geom class="jaw_structure" name="{side}_finger" type="mesh" mesh="finger_core"/>',
        *_taxels(side),
        f'<site name="{side}_tip" pos="{tip}" size="0.002" group="5"/>',
    ]
    return [
        f'<body name="{side}_jaw" pos="{numbers((away, 0, 0))}" quat="{quat}">',
        *(f"  {line}" for line in inside),
        "</body>",
    ]


def jaw_mjcf() -> str:
    """The gripper's MJCF as text."""
    stroke = numbers((0.0, j.STROKE))
    away = j.STROKE + j.PAD_SURFACE
    neck = (-j.MOUNT_HEIGHT, j.NECK_TOP)
    palm = [
        _inertial((j.HOUSING_MASS, j.HOUSING), (j.GUIDE_MASS, j.GUIDE)),
        '<geom class="jaw_visual" mesh="housing"/>',
        '<geom class="jaw_visual" mesh="guide" material="jaw_dark"/>',
        '<geom class="jaw_visual" mesh="neck" material="jaw_dark"/>',
        _box("palm_housing", j.HOUSING),
        _box("palm_guide", j.GUIDE),
        f'<geom class="jaw_structure" name="palm_neck" type="cylinder" '
        f'pos="{numbers((0, 0, sum(neck) / 2))}" '
        f'size="{numbers((j.NECK_RADIUS, (neck[1] - neck[0]) / 2))}"/>',
        '<site name="palm" pos="0 0 0" size="0.002" group="5"/>',
        *_jaw("left", -away, "1 0 0 0"),
        *_jaw("right", away, "0 0 0 1"),
    ]
    lines = [
        f'      <joint type="slide" axis="1 0 0" range="{stroke}" armature="{j.ARMATURE:g}"/>',
        f'      <position kp="{j.SERVO_STIFFNESS:g}" kv="{j.SERVO_DAMPING:g}" '
        f'forcerange="{-j.RATED_FORCE:g} {j.RATED_FORCE:g}" '
        f'ctrlrange="{numbers((0.0, j.STROKE + j.OVERTRAVEL))}"/>',
        *CLASSES.splitlines(),
        *(f'    <mesh name="{name}" file="{name}.obj"/>' for name in sorted(jaw_meshes())),
        "  </asset>",
        "",
        "  <worldbody>",
        '    <body name="mount" childclass="jaw">',
        f'      <body name="palm" pos="{numbers((0, 0, j.MOUNT_HEIGHT))}">',
        *(f"        {line}" for line in palm),
        "      </body>",
        "    </body>",
    ]
    return HEADER + "\n".join(lines) + "\n" + END


def jaw_toml() -> str:
    """The content of hand.toml."""
    top = {"name": "parallel_jaw", "model": "parallel_jaw.xml", "palm": "palm", "groups": ["grip"]}
    lines = [TOML_HEADER + "\n".join(f"{key} = {toml_value(value)}" for key, value in top.items())]
    lines += toml_table(
        "motors.grip",
        {
            "group": "grip",
            "finger": "left",
            "rated": j.RATED_FORCE,
            "speed": j.MAX_SPEED,
            "closing_speed": j.CLOSING_SPEED,
            "flexes": 1,
        },
    )
    for side in ("left", "right"):
        lines += toml_table(
            f"fingers.{side}",
            {
                "bodies": [f"{side}_jaw"],
                "stops": ["grip"],
                "tip": f"{side}_jaw",
                "tip_position": [0.0, 0.0, j.FINGER_LENGTH],
                "pad_ahead": j.PAD_SURFACE,
            },
        )
    lines += toml_array("pad", j.TAXEL_COLUMNS, j.TAXEL_PITCH, j.PROFILE)
    for side in ("left", "right"):
        lines += toml_table(f"pads.{side}_pad", {"body": f"{side}_jaw", "array": "pad"})
    lines += toml_table(
        "closings.parallel",
        {
            "open": [0.0],
            "travel": [j.STROKE],
            "rate": round(j.CLOSING_SPEED / j.STROKE, 6),
            "squeeze": ["grip"],
            "depth": j.GRASP_DEPTH,
            "precision_depth": j.PRECISION_DEPTH,
        },
    )
    return "\n".join(lines) + "\n"


def write_jaw(folder: Path) -> None:
    """Write ``parallel_jaw.xml``, ``hand.toml`` and ``assets/*.obj`` below the folder."""
    texts = {"parallel_jaw.xml": jaw_mjcf(), "hand.toml": jaw_toml()}
    write_model(folder, texts, jaw_meshes())


if __name__ == "__main__":
    write_jaw(Path(__file__).resolve().parents[2] / "models" / "parallel_jaw")
