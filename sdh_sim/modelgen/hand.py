"""Write models/schunk_sdh2: MJCF, hand.toml and meshes of the hand, from sdh2_constants.

Run ``python -m sdh_sim.modelgen.hand`` in a checkout; the output is committed.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from sdh_sim.modelgen.hand_meshes import hand_meshes
from sdh_sim.modelgen.hand_toml import hand_toml
from sdh_sim.modelgen.lofts import write_model
from sdh_sim.robot import sdh2_constants as c

# Assumptions (not published for this hand), stated once:
ARMATURE = {"spread": 0.005, "proximal": 0.002, "distal": 0.002}  # reflected rotor inertia
DAMPING = {"spread": 0.2, "proximal": 0.05, "distal": 0.05}  # viscous, N m s/rad
STIFFNESS = {"spread": 30.0, "proximal": 20.0, "distal": 20.0}  # servo gain kp, N m/rad
SERVO_DAMPING = {"spread": 0.8, "proximal": 0.5, "distal": 0.5}  # servo gain kv, N m s/rad

HEADER = """<mujoco model="schunk_sdh2">
  <!-- Schunk SDH-2. Written by `python -m sdh_sim.modelgen.hand` from the tables in
       sdh_sim/robot/sdh2_constants.py; README.md says where each number comes from. Contact bits:
       1 object and table, 2 taxel, 4 hand structure, 8 arm. Pad friction and taxel stiffness are
       set by the scene. -->
  <compiler angle="radian" meshdir="assets" autolimits="true"/>
  <option integrator="Euler" cone="elliptic" impratio="1000" tolerance="1e-10"
          timestep="0.002">
    <flag eulerdamp="disable"/>
  </option>

  <default>
    <default class="sdh2">
      <geom condim="3" density="0"/>
      <joint axis="0 1 0"/>
      <default class="sdh2_visual">
        <geom type="mesh" contype="0" conaffinity="0" group="2" material="sdh2_aluminium"/>
      </default>
      <default class="sdh2_structure">
        <geom contype="4" conaffinity="12" group="3" rgba="0.4 0.6 0.9 0.4"/>
      </default>
      <default class="sdh2_taxel">
        <geom type="sphere" contype="2" conaffinity="0" group="4" priority="1"
              rgba="0.9 0.5 0.1 0.3"/>
      </default>
"""


def _vec(values: object) -> str:
    numbers = np.atleast_1d(np.asarray(values, dtype=float))
    return " ".join(f"{round(float(v), 9) + 0.0:.9g}" for v in numbers)


def _inertial(i: c.Inertia) -> str:
    ixx, iyy, izz, iyz = i.inertia
    return (
        f'<inertial pos="{_vec(i.com)}" mass="{i.mass:g}" '
        f'fullinertia="{_vec([ixx, iyy, izz, 0.0, 0.0, iyz])}"/>'
    )


def taxel_radius(kind: str, row: int, column: int) -> float:
    """Radius [m] of the sphere that stands for one taxel's rubber.

    Neighbouring spheres must overlap deeply or an object's edge catches between them, so up to
    four pitches; but the sphere must not stand out of the finger beside the pad (its flank is at
    y = 13.9 mm, hence 4.5 pitches less the distance from the middle) nor behind it.
    """
    lateral = abs(column - 0.5 * (c.TAXEL_COLUMNS - 1)) * c.TAXEL_PITCH
    radius = 4.5 * c.TAXEL_PITCH - lateral
    x, z, _ = c.PAD_PROFILE[kind][row] * 1e-3
    # Straight back face of the distal link, from (-12.74, 12) to (-7.18, 64.9) mm.
    back = -12.74e-3 + (z - 12e-3) * (12.74 - 7.18) / (64.9 - 12.0) if kind == "distal" else -12e-3
    return min(radius, 0.48 * (x - back))


def taxel_geoms(finger: str, kind: str, indent: str) -> list[str]:
    """One sphere geom per live taxel, its apex on the pad surface at the taxel's centre."""
    lines = []
    for row in range(c.TAXEL_ROWS[kind]):
        for column in range(c.TAXEL_COLUMNS):
            if not c.taxel_is_live(kind, row, column):
                continue
            apex, normal = c.pad_surface(kind, row, column)
            radius = round(taxel_radius(kind, row, column), 6)
            centre = apex - radius * normal
            lines.append(
                f'{indent}<geom class="sdh2_taxel" name="{finger}_{kind}_r{row:02d}_c{column}" '
                f'pos="{_vec(np.round(centre, 8))}" size="{radius:g}"/>'
            )
    return lines


