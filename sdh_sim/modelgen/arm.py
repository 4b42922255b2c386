"""Write models/kuka_kr5_sixx_r850: the MJCF of the arm and its meshes.

Run ``python -m sdh_sim.modelgen.arm`` in a checkout; the output is committed. All link frames are
parallel to the base frame in the zero pose, with their origin on the link's joint line; the
README beside the model says where the numbers come from and which are assumptions.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import trimesh

from sdh_sim.modelgen.arm_meshes import JOINT_POINTS, link_solids
from sdh_sim.modelgen.lofts import combine, solid_inertia, write_model

Array = npt.NDArray[np.float64]
Point = tuple[float, float, float]

TOTAL_MASS = 29.0  # kg
FLANGE: Point = (0.56, 0.0, 0.79)  # m, in the base frame at the zero pose; faces +x


@dataclass(frozen=True)
class ArmJoint:
    """A joint line at the zero pose in the base frame [m], with its limits [deg, deg/s].

    The servo's numbers are assumptions: reflected rotor inertia [kg m²], viscous damping
    [N m s/rad], stiffness [N m/rad], servo damping [N m s/rad] and largest torque [N m].
    """

    point: Point
    axis: Point
    limits: tuple[float, float]
    speed: float
    armature: float
    damping: float
    stiffness: float
    servo_damping: float
    torque: float


JOINTS: tuple[ArmJoint, ...] = (
    ArmJoint(JOINT_POINTS[0], (0, 0, -1), (-170, 170), 250, 2.0, 10.0, 20000, 600, 300),
    ArmJoint(JOINT_POINTS[1], (0, 1, 0), (-100, 135), 250, 2.0, 10.0, 20000, 600, 300),
    ArmJoint(JOINT_POINTS[2], (0, 1, 0), (-209, 76), 250, 1.5, 6.0, 15000, 350, 200),
    ArmJoint(JOINT_POINTS[3], (-1, 0, 0), (-190, 190), 410, 0.3, 1.5, 3000, 65, 60),
    ArmJoint(JOINT_POINTS[4], (0, 1, 0), (-120, 120), 410, 0.3, 1.5, 3000, 70, 60),
    ArmJoint(JOINT_POINTS[5], (-1, 0, 0), (-350, 350), 660, 0.1, 0.5, 1500, 26, 30),
)

# kg, base then links 1 to 6: volumes of the link solids, one density, rounded to 0.1 kg.
VOLUME_SPLIT = (7.6, 7.8, 6.0, 4.9, 2.4, 0.3, 0.1)
LINK_MASSES = tuple(m * TOTAL_MASS / sum(VOLUME_SPLIT) for m in VOLUME_SPLIT)

# Collision shapes in the base frame at the zero pose: boxes as two corners, cylinders as two end
# points and a radius [m]. Link 6 stops at x = 0.548, short of the tool on the flange.
Box = tuple[Point, Point]
Round = tuple[Point, Point, float]
COLLISION: tuple[tuple[Box | Round, ...], ...] = (
    (((-0.166, -0.108, 0), (0.108, 0.108, 0.05)), ((0, 0, 0.05), (0, 0, 0.211), 0.108)),
    (
        ((0, 0, 0.211), (0, 0, 0.300), 0.108),
        ((0.075, -0.110, 0.335), (0.075, 0.047, 0.335), 0.085),
    ),
    (
        ((0.075, 0.049, 0.335), (0.075, 0.172, 0.335), 0.087),
        ((0.015, 0.055, 0.335), (0.135, 0.140, 0.700)),
        ((0.075, 0.049, 0.700), (0.075, 0.145, 0.700), 0.075),
    ),
    (
        ((0.075, -0.090, 0.700), (0.075, 0.047, 0.700), 0.073),
        ((0.010, -0.075, 0.735), (0.293, 0.066, 0.843)),
    ),
    (
        ((0.293, -0.060, 0.740), (0.425, 0.066, 0.845)),
        ((0.425, 0.031, 0.745), (0.526, 0.078, 0.835)),
        ((0.425, -0.067, 0.745), (0.526, -0.031, 0.835)),
    ),
    (((0.440, -0.029, 0.752), (0.522, 0.029, 0.828)),),
    (((0.524, 0, 0.790), (0.548, 0, 0.790), 0.032),),
)

HEADER = """<mujoco model="kuka_kr5_sixx_r850">
  <!-- KUKA KR5 sixx R850. Written by `python -m sdh_sim.modelgen.arm`; README.md says where each
       number comes from. Contact bits: 1 object and table, 2 taxel, 4 hand structure, 8 arm. -->
  <compiler angle="radian" meshdir="assets" autolimits="true"/>
  <option integrator="Euler" timestep="0.002">
    <flag eulerdamp="disable"/>
  </option>

  <default>
    <default class="kr5">
      <geom condim="3" density="0"/>
      <default class="kr5_visual">
        <geom type="mesh" contype="0" conaffinity="0" group="2" material="kr5_orange"/>
      </default>
      <default class="kr5_collision">
        <geom contype="8" conaffinity="4" group="3" rgba="0.4 0.6 0.9 0.4"/>
      </default>
    </default>
  </default>
