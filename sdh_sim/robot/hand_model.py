"""The model of a user's hand in the form that those of built-in hands have.

Geoms get the contact bits of the workcell, motors become position servos, frames of palm and pads
become fixed bodies, and pads without taxels get them.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import mujoco
import numpy as np

from sdh_sim.errors import HandError
from sdh_sim.robot.hand_description import Hand
from sdh_sim.robot.pads import Frame, Pad, TaxelArray

STRUCTURE = {"contype": 4, "conaffinity": 12, "condim": 3, "group": 3, "priority": 0}
TAXEL = {"contype": 2, "conaffinity": 0, "condim": 3, "group": 4, "priority": 2}
VISUAL = {"contype": 0, "conaffinity": 0, "group": 2}
"""Contact bits and groups: 1 object and table, 2 taxel, 4 hand structure, 8 arm.

Where two geoms meet, the one of higher priority says how: taxels before the table, which stands
before all others.
"""

COUPLING_SOLREF, COUPLING_SOLIMP = (0.005, 1.0), (0.9999, 0.9999, 0.001, 0.5, 2.0)
LEAST_RADIUS, MOST_RADIUS = 2.0, 4.0  # of a taxel's sphere, in pitches


def name_parts(spec: mujoco.MjSpec) -> None:
    """Give bodies and joints without a name one, since the workcell finds them by name.

    Raises:
        HandError: a joint that neither turns nor slides, or shapes that belong to no body.
    """
    if len(spec.worldbody.geoms):
        raise HandError("the model has a geom in no body; put it into the hand's first body")
    for kind, parts in (("body", spec.bodies[1:]), ("joint", spec.joints)):
        for number, part in enumerate(parts):
            part.name = part.name or f"unnamed_{kind}_{number}"
    turns = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
    for joint in spec.joints:
        if joint.type not in turns:
            raise HandError(
                f"the joint {joint.name} is neither hinge nor slide; a hand's joints turn or slide"
            )


def make_servos(spec: mujoco.MjSpec) -> None:
    """Turn every actuator into a position servo whose reference is a position of its motor.

    Raises:
        HandError: one that is no servo with a linear law, or pulls at neither joint nor tendon.
    """
    moves = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_TENDON)
    for motor in spec.actuators:
        fixed = motor.gaintype == mujoco.mjtGain.mjGAIN_FIXED
        affine = motor.biastype == mujoco.mjtBias.mjBIAS_AFFINE
        still = motor.dyntype == mujoco.mjtDyn.mjDYN_NONE
        gain, stiffness = float(motor.gainprm[0]), -float(motor.biasprm[1])
        if not (fixed and affine and still and gain > 0.0 and stiffness > 0.0):
            raise HandError(
                f"the actuator {motor.name} is no position servo; write it as <position> with kp "
                "above 0"
            )
        if motor.trntype not in moves:
            raise HandError(f"the actuator {motor.name} drives neither a joint nor a fixed tendon")
        ends = (gain * np.array(motor.ctrlrange) + float(motor.biasprm[0])) / stiffness
        if motor.gear[0] == 0.0:
            raise HandError(f"the actuator {motor.name} has gear 0; give the ratio of its gear")
        motor.ctrlrange = ends
        motor.gainprm[0], motor.biasprm[0] = stiffness, 0.0


def spans_of(model: mujoco.MjModel) -> dict[str, tuple[float, float]]:
    """Ranges of the actuators of a compiled model that have one, by name [rad or m]."""
    spans = {}
    for k in range(model.nu):
        low, high = model.actuator_ctrlrange[k] if model.actuator_ctrllimited[k] else (0.0, 0.0)
        target, gear = model.actuator_trnid[k, 0], model.actuator_gear[k, 0]
        if model.actuator_trntype[k] == mujoco.mjtTrn.mjTRN_JOINT:
            limited, ends = model.jnt_limited[target], model.jnt_range[target]
        else:
            limited, ends = model.tendon_limited[target], model.tendon_range[target]
        if limited:
            low, high = max(low, *[min(ends * gear)]), min(high, *[max(ends * gear)])
        if low < high:
            spans[model.actuator(k).name] = (float(low), float(high))
    return spans


def complete(spec: mujoco.MjSpec, hand: Hand) -> list[str]:
    """Give a model what ``hand.toml`` adds to it: roles of geoms, frames, taxels.

    Args:
        spec: changed in place.
        hand: as ``hand.toml`` describes it.

    Returns:
        what was done, for the user.

    Raises:
        HandError: a body or geom that the model lacks, a name that it has already, some taxels.
    """
    notes = []
    idle = [motor for motor in spec.actuators if motor.name not in hand.motor_names]
    if idle:
        notes.append(f"left out, as no motors of hand.toml: {', '.join(m.name for m in idle)}")
    for motor in idle:
        spec.delete(motor)
    _set_dynamics(spec, hand)
    _add_couplings(spec, hand)
    for body in spec.bodies:
        colliding = [geom for geom in body.geoms if geom.contype or geom.conaffinity]
        bare = len(colliding) == len(body.geoms)  # nothing else would be drawn of it
        for geom in body.geoms:
            _set_role(geom, STRUCTURE if geom in colliding else VISUAL)
            geom.group = VISUAL["group"] if bare else geom.group
    if hand.palm_frame is not None:
        _add_frame(spec, "palm", hand.palm, hand.palm_frame)
    for pad in hand.pads:
        notes += _complete_pad(spec, pad)
    for what, body in _bodies(hand):
        if spec.body(body) is None:
            raise HandError(f"{what} is {body!r}; the model has the bodies {_names(spec.bodies)}")
    return notes


def taxel_name(pad: Pad, row: int, column: int) -> str:
    """Name of the geom that is a taxel, in the model of the hand."""
    return f"{pad.name}_r{row:02d}_c{column}"


def taxel_radius(array: TaxelArray, row: int, column: int) -> float:
    """Radius [m] of the sphere that stands for one taxel's rubber, of a pad without a model.

    Neighbouring spheres overlap deeply, so that no edge of an object catches between them; toward
    the pad's edges they are smaller, so that they stand out of the finger as little as may be.
    """
    rows, columns = array.shape
    inside = min(row, rows - 1 - row, column, columns - 1 - column)
    return array.pitch * min(LEAST_RADIUS + inside, MOST_RADIUS)


def _set_dynamics(spec: mujoco.MjSpec, hand: Hand) -> None:
    """Gains of servos, damping and armature of joints, where ``hand.toml`` gives them."""
    for motor in hand.motors:
        servo = spec.actuator(motor.name)
        if motor.kp is not None:
            servo.gainprm[0], servo.biasprm[1] = motor.kp, -motor.kp
        if motor.kv is not None:
            servo.biasprm[2] = -motor.kv
    for name, dynamics in hand.joints.items():
        joint = spec.joint(name)
        if joint is None:
            raise HandError(f"joints.{name}: the model has the joints {_names(spec.joints)}")
        if dynamics.damping is not None:
            # Of releases with a polynomial of the speed, its constant.
            constant = [dynamics.damping, 0.0, 0.0]
            joint.damping = constant if np.ndim(joint.damping) else dynamics.damping
        if dynamics.armature is not None:
            joint.armature = dynamics.armature
        if dynamics.frictionloss is not None:
            joint.frictionloss = dynamics.frictionloss


def _add_couplings(spec: mujoco.MjSpec, hand: Hand) -> None:
    """Equalities of ``hand.toml``, stiff enough to move by micrometres under a grip."""
    for coupling in hand.couplings:
        for name in (coupling.joint, coupling.leader):
            if spec.joint(name) is None or coupling.joint == coupling.leader:
                raise HandError(
                    f"couplings.{coupling.joint}: {name} is not the name of another joint; the "
                    f"model has {_names(spec.joints)}"
                )
        tie = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT)
        tie.objtype = mujoco.mjtObj.mjOBJ_JOINT
        tie.name1, tie.name2 = coupling.joint, coupling.leader
        tie.data[:5] = (0.0, coupling.ratio, 0.0, 0.0, 0.0)
        tie.solref, tie.solimp = COUPLING_SOLREF, COUPLING_SOLIMP


def _complete_pad(spec: mujoco.MjSpec, pad: Pad) -> list[str]:
    if pad.frame is not None:
        _add_frame(spec, f"pads.{pad.name}.body", pad.body, pad.frame)
    body = spec.body(pad.body)
    if body is None:
        raise HandError(
            f"pads.{pad.name}.body is {pad.body!r}; the model has the bodies {_names(spec.bodies)}"
        )
    for name in pad.replaces:
        geom = spec.geom(name)
        if geom is None:
            raise HandError(
                f"pads.{pad.name}.replaces has {name!r}; the model has the geoms "
                f"{_names(spec.geoms)}"
            )
        _set_role(geom, VISUAL)
    taxels = {
        taxel_name(pad, *map(int, at)): at for at in zip(*np.nonzero(pad.array.live), strict=True)
    }
    known = {geom.name: geom for geom in spec.geoms if geom.name in taxels}
    if known and len(known) < len(taxels):
        missing = next(name for name in taxels if name not in known)
        raise HandError(
            f"pads.{pad.name}: the model has {len(known)} of its {len(taxels)} taxels; "
            f"{missing} is missing; name all of them or none"
        )
    for geom in known.values():
        if geom.parent.name != pad.body:
            raise HandError(
                f"pads.{pad.name}: the taxel {geom.name} is in the body {geom.parent.name}, "
                f"expected {pad.body}"
            )
        _set_role(geom, TAXEL)
        geom.mass = geom.density = 0.0
    if known:
        return []
    for name, (row, column) in taxels.items():
        point, normal = pad.array.surface(row, column)
        radius = taxel_radius(pad.array, int(row), int(column))
        geom = body.add_geom(name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE)
        geom.pos, geom.size[0] = point - radius * normal, radius
        geom.rgba = (0.9, 0.5, 0.1, 0.3)
        _set_role(geom, TAXEL)
        geom.mass = geom.density = 0.0
    return [f"pads.{pad.name}: {len(taxels)} taxels made"]


def _set_role(geom: mujoco.MjsGeom, role: dict[str, int]) -> None:
    for name, value in role.items():
        setattr(geom, name, value)


def _add_frame(spec: mujoco.MjSpec, key: str, name: str, frame: Frame) -> None:
    """A fixed body without mass that is the frame."""
    body = spec.body(frame.body)
    if body is None:
        raise HandError(f"{key} is {frame.body!r}; the model has the bodies {_names(spec.bodies)}")
    if spec.body(name) is not None:
        raise HandError(f"{key}: the model has a body {name} already; rename it")
    body.add_body(name=name, pos=frame.pos, quat=frame.quat)


def _bodies(hand: Hand) -> list[tuple[str, str]]:
    """Bodies that ``hand.toml`` names, with the keys that do."""
    found = [("palm", hand.palm)]
    for finger in hand.fingers:
        found += [(f"fingers.{finger.name}.bodies", body) for body in finger.bodies]
        found.append((f"fingers.{finger.name}.tip", finger.tip))
    return found


def _names(parts: Iterable[Any]) -> str:
    names = [part.name for part in parts if part.name and part.name != "world"]
    shown = ", ".join(names[:20]) or "none with a name"
    return shown + (f" and {len(names) - 20} more" if len(names) > 20 else "")