def _finger(finger: c.Finger, indent: str = "      ") -> list[str]:
    name = finger.name
    half = 0.5 * finger.yaw
    i1, i2, i3 = indent + "  ", indent + "    ", indent + "      "
    lines = [
        f'{indent}<body name="{name}_knuckle" pos="{_vec(finger.base)}" '
        f'quat="{_vec([math.cos(half), 0, 0, math.sin(half)])}">',
        f"{i1}{_inertial(c.KNUCKLE_INERTIA)}",
    ]
    if finger.spread_sign:
        joint = "spread" if finger.spread_sign > 0 else c.COUPLED_JOINT
        lines.append(
            f'{i1}<joint name="{joint}" class="sdh2_spread" axis="0 0 {finger.spread_sign}"/>'
        )
    lines += [
        f'{i1}<geom class="sdh2_visual" mesh="knuckle" material="sdh2_dark"/>',
        f'{i1}<geom class="sdh2_structure" name="{name}_knuckle_disc" type="cylinder" '
        'pos="0 0 0.003" size="0.0224 0.003"/>',
        f'{i1}<geom class="sdh2_structure" name="{name}_knuckle_axle" type="cylinder" '
        'pos="0 0.00335 0.0165" zaxis="0 1 0" size="0.014 0.0231"/>',
        f'{i1}<body name="{name}_proximal" pos="0 0 {c.KNUCKLE_HEIGHT}">',
        f"{i2}{_inertial(c.PROXIMAL_INERTIA)}",
        f'{i2}<joint name="{name}_proximal" class="sdh2_proximal"/>',
        f'{i2}<geom class="sdh2_visual" mesh="proximal"/>',
        f'{i2}<geom class="sdh2_visual" mesh="proximal_pad" material="sdh2_rubber"/>',
        f'{i2}<geom class="sdh2_structure" name="{name}_proximal_link" type="box" '
        'pos="0 0 0.0455" size="0.012 0.0139 0.0335"/>',
        *taxel_geoms(name, "proximal", i2),
        f'{i2}<body name="{name}_distal" pos="0 0 {c.PROXIMAL_LENGTH}">',
        f"{i3}{_inertial(c.DISTAL_INERTIA)}",
        f'{i3}<joint name="{name}_distal" class="sdh2_distal"/>',
        f'{i3}<geom class="sdh2_visual" mesh="distal"/>',
        f'{i3}<geom class="sdh2_visual" mesh="distal_pad" material="sdh2_rubber"/>',
        f'{i3}<geom class="sdh2_structure" name="{name}_distal_axle" type="cylinder" '
        'pos="0 0 0" zaxis="0 1 0" size="0.0135 0.0139"/>',
        f'{i3}<geom class="sdh2_structure" name="{name}_distal_link" type="mesh" '
        'mesh="distal_core"/>',
        *taxel_geoms(name, "distal", i3),
        f'{i3}<site name="{name}_tip" pos="0 0 {c.DISTAL_LENGTH}" size="0.002" group="5"/>',
        f"{i2}</body>",
        f"{i1}</body>",
        f"{indent}</body>",
    ]
    return lines


