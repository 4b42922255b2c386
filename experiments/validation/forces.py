"""Checks of forces against joint torques: τ = Σ Jᵀ f for one pad, two pads, two fingers."""

from __future__ import annotations

import numpy as np

from experiments.validation.friction import CLAMP_ANGLES, CLAMP_PUSH, clamp_rig
from experiments.validation.result_rows import Result, Row
from experiments.validation.rig_engine import MUJOCO, RigAtRest, RigEngine
from experiments.validation.rig_readings import torques_of
from experiments.validation.rigs import HONEST, Shape, Spoil, gripper, pad_frame
from experiments.validation.rigs import settings_for as rig_settings
from sdh_sim.robot import built_in_hand, hand_kinematics
from sdh_sim.robot import sdh2_constants as c

MOTOR_NAMES = built_in_hand().motor_names
PROXIMAL, DISTAL = MOTOR_NAMES.index("thumb_proximal"), MOTOR_NAMES.index("thumb_distal")
JOINTS = [PROXIMAL, DISTAL]
THUMB_PUSH = np.isin(np.arange(7), JOINTS)
BAR_RADIUS = 0.02  # [m]; its half length of 14 mm keeps it clear of the other fingers
BAR = Shape("cylinder", (BAR_RADIUS, 0.014), (BAR_RADIUS + 3e-4, 0.0, 0.0), (0.0, 1.0, 0.0))
RESIDUAL = 2e-3  # of a torque limit: solver tolerance and the last motion that is left

# proximal and distal angle [°], row pressed on, wanted normal force [N], wanted tangential share
PRESSES = (
    (0.0, 0.0, 8.0, 10.0, 0.1),
    (0.0, 0.0, 4.0, 8.0, 0.2),
    (-30.0, 30.0, 9.0, 12.0, 0.0),
    (20.0, 25.0, 7.0, 10.0, 0.1),
    (-45.0, 60.0, 6.0, 6.0, -0.1),
    (10.0, -20.0, 5.0, 7.0, 0.2),
)


def single_finger(short: bool = False, spoil: Spoil = HONEST, engine: RigEngine = MUJOCO) -> Result:
    """Both motors of the thumb at their limits, one pad on a fixed bar: f = J⁻ᵀ τ̄.

    The limits are chosen so that the wanted force balances them at the wanted place; the
    prediction then uses the limits and the centre of pressure of the tactile array, as the metric
    does.
    """
    rows, poses = [], []
    worst = 0.0
    for proximal, distal, row, force, share in PRESSES[:2] if short else PRESSES:
        angles = np.zeros(7)
        angles[JOINTS] = np.radians((proximal, distal))
        place = pad_frame("thumb_distal", row, 2.5, angles)
        pull = force * (place.rotation[:, 0] + share * place.rotation[:, 2])
        open_hand = hand_kinematics().at(angles)
        wanted = (open_hand.jacobian("thumb_distal", place.position).T @ pull)[JOINTS]
        limit = (float(wanted[0]), float(wanted[1]))
        scene = gripper(place, [BAR], False, rig_settings(torque_limit=limit), 0.8, spoil)
        rest = engine.squeezed(scene, angles, THUMB_PUSH)
        touch, mark = rest.touches(), rest.imprint("thumb_distal")
        # The force that the limits allow at the centre of pressure, in the finger's plane.
        hand = hand_kinematics().at(rest.angles)
        at, turn = hand.link("thumb_distal")
        normal = turn @ mark.normal
        along = np.cross(normal, turn @ [0.0, 1.0, 0.0])
        plane = np.column_stack([normal, along])
        jacobian = hand.jacobian("thumb_distal", at + turn @ mark.point)[:, JOINTS]
        predicted = plane @ np.linalg.solve(jacobian.T @ plane, wanted)
        total = touch.forces.sum(axis=0)
        rows.append(Row(
            f"force at {proximal:.0f}°, {distal:.0f}°; {limit[0]:.2f}, {limit[1]:.2f} N m", "N",
            float(predicted @ normal), float(total @ normal), 0.03,
            "centre of pressure to a quarter of a pitch (0.85 mm) on a lever of 28 mm or more",
        ))  # fmt: skip
        held = torques_of(scene, rest.angles, touch)[JOINTS]
        worst = max(worst, float(np.abs(held / wanted - 1.0).max()))
        pressed_at = at + turn @ mark.point
        joints = [hand.link(f"thumb_{kind}")[0][[0, 2]] for kind in ("proximal", "distal")]
        tip = (at + turn @ [0.0, 0.0, c.DISTAL_LENGTH])[[0, 2]]
        bar = (place.position + place.rotation @ BAR.pos)[[0, 2]]
        poses.append(
            (np.array([*joints, tip]), bar, pressed_at[[0, 2]], predicted[[0, 2]], total[[0, 2]])
        )
    rows.append(_residual("Σ Jᵀf over contact points less τ̄, worst joint and pose", worst))
    return Result(tuple(rows), {"poses": poses})


