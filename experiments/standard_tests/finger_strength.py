"""Finger strength: the fingertip against a fixed load cell, its motors at their limits.

A force f along the cell's axis d at the point p loads motor j with f J_jᵀ d. The whole finger
presses with torques in these proportions, until the first motor is at its limit: f = min τ̄_j /
|J_jᵀ d|. One motor alone, the others locked, presses along the motion that it gives the
fingertip: f = τ̄_j / |J_j|, on the SDH-2 the limit over the distance of the joint's axis from p.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.standard_tests.album import Album
from experiments.standard_tests.contact_forces import contact_forces
from experiments.standard_tests.load_objects import CELL_TOP
from experiments.standard_tests.result_lines import Line
from experiments.standard_tests.specimen import Rig, Specimen
from sdh_sim.errors import Diverged
from sdh_sim.robot import Hand, hand_kinematics

BEFORE_END = 0.005  # the button's axis meets the finger so far before its end [m]
LEAST_LEVER = 0.05  # of the largest of a finger, with which a motor counts as pushing
PUSH_TIME, REST_TIME = 1.5, 1.0  # [s]
TOLERANCE = 0.05  # the finger yields by some degrees while the button keeps its place on it


@dataclass(frozen=True)
class Place:
    """Where a load cell meets a finger, in the palm frame.

    Attributes:
        point: on the finger's surface (3,) [m].
        axis: of the cell, against which the finger presses (3,).
        levers: J_jᵀ d of the finger's motors, 0 of others (n,) [m or 1].
    """

    point: np.ndarray
    axis: np.ndarray
    levers: np.ndarray

    @property
    def pushing(self) -> np.ndarray:
        """Motors of the finger that can push along the axis, by index."""
        sizes = np.abs(self.levers)
        return np.flatnonzero(sizes > LEAST_LEVER * max(float(sizes.max()), 1e-9))


def postures(hand: Hand) -> dict[str, np.ndarray]:
    """Motor positions of the tests: all at 0 (straight), and halfway through a closing (bent)."""
    spans = np.array([motor.span for motor in hand.motors])
    bent = next((c for n, c in hand.closings.items() if "cylindrical" in n), None)
    closing = bent or next(iter(hand.closings.values()))
    return {
        "straight": np.clip(np.zeros(len(spans)), *spans.T),
        "bent": closing.angles(1.0 if bent else 0.5),
    }


def find_place(rig: Rig, finger: int, angles: np.ndarray, motor: int | None = None) -> Place:
    """Bring the load cell of a rig to a fingertip, until it all but touches.

    Args:
        rig: with the load cell.
        finger: by index.
        angles: positions of the motors (n,) [rad or m].
        motor: along whose motion of the fingertip the cell stands; None: the last of the finger, so
            that it stands square to the last link.
    """
    hand = rig.scene.hand
    tip, posture = hand.fingers[finger], hand_kinematics(hand).at(angles)
    at, turn = posture.link(tip.tip)
    end = at + turn @ np.asarray(tip.tip_position)
    jacobian = posture.of_motors(posture.jacobian(tip.tip, end))
    senses = closing_senses(hand)
    moves = np.linalg.norm(jacobian, axis=0) > 1e-6
    last = [k for k in tip.stops if moves[k]][-1] if motor is None else motor
    axis = senses[last] * jacobian[:, last] / np.linalg.norm(jacobian[:, last])
    outward = (end - at) - ((end - at) @ axis) * axis
    end = end - BEFORE_END * outward / np.linalg.norm(outward)
    point = end + axis * meet(rig, finger, angles, end, axis)
    levers = posture.of_motors(posture.jacobian(tip.tip, point)).T @ axis
    own = np.zeros(len(levers), dtype=bool)
    own[list(tip.stops)] = True
    return Place(point, axis, np.where(own, levers, 0.0))


def closing_senses(hand: Hand) -> np.ndarray:
    """The sense in which each motor closes (n,)."""
    flexes = np.array([motor.flexes for motor in hand.motors])
    travel = next(iter(hand.closings.values())).travel
    return np.where(flexes == 0, np.where(travel < 0.0, -1, 1), flexes)


def axes_along(axis: np.ndarray) -> np.ndarray:
    """Axes (3, 3) of a load cell whose button looks against an axis, towards the finger."""
    third = -axis
    first = np.cross(np.eye(3)[np.argmin(np.abs(third))], third)
    first /= np.linalg.norm(first)
    return np.column_stack((first, np.cross(third, first), third))


def meet(rig: Rig, finger: int, angles: np.ndarray, end: np.ndarray, axis: np.ndarray) -> float:
    """How far from a point of a finger, along an axis, the end of the button leaves it [m]."""
    axes, model = axes_along(axis), rig.scene.model

    def touches(distance: float) -> bool:
        rig.put(angles, end + axis * (distance + CELL_TOP), axes)
        pairs = rig.simulation.data.contact.geom.reshape(-1, 2)
        ours = (model.geom_bodyid[pairs] == rig.scene.object_body).any(axis=1)
        return bool((rig.scene.geom_finger[pairs[ours]] == finger).any())

    steps = np.arange(-0.03, 0.06, 0.002)
    touching = np.array([touches(x) for x in steps])
    if not touching.any():
        return 0.0
    first = int(np.argmax(touching))
    beyond = np.flatnonzero(~touching[first:])
    low = float(steps[first + beyond[0] - 1]) if len(beyond) else float(steps[-1])
    high = low + 0.002
    for _ in range(9):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if touches(middle) else (low, middle)
    return high


def press(rig: Rig, angles: np.ndarray, place: Place, torques: np.ndarray) -> float:
    """Force on the load cell along its axis [N], with torques on some motors, the others holding.

    Args:
        rig: with the load cell.
        angles: positions of the motors to begin with, which the others keep (n,) [rad or m].
        place: of the load cell.
        torques: that the pushing motors are to give in the end, 0 for the others (n,) [N m or N].
    """
    scene, simulation = rig.scene, rig.simulation
    rig.put(angles, place.point + place.axis * CELL_TOP, axes_along(place.axis))
    gains = scene.model.actuator_gainprm[scene.motors, 0]
    friction = scene.drives.friction if len(scene.drives.friction) else np.zeros(len(angles))
    wanted = torques + np.sign(torques) * friction
    for share in np.linspace(0.0, 1.0, round(PUSH_TIME / simulation.tick_time)):
        now = scene.motor_positions(simulation.data)
        simulation.tick(hand=np.where(torques != 0.0, now + share * wanted / gains, angles))
    for _ in range(round(REST_TIME / simulation.tick_time)):
        now = scene.motor_positions(simulation.data)
        simulation.tick(hand=np.where(torques != 0.0, now + wanted / gains, angles))
    return float(contact_forces(scene, simulation.data).forces.sum(axis=0) @ place.axis)


def finger_strength(specimen: Specimen, cell: Path, album: Album) -> list[Line]:
    """Every finger straight and bent, as a whole and each motor alone, the others locked.

    Args:
        specimen: the hand.
        cell: folder of the load cell.
        album: takes a picture of the first finger in each posture.
    """
    whole, alone = specimen.rig(cell), specimen.rig(cell, drive="lock")
    lines = []
    hand, limits = specimen.hand, specimen.limits
    for name, angles in postures(hand).items():
        for finger, described in enumerate(hand.fingers):
            head = f"{described.name}, {name}"
            place = find_place(whole, finger, angles)
            pushing = place.pushing
            if not len(pushing):
                continue
            greatest = float(np.min(limits[pushing] / np.abs(place.levers[pushing])))
            lines.append(
                _line(specimen, f"{head}, whole finger", greatest, whole, angles, place,
                      greatest * place.levers)
            )  # fmt: skip
            if finger == 0:
                title = f"{specimen.name}:\n{head}"
                album.take("finger_strength", title, whole.scene, whole.simulation.data)
            for motor in pushing if len(pushing) > 1 else ():
                place = find_place(alone, finger, angles, int(motor))
                torques = np.zeros(len(limits))
                torques[motor] = np.sign(place.levers[motor]) * limits[motor]
                force = float(limits[motor] / abs(place.levers[motor]))
                what = f"{head}, {hand.motors[motor].name} alone"
                lines.append(_line(specimen, what, force, alone, angles, place, torques))
    return lines


def _line(
    specimen: Specimen, condition: str, closed: float, rig: Rig, angles: np.ndarray,
    place: Place, torques: np.ndarray,
) -> Line:  # fmt: skip
    try:
        force = press(rig, angles, place, torques)
    except Diverged:
        force = float("nan")
    return Line("finger_strength", specimen.name, condition, closed, force, TOLERANCE)