"""

MATERIALS = {
    "kr5_orange": '<material name="kr5_orange" rgba="1 0.4 0.05 1" specular="0.35" '
    'shininess="0.4"/>',
    "kr5_black": '<material name="kr5_black" rgba="0.09 0.09 0.1 1" specular="0.3" '
    'shininess="0.3"/>',
    "kr5_steel": '<material name="kr5_steel" rgba="0.55 0.56 0.58 1" specular="0.7" '
    'shininess="0.6"/>',
}


def link_origin(link: int) -> Array:
    """Origin of the base's (0) or a link's (1 to 6) frame in the base frame at zero [m]."""
    return np.zeros(3) if link == 0 else np.array(JOINTS[link - 1].point, dtype=float)


def arm_meshes() -> dict[str, trimesh.Trimesh]:
    """Drawn meshes by file stem, `base_black`, `link1_orange` and so on, in link frames [m]."""
    meshes = {}
    for link, parts in enumerate(link_solids()):
        for material, solids in parts.items():
            mesh = combine(*solids)
            mesh.apply_translation(-link_origin(link))
            meshes[f"{_link_name(link)}_{material.removeprefix('kr5_')}"] = mesh
    return meshes


def link_inertia(solids: list[trimesh.Trimesh], mass: float) -> tuple[Array, Array]:
    """Centre of mass (3,) [m] and inertia (3, 3) about it [kg m²] of solids of one density."""
    volumes = np.array([s.volume for s in solids])
    parts = [
        (m, *solid_inertia(s, m))
        for s, m in zip(solids, mass * volumes / volumes.sum(), strict=True)
    ]
    com = sum((m * c for m, c, _ in parts), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for m, c, own in parts:
        d = c - com
        inertia += own + m * (d @ d * np.eye(3) - np.outer(d, d))
    return com, inertia


def _link_name(link: int) -> str:
    return "base" if link == 0 else f"link{link}"


def _vec(values: npt.ArrayLike) -> str:
    numbers = np.atleast_1d(np.asarray(values, dtype=float))
    return " ".join(f"{round(float(v), 7) + 0.0:.9g}" for v in numbers)


def _collision(shape: Box | Round, origin: Array, name: str) -> str:
    a, b = np.array(shape[0]), np.array(shape[1])
    middle, half = (a + b) / 2 - origin, (b - a) / 2
    head = f'<geom class="kr5_collision" name="{name}" pos="{_vec(middle)}" '
    if len(shape) == 2:
        return head + f'type="box" size="{_vec(half)}"/>'
    length = float(np.linalg.norm(half))
    return (
        head + f'type="cylinder" zaxis="{_vec(half / length)}" size="{_vec([shape[2], length])}"/>'
    )


def _link_lines(link: int, parts: dict[str, list[trimesh.Trimesh]], pad: str) -> list[str]:
    """Everything of a link's body but its child and its closing tag."""
    name, origin = _link_name(link), link_origin(link)
    com, i = link_inertia([s for solids in parts.values() for s in solids], LINK_MASSES[link])
    full = [i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]
    if link == 0:
        lines = [f'{pad}<body name="base" childclass="kr5">']
    else:
        offset = _vec(origin - link_origin(link - 1))
        lines = [f'{pad}<body name="{name}" pos="{offset}" gravcomp="1">']
    lines.append(
        f'{pad}  <inertial pos="{_vec(com - origin)}" mass="{_vec(LINK_MASSES[link])}" '
        f'fullinertia="{_vec(full)}"/>'
    )
    if link:
        joint = JOINTS[link - 1]
        lines.append(
            f'{pad}  <joint name="joint{link}" axis="{_vec(joint.axis)}" '
            f'range="{_vec(np.radians(joint.limits))}" armature="{joint.armature:g}" '
            f'damping="{joint.damping:g}"/>'
        )
    lines += [
        f'{pad}  <geom class="kr5_visual" mesh="kr5_{name}_{m.removeprefix("kr5_")}" '
        f'material="{m}"/>'
        for m in parts
    ]
    return lines + [
        f"{pad}  {_collision(s, origin, f'kr5_{name}_{k}')}" for k, s in enumerate(COLLISION[link])
    ]


def arm_mjcf() -> str:
    """The arm's MJCF as text."""
    solids = link_solids()
    lines = [HEADER, "  <asset>", *(f"    {m}" for m in MATERIALS.values())]
    lines += [f'    <mesh name="kr5_{n}" file="{n}.obj"/>' for n in sorted(arm_meshes())]
    lines += ["  </asset>", "", "  <worldbody>"]
    for link, parts in enumerate(solids):
        lines += _link_lines(link, parts, "    " + "  " * link)
    inner = "    " + "  " * len(solids)
    # The site's z axis is the tool direction and its x axis points down at the zero pose.
    lines.append(
        f'{inner}<site name="flange" pos="{_vec(np.array(FLANGE) - link_origin(6))}" '
        'xyaxes="0 0 -1 0 1 0" size="0.003" group="5"/>'
    )
    lines += ["    " + "  " * k + "</body>" for k in reversed(range(len(solids)))]
    lines += ["  </worldbody>", "", "  <actuator>"]
    for k, joint in enumerate(JOINTS, start=1):
        lines.append(
            f'    <position name="joint{k}" joint="joint{k}" kp="{joint.stiffness:g}" '
            f'kv="{joint.servo_damping:g}" ctrlrange="{_vec(np.radians(joint.limits))}" '
            f'forcerange="{-joint.torque:g} {joint.torque:g}"/>'
        )
    speeds = _vec(np.radians([j.speed for j in JOINTS]))
    lines += [
        "  </actuator>",
        "",
        "  <custom>",
        f'    <numeric name="joint_speed_limit" size="6" data="{speeds}"/>',
        "  </custom>",
        "</mujoco>",
    ]
    return "\n".join(lines) + "\n"


def write_arm(folder: Path) -> None:
    """Write kr5_sixx_r850.xml and assets/ into a folder, creating it."""
    write_model(folder, {"kr5_sixx_r850.xml": arm_mjcf()}, arm_meshes())


if __name__ == "__main__":
    write_arm(Path(__file__).parents[2] / "models" / "kuka_kr5_sixx_r850")
