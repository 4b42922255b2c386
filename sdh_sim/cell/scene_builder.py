"""Build a scene: table, arm, hand and object joined by MjSpec, the pads made rubber."""

from __future__ import annotations

from functools import lru_cache

import mujoco
import numpy as np

from sdh_sim.cell.drives import drives_in, give_drives
from sdh_sim.cell.scene import ARM_GEOM, HAND_GEOM, OBJECT_GEOM, TABLE_GEOM, Scene
from sdh_sim.objects import HARD_SOLREF, OBJECT, ObjectInfo, object_info, object_spec
from sdh_sim.robot import (
    ARM,
    ARM_JOINTS,
    HAND,
    Hand,
    built_in_hand,
    hand_in,
    hand_kinematics,
    hand_spec,
    taxel_names,
)
from sdh_sim.robot.carrier import carrier_spec, palm_motion_of
from sdh_sim.settings import TrialSettings

# Impedance d of the pad contacts, constant, and damping ratio of one taxel's contact: with these
# a held object creeps by micrometres per second.
PAD_IMPEDANCE = 0.95
PAD_DAMPING_RATIO = 1.0
# A fixture that gives way by less than 1 µm to what the fingers press with.
FIXTURE = "fixture"
FIXTURE_SOLREF, FIXTURE_SOLIMP = (0.005, 1.0), (0.9999, 0.9999, 0.001, 0.5, 2.0)
NOT_DRAWN = 5  # group of geoms that no picture shows
RIGID = 100.0  # factor on the arm's stiffness where it is to be rigid


def robot_spec(arm: str = "servo", hand: Hand | None = None) -> mujoco.MjSpec:
    """Table, arm (of one of the settings' kinds) and hand (None: the SDH-2), without an object."""
    spec = carrier_spec(arm)
    spec.attach(hand_spec(hand or built_in_hand()), prefix=HAND, site=spec.site(f"{ARM}flange"))
    for body in spec.bodies:
        if body.name.startswith((ARM, HAND)):
            body.gravcomp = 1.0  # the arm's controller knows the weight it carries
    return spec


def build_scene(settings: TrialSettings) -> Scene:
    """Compile the workcell for one object and one set of conditions.

    Raises:
        SettingsError: no such object.
    """
    hand = hand_in(settings)
    hand.check(settings.torque_limit, settings.pads)
    spec = robot_spec(settings.arm, hand)
    obj = object_info(settings.object, settings.folder)
    shape = object_spec(settings.object, settings.folder)
    spec.attach(shape, prefix=OBJECT, frame=spec.worldbody.add_frame())
    spec.body(f"{OBJECT}object").add_freejoint(name="free")
    spec.option.timestep = settings.timestep
    limits = hand.torque_limits(settings.torque_limit or hand.rated_limits)
    names = [HAND + name for name in hand.motor_names]
    give_drives(spec, names, limits, settings.drive, settings.gear_friction)
    if settings.arm == "rigid":
        _stiffen(spec)
    if settings.support == "none":
        _take_table_away(spec)
    return _index(spec.compile(), settings, obj, hand)


@lru_cache(maxsize=8)
def scene_of(settings: TrialSettings) -> Scene:
    """The scene of these settings, built once per process; arguments as ``build_scene``."""
    return build_scene(settings)


def _stiffen(spec: mujoco.MjSpec) -> None:
    """Make the arm's servos RIGID times as stiff, without a force limit.

    Inertia and damping grow with the stiffness: the arm then follows its references as before,
    but nothing that the hand meets can move it.
    """
    for name in ARM_JOINTS:
        joint, motor = spec.joint(ARM + name), spec.actuator(ARM + name)
        joint.armature *= RIGID
        motor.gainprm[0] *= RIGID
        motor.biasprm[1] *= RIGID
        motor.biasprm[2] *= RIGID
        motor.forcelimited = mujoco.mjtLimited.mjLIMITED_FALSE


def _take_table_away(spec: mujoco.MjSpec) -> None:
    """No table and no gravity: a fixture holds the object, until it is released.

    The trial puts the object's weight on as a force, in any direction. The hand's own weight is
    borne by what carries it in every scene.
    """
    spec.option.gravity = np.zeros(3)
    for name in ("table", "table_frame"):
        geom = spec.geom(name)
        geom.contype = geom.conaffinity = 0
        geom.group = NOT_DRAWN
    fixture = spec.add_equality(name=FIXTURE, type=mujoco.mjtEq.mjEQ_WELD)
    fixture.objtype = mujoco.mjtObj.mjOBJ_BODY
    fixture.name1, fixture.name2 = "world", f"{OBJECT}object"
    fixture.solref, fixture.solimp = FIXTURE_SOLREF, FIXTURE_SOLIMP
    fixture.active = True


