"""Whether a user's hand can do what its ``hand.toml`` says: pads, closings, mechanism."""

from __future__ import annotations

from itertools import combinations

import mujoco
import numpy as np

from sdh_sim.errors import HandError
from sdh_sim.robot.hand import HandKinematics, HandPosture, taxel_names
from sdh_sim.robot.hand_description import Hand
from sdh_sim.robot.pads import Pad

OFF_BODY = 0.01  # that a pad's middle may lie off the shapes of its link [m]
NOT_CLOSER = 1e-3  # by which pads or fingers at least approach each other in a closing [m]
PAST_STOP = 0.02  # that a joint may be beyond its range, as stops give way [rad or m]
_STEPS = 8  # of the closing ratio


def exclude_overlaps(spec: mujoco.MjSpec, hand: Hand) -> list[str]:
    """Let parts pass through each other that touch in the model's own reference posture.

    Hulls of neighbouring parts of a linkage often do; their contacts would jam it.

    Args:
        spec: changed in place.
        hand: whose model it is.

    Returns:
        a note that names them, where there are some.
    """
    model = spec.copy().compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_collision(model, data)
    pairs = set()
    for contact in data.contact[: data.ncon]:
        bodies = [model.body(int(model.geom_bodyid[g])).name for g in contact.geom]
        pairs.add(tuple(sorted(bodies)))
    for first, second in sorted(pairs):
        spec.add_exclude(bodyname1=first, bodyname2=second)
    named = ", ".join(f"{a} and {b}" for a, b in sorted(pairs))
    return [f"overlap, so that no contacts are between them: {named}"] if pairs else []


def check_hand(hand: Hand) -> None:
    """Raise HandError where the hand cannot do what ``hand.toml`` says.

    Raises:
        HandError: a mechanism that cannot be used, a pad off its body, a closing that does not
            close.
    """
    kinematics = HandKinematics(hand)
    _check_pads(hand)
    for name in hand.closings:
        _check_stops(kinematics, name)
        gaps = pad_gaps(kinematics, name)
        if gaps[0] - gaps.min() < NOT_CLOSER:
            raise HandError(
                f"closings.{name} does not close: its pads are {1e3 * gaps[0]:.1f} mm apart open "
                f"and {1e3 * gaps[-1]:.1f} mm closed; give a travel that brings them together"
            )


def _check_stops(kinematics: HandKinematics, closing: str) -> None:
    """Raise HandError where equalities put a joint beyond its own stops in a closing."""
    model, line = kinematics.model, kinematics.hand.closing(closing)
    low, high = model.jnt_range.T
    for ratio in (0.0, 1.0):
        joints = kinematics.joint_positions(line.angles(ratio))
        beyond = (joints < low - PAST_STOP) | (joints > high + PAST_STOP)
        for k in np.flatnonzero(beyond & (model.jnt_limited > 0)):
            raise HandError(
                f"closings.{closing}: at ratio {ratio:g} the joint {model.joint(int(k)).name} is "
                f"at {joints[k]:.4g}, beyond its range of {low[k]:.4g} to {high[k]:.4g}; its "
                "equalities would work against its stop: change the range or the equalities"
            )


def pad_gaps(kinematics: HandKinematics, closing: str, steps: int = _STEPS) -> np.ndarray:
    """Mean distance between the middles of pads of different fingers along a closing [m].

    Args:
        kinematics: of the hand.
        closing: name of one of its closings.
        steps: of the closing ratio from 0 to 1.

    Returns:
        (steps + 1,); where fewer than two fingers have pads, of the fingertips.
    """
    hand = kinematics.hand
    line = hand.closing(closing)
    gaps = []
    for ratio in np.linspace(0.0, 1.0, steps + 1):
        posture = kinematics.at(line.angles(float(ratio)))
        marks = [(finger, pad_place(posture, pad)[0]) for finger, pad in pads_by_finger(kinematics)]
        if len({finger for finger, _ in marks}) < 2:
            marks = []
            for k, finger in enumerate(hand.fingers):
                origin, turn = posture.link(finger.tip)
                marks.append((k, origin + turn @ np.array(finger.tip_position)))
        apart = [
            float(np.linalg.norm(a - b)) for (i, a), (j, b) in combinations(marks, 2) if i != j
        ]
        gaps.append(float(np.mean(apart)) if apart else 0.0)
    return np.array(gaps)


def pad_place(posture: HandPosture, pad: Pad) -> tuple[np.ndarray, np.ndarray]:
    """Middle of a pad (3,) [m] and its normal (3,), in the palm frame."""
    rows, columns = pad.array.shape
    point, normal = pad.array.surface(0.5 * (rows - 1), 0.5 * (columns - 1))
    origin, turn = posture.link(pad.body)
    return origin + turn @ point, turn @ normal


def pads_by_finger(kinematics: HandKinematics) -> list[tuple[int, Pad]]:
    """The pads, each with the index of the finger that it is on, -1 for the palm."""
    model, hand = kinematics.model, kinematics.hand
    roots = {model.body(b).id: k for k, finger in enumerate(hand.fingers) for b in finger.bodies}
    found = []
    for pad in hand.pads:
        body = model.body(pad.body).id
        while body and body not in roots:
            body = int(model.body_parentid[body])
        found.append((roots.get(body, -1), pad))
    return found


def _check_pads(hand: Hand) -> None:
    """Raise HandError where the middle of a pad is away from all shapes of its link."""
    if hand.made is None:
        return
    model = hand.made.copy().compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    segment = np.zeros(6)
    every = [{model.geom(n).id for n in names if n} for names in taxel_names(hand)]
    weld = model.body_weldid[model.geom_bodyid]  # what is fixed to a link is part of it
    for pad, taxels in zip(hand.pads, every, strict=True):
        link = model.body(pad.frame.body if pad.frame else pad.body).id
        part = set(np.flatnonzero(weld == model.body_weldid[link]).tolist())
        solid = part.difference(*every)
        nearest = [
            mujoco.mj_geomDistance(model, data, taxel, geom, 1.0, segment)
            for taxel in taxels
            for geom in solid
        ]
        if not taxels:
            raise HandError(f"pads.{pad.name} has no live taxel; take some out of missing")
        if not nearest or min(nearest) > OFF_BODY:
            how = f"{1e3 * min(nearest):.0f} mm off its shapes" if nearest else "which has no shape"
            raise HandError(
                f"pads.{pad.name} is not on its body {model.body(link).name}, {how}; check its pos "
                "and quat, or the array's profile"
            )