def hand_mjcf() -> str:
    """The hand's MJCF as text."""
    lines = [HEADER.rstrip("\n")]
    for kind, limits in (
        ("spread", c.SPREAD_RANGE),
        ("proximal", c.PHALANX_RANGE),
        ("distal", c.PHALANX_RANGE),
    ):
        torque = c.DATASHEET_TORQUE[kind]
        lines += [
            f'      <default class="sdh2_{kind}">',
            f'        <joint range="{_vec(limits)}" armature="{ARMATURE[kind]}" '
            f'damping="{DAMPING[kind]}"/>',
            f'        <position kp="{STIFFNESS[kind]:g}" kv="{SERVO_DAMPING[kind]:g}" '
            f'forcerange="{-torque} {torque}" ctrlrange="{_vec(limits)}"/>',
            "      </default>",
        ]
    lines += [
        "    </default>",
        "  </default>",
        "",
        "  <asset>",
        '    <material name="sdh2_aluminium" rgba="0.62 0.63 0.66 1" specular="0.7" '
        'shininess="0.5"/>',
        '    <material name="sdh2_dark" rgba="0.28 0.29 0.31 1" specular="0.5" shininess="0.4"/>',
        '    <material name="sdh2_rubber" rgba="0.07 0.07 0.08 1" specular="0.1" shininess="0.1"/>',
    ]
    lines += [f'    <mesh name="{name}" file="{name}.obj"/>' for name in sorted(hand_meshes())]
    lines += [
        "  </asset>",
        "",
        "  <worldbody>",
        '    <body name="mount" childclass="sdh2">',
        f'      <body name="palm" pos="0 0 {c.MOUNT_HEIGHT}">',
        f"        {_inertial(c.PALM_INERTIA)}",
        '        <geom class="sdh2_visual" mesh="palm"/>',
        '        <geom class="sdh2_visual" mesh="palm_plate" material="sdh2_dark"/>',
        '        <geom class="sdh2_structure" name="palm_housing" type="mesh" mesh="palm_core"/>',
        '        <geom class="sdh2_structure" name="palm_boss" type="cylinder" pos="0 0 0.004" '
        'size="0.034 0.0115"/>',
        '        <site name="palm" pos="0 0 0" size="0.002" group="5"/>',
    ]
    for finger in c.FINGERS:
        lines += _finger(finger, "        ")
    lines += [
        "      </body>",
        "    </body>",
        "  </worldbody>",
        "",
        "  <equality>",
        f'    <joint name="spread_coupling" joint1="{c.COUPLED_JOINT}" joint2="spread" '
        'polycoef="0 1 0 0 0" solref="0.008 1" solimp="0.99 0.99 0.001"/>',
        "  </equality>",
        "",
        "  <contact>",
    ]
    # Axles overlap by design. MuJoCo leaves out moving neighbours by itself, but not neighbours
    # of a welded body (the thumb's knuckle, the palm), nor those two joints apart.
    for f in c.FINGERS:
        pairs = [("palm", "knuckle"), ("palm", "proximal"), ("knuckle", "proximal")]
        pairs += [("knuckle", "distal"), ("proximal", "distal")]
        for a, b in pairs:
            first = a if a == "palm" else f"{f.name}_{a}"
            lines.append(f'    <exclude body1="{first}" body2="{f.name}_{b}"/>')
    lines += ["  </contact>", "", "  <actuator>"]
    lines += [
        f'    <position name="{m.name}" joint="{m.name}" class="sdh2_{m.kind}"/>' for m in c.MOTORS
    ]
    lines += ["  </actuator>", "</mujoco>", ""]
    return "\n".join(lines)


def write_hand(folder: Path) -> None:
    """Write ``sdh2.xml``, ``hand.toml`` and ``assets/*.obj`` below the folder."""
    texts = {"sdh2.xml": hand_mjcf(), "hand.toml": hand_toml()}
    write_model(folder, texts, hand_meshes())


if __name__ == "__main__":
    write_hand(Path(__file__).resolve().parents[2] / "models" / "schunk_sdh2")