def _index(model: mujoco.MjModel, settings: TrialSettings, obj: ObjectInfo, hand: Hand) -> Scene:
    motors = [model.actuator(HAND + name).id for name in hand.motor_names]
    alone = hand_kinematics(hand).model
    hand_joints = [model.joint(HAND + alone.joint(k).name) for k in range(alone.njnt)]
    arm_joints = [model.joint(ARM + name) for name in ARM_JOINTS]
    body = model.body(f"{OBJECT}object").id
    free = model.joint(int(model.body_jntadr[body]))
    limits = hand.torque_limits(settings.torque_limit or hand.rated_limits)
    scene = Scene(
        model=model,
        settings=settings,
        obj=obj,
        hand=hand,
        palm_motion=palm_motion_of(settings.arm, hand),
        motors=np.array(motors),
        motor_qpos=_addresses(model, motors, model.jnt_qposadr),
        motor_dof=_addresses(model, motors, model.jnt_dofadr),
        hand_qpos=np.array([j.qposadr[0] for j in hand_joints]),
        joint_positions=hand_kinematics(hand).joint_positions,
        arm_motors=np.array([model.actuator(ARM + name).id for name in ARM_JOINTS]),
        arm_qpos=np.array([j.qposadr[0] for j in arm_joints]),
        arm_dof=np.array([j.dofadr[0] for j in arm_joints]),
        arm_speed_limit=palm_motion_of(settings.arm, hand).speed_limit,
        palm=model.body(HAND + hand.palm).id,
        object_body=body,
        object_qpos=int(free.qposadr[0]),
        object_dof=int(free.dofadr[0]),
        table=model.geom("table").id,
        fixture=model.equality(FIXTURE).id if settings.support == "none" else -1,
        taxel=taxel_index(model, hand),
        geom_group=geom_groups(model),
        geom_finger=geom_fingers(model, hand),
        drives=drives_in(model, np.array(motors), limits, settings.drive, settings.gear_friction),
    )
    set_contacts(scene)
    return scene


def _addresses(model: mujoco.MjModel, motors: list[int], of_joint: np.ndarray) -> np.ndarray:
    """Addresses of the joints that motors drive directly, -1 for other motors (n,)."""
    return np.array(
        [
            of_joint[model.actuator_trnid[k, 0]]
            if model.actuator_trntype[k] == mujoco.mjtTrn.mjTRN_JOINT
            and model.actuator_gear[k, 0] == 1.0
            else -1
            for k in motors
        ]
    )


def taxel_index(model: mujoco.MjModel, hand: Hand) -> np.ndarray:
    """Per geom, index into the flat tactile vector, -1 where it is no taxel (ngeom,)."""
    index = np.full(model.ngeom, -1, dtype=np.int64)
    for offset, names in zip(hand.pad_offsets[:-1], taxel_names(hand), strict=True):
        for place, name in enumerate(names):
            if name:
                index[model.geom(HAND + name).id] = offset + place
    return index


def geom_groups(model: mujoco.MjModel) -> np.ndarray:
    """Per geom, the group that it belongs to (ngeom,)."""
    groups = np.zeros(model.ngeom, dtype=np.int64)
    for geom in range(model.ngeom):
        body = model.body(int(model.geom_bodyid[geom])).name
        for prefix, group in ((OBJECT, OBJECT_GEOM), (HAND, HAND_GEOM), (ARM, ARM_GEOM)):
            if body.startswith(prefix):
                groups[geom] = group
    groups[model.geom("table").id] = TABLE_GEOM
    return groups


def geom_fingers(model: mujoco.MjModel, hand: Hand) -> np.ndarray:
    """Per geom, index of the finger it is part of, -1 where of none (ngeom,)."""
    of_body = np.full(model.nbody, -1, dtype=np.int64)
    roots = {
        model.body(HAND + body).id: index
        for index, finger in enumerate(hand.fingers)
        for body in finger.bodies
    }
    for body in range(1, model.nbody):  # parents come before what hangs on them
        of_body[body] = roots.get(body, of_body[model.body_parentid[body]])
    return of_body[model.geom_bodyid]


def taxel_stiffness(settings: TrialSettings, pitch: float) -> float:
    """Normal stiffness of one taxel's rubber [N/m]: E pitch² / thickness (elastic foundation)."""
    return settings.pad_modulus * pitch**2 / settings.pad_thickness


def set_contacts(scene: Scene) -> None:
    """Give each taxel its stiffness against this object, and every contact the object's friction.

    A MuJoCo contact with ``solref = (-k, -b)`` and constant impedance d, penetrated by r, carries
    r k / ((1 - d) A) at rest, where A is the sum of the two bodies' ``invweight0`` (the diagonal
    of the constraint's inverse inertia as the compiler estimates it). So k = K (1 - d) A carries
    K r exactly. A depends on the object's mass, hence one scene per object.
    """
    model, d = scene.model, PAD_IMPEDANCE
    friction = scene.obj.friction
    pitches = [pad.array.pitch for pad in scene.hand.pads]
    for geom in np.flatnonzero(scene.taxel >= 0):
        pad = int(np.searchsorted(scene.hand.pad_offsets, scene.taxel[geom], side="right")) - 1
        stiffness = taxel_stiffness(scene.settings, pitches[pad])
        link = model.geom_bodyid[geom]
        a = model.body_invweight0[link, 0] + model.body_invweight0[scene.object_body, 0]
        k = stiffness * (1.0 - d) * a
        model.geom_solref[geom] = (-k, -2.0 * PAD_DAMPING_RATIO * np.sqrt(k))
        model.geom_solimp[geom] = (d, d, 0.001, 0.5, 2.0)
        model.geom_friction[geom, 0] = friction
    hard = scene.geom_group == OBJECT_GEOM
    structure = (scene.geom_group == HAND_GEOM) & (scene.taxel < 0)
    model.geom_solref[hard | structure] = HARD_SOLREF
    model.geom_friction[structure, 0] = friction
    # The table's priority puts its own friction in force; no object is rougher there than in hand.
    model.geom_friction[scene.table, 0] = min(model.geom_friction[scene.table, 0], friction)