def _residual(quantity: str, value: float) -> Row:
    reason = "statics are exact; solver tolerance and what motion is left"
    return Row(quantity, "of τ̄", 0.0, value, RESIDUAL, reason, scale=1.0)


def two_pads(short: bool = False, spoil: Spoil = HONEST, engine: RigEngine = MUJOCO) -> Result:
    """A straight thumb on two fixed bars, one under each pad: both forces from both limits.

    Without friction the two normal forces follow from the limits alone; with friction the sum
    of Jᵀ f over both pads is checked.
    """
    rows, points = [], []
    worst = 0.0
    place = pad_frame("thumb_proximal", 6.5, 2.5)
    other = pad_frame("thumb_distal", 9.0, 2.5).position - place.position
    far = place.rotation.T @ other
    bars = [BAR, Shape(BAR.kind, BAR.size, tuple(BAR.pos + far), BAR.axis)]
    lever = c.PROXIMAL_PROFILE[0][1] * 1e-3 - 6.5 * c.TAXEL_PITCH
    far_lever = c.DISTAL_PROFILE[9][1] * 1e-3
    for near_force, far_force in ((8.0, 6.0),) if short else ((8.0, 6.0), (15.0, 4.0), (6.0, 10.0)):
        limit = (
            near_force * lever + far_force * (c.PROXIMAL_LENGTH + far_lever), far_force * far_lever,
        )  # fmt: skip
        scene = gripper(place, bars, False, rig_settings(torque_limit=limit), 0.0, spoil)
        rest = engine.squeezed(scene, np.zeros(7), THUMB_PUSH)
        marks = [rest.imprint(f"thumb_{kind}") for kind in ("proximal", "distal")]
        columns = []
        hand = hand_kinematics().at(rest.angles)
        for mark, kind in zip(marks, ("proximal", "distal"), strict=True):
            at, turn = hand.link(f"thumb_{kind}")
            jacobian = hand.jacobian(f"thumb_{kind}", at + turn @ mark.point)[:, JOINTS]
            columns.append(jacobian.T @ (turn @ mark.normal))
        predicted = np.linalg.solve(np.column_stack(columns), limit)
        for kind, mark, value in zip(("proximal", "distal"), marks, predicted, strict=True):
            rows.append(Row(
                f"{kind} pad, no friction; {limit[0]:.2f}, {limit[1]:.2f} N m", "N", float(value),
                mark.total, 0.03,
                "as for one pad; taxel normals on a bar spread by ±9°, 1 % of their sum",
            ))  # fmt: skip
            points.append((float(value), mark.total))
        scene = gripper(place, bars, False, rig_settings(torque_limit=limit), 0.63, spoil)
        rest = engine.squeezed(scene, np.zeros(7), THUMB_PUSH)
        share = torques_of(scene, rest.angles, rest.touches())[JOINTS] / limit
        worst = max(worst, float(np.abs(share - 1.0).max()))
    rows.append(_residual("Σ Jᵀf over both pads less τ̄, μ 0.63, worst joint", worst))
    return Result(tuple(rows), {"points": np.array(points)})


def from_limits(rest: RigAtRest, torque: float) -> tuple[float, float]:
    """What two opposing fingers press with by their proximal limits, and what their taxels say.

    Args:
        rest: a clamped box.
        torque: limit of the proximal motors [N m].

    Returns:
        Sum of τ̄ over the lever of each pad's centre of pressure, sum of all taxels [N].
    """
    predicted = total = 0.0
    for finger in ("finger1", "finger2"):
        mark = rest.imprint(f"{finger}_distal")
        hand = hand_kinematics().at(rest.angles)
        at, turn = hand.link(f"{finger}_distal")
        joint = MOTOR_NAMES.index(f"{finger}_proximal")
        jacobian = hand.jacobian(f"{finger}_distal", at + turn @ mark.point)
        predicted += torque / abs(float(jacobian[1, joint]))  # the box's faces look along y
        total += mark.total
    return predicted, total


def tactile_total(short: bool = False, spoil: Spoil = HONEST, engine: RigEngine = MUJOCO) -> Result:
    """Sum of all taxels of two opposing fingers against their proximal motors' limits.

    By symmetry the pads carry no force along the fingers, so each sums to τ̄ over the lever of
    its centre of pressure.
    """
    rows, points = [], []
    for torque in (1.6401,) if short else (0.5, 1.0, 1.6401, 2.1):
        rest = engine.squeezed(clamp_rig((torque, 1.0934), spoil), CLAMP_ANGLES, CLAMP_PUSH)
        predicted, total = from_limits(rest, torque)
        rows.append(Row(
            f"sum of all taxels of two fingers, motors at {torque:.2f} N m", "N", predicted, total,
            0.01, "flat pads on flat faces: centre of pressure to 1 mm on a lever of 113 mm",
        ))  # fmt: skip
        points.append((torque, predicted, total))
    return Result(tuple(rows), {"points": np.array(points)})
