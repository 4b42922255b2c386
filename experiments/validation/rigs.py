"""Rigs for the validation: a hand with its real pads, and simple bodies to press on them.

A rig is one of the project's hands (the SDH-2 where none is named), its taxels made rubber by the
same function that serves the trials, standing palm up above the table, and one test body of simple
shape. A *bench* is the hand with all
its joints welded and a test body that slides on the normal of one pad, so that the force on the pad
is known exactly; a *gripper* is the hand alive. World and palm frame have the same axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextvars import ContextVar
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from sdh_sim.cell import Scene
from sdh_sim.cell.drives import drives_in, give_drives
from sdh_sim.cell.scene_builder import geom_fingers, geom_groups, set_contacts, taxel_index
from sdh_sim.model_files import models_dir
from sdh_sim.objects import OBJECT, object_info
from sdh_sim.robot import HAND, Hand, built_in_hand, hand_kinematics, hand_spec, palm_motion_of
from sdh_sim.settings import PAPER_TORQUE_LIMIT, TrialSettings

HAND_PLACE = np.array([0.45, 0.0, 0.4])  # of the hand's mount in the world [m]
GRAVITY = 9.81
TEST_BODY_MASS = 0.5  # [kg]; near that of the paper's objects
TAXEL_RADIUS = 0.0132  # [m] of the taxels' spheres in the middle columns of a proximal pad


@dataclass(frozen=True)
class Spoil:
    """What falsifies the simulated model behind a check's back; factors of 1 leave it as it is.

    The checks predict from the true values, so a test can see that they fail.

    Attributes:
        stiffness: on the contact stiffness of the taxels.
        friction: on every friction coefficient.
        torque: on the motors' torque limits.
        impratio: on the ratio of friction to normal impedance.
        gravity: on the acceleration of a released test body, and on the support that the real
            workcell gives the hand's own weight.
        creep: on the time constant of the tactile arrays' creep.
        implicit: take damping implicitly, behind the contact solver's back.
    """

    stiffness: float = 1.0
    friction: float = 1.0
    torque: float = 1.0
    impratio: float = 1.0
    gravity: float = 1.0
    creep: float = 1.0
    implicit: bool = False


HONEST = Spoil()


@dataclass(frozen=True)
class Shape:
    """A geom of the test body, in the test body's frame.

    Attributes:
        kind: ``box``, ``sphere`` or ``cylinder``.
        size: as in MJCF [m].
        pos: centre [m].
        axis: of a cylinder.
    """

    kind: str
    size: Sequence[float]
    pos: Sequence[float] = (0.0, 0.0, 0.0)
    axis: Sequence[float] = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Frame:
    """Position (3,) [m] and rotation (3, 3) in the palm frame."""

    position: np.ndarray
    rotation: np.ndarray


def pad_frame(
    pad: str, row: float, column: float, angles: np.ndarray | None = None, hand: Hand | None = None
) -> Frame:
    """Frame on a pad: x out of it, y across the finger, at motor positions (n,) (default 0)."""
    hand = hand or built_in_hand()
    found = hand.pads[hand.pad_names.index(pad)]
    at = np.zeros(len(hand.motors)) if angles is None else angles
    position, rotation = hand_kinematics(hand).at(at).link(found.body)
    point, normal = found.array.surface(row, column)
    across = np.array([0.0, 1.0, 0.0])
    axes = np.column_stack([normal, across, np.cross(normal, across)])
    return Frame(position + rotation @ point, rotation @ axes)


def bench(
    pad: str, row: float, column: float, shapes: Sequence[Shape], joints: Sequence[str],
    settings: TrialSettings, friction: float, spoil: Spoil = HONEST, hand: Hand | None = None,
) -> Scene:  # fmt: skip
    """The hand welded, a test body that moves in the frame of a pad at (row, column).

    Args:
        pad: such as ``finger1_proximal``.
        row, column: where on the pad the test body's frame lies (x out of the pad, y across).
        shapes: of the test body; it should touch the pad at the origin of its frame.
        joints: ``press`` slides along x, ``pull`` along y, ``draw`` along z, ``twist`` turns
            about x; the test body keeps those only, in this order.
        settings: rubber and time step.
        friction: between pads and test body.
        spoil: falsification, for tests.
        hand: None is the SDH-2.

    Of the hand, only the link that carries the pad can touch the test body.
    """
    hand = hand or built_in_hand()
    spec = _hand_spec(settings, hand)
    for item in [*spec.actuators, *spec.equalities, *spec.joints]:
        spec.delete(item)
    test_body = _test_body(spec, hand, pad_frame(pad, row, column, hand=hand), shapes)
    axes = {"press": (1, 0, 0), "pull": (0, 1, 0), "draw": (0, 0, 1), "twist": (1, 0, 0)}
    for name in joints:
        kind = mujoco.mjtJoint.mjJNT_HINGE if name == "twist" else mujoco.mjtJoint.mjJNT_SLIDE
        test_body.add_joint(name=name, type=kind, axis=axes[name])
    scene = _scene(spec, settings, friction, spoil, hand)
    link = scene.model.body(HAND + hand.pads[hand.pad_names.index(pad)].body).id
    idle = (scene.model.geom_bodyid != link) & (scene.model.geom_bodyid != scene.object_body)
    scene.model.geom_contype[idle] = scene.model.geom_conaffinity[idle] = 0
    return scene


def gripper(
    place: Frame, shapes: Sequence[Shape], free: bool, settings: TrialSettings, friction: float,
    spoil: Spoil = HONEST, inertia: Sequence[float] = (1e-3, 1e-3, 1e-3),
    hand: Hand | None = None, limit: Sequence[float] | None = None,
    radius: float | None = None,
) -> Scene:  # fmt: skip
    """The live hand and a test body, fixed in the world or free, at a place in the palm frame.

    ``limit`` is that of the hand's groups of motors; None takes the one of the settings. With a
    ``radius`` [m] the hand stands on a heavy turntable, whose joint ``turn`` about z is that far
    from the hand's mount, along -x.
    """
    hand = hand or built_in_hand()
    spec = _hand_spec(settings, hand, radius)
    limits = spoil.torque * hand.torque_limits(settings.torque_limit if limit is None else limit)
    names = [HAND + name for name in hand.motor_names]
    give_drives(spec, names, limits, settings.drive, settings.gear_friction)
    test_body = _test_body(spec, hand, place, shapes, inertia)
    if free:
        test_body.add_freejoint(name="free")
    scene = _scene(spec, settings, friction, spoil, hand)
    drives = drives_in(scene.model, scene.motors, limits, settings.drive, settings.gear_friction)
    return replace(scene, drives=drives)


timestep_in_use: ContextVar[float] = ContextVar("timestep_in_use", default=0.002)
"""Time step [s] of the checks that do not choose their own."""


def settings_for(
    timestep: float | None = None, modulus: float = 1e6,
    torque_limit: tuple[float, float] = PAPER_TORQUE_LIMIT,
) -> TrialSettings:  # fmt: skip
    """Trial settings of a rig; the object they name stands for the rig's own test body."""
    return TrialSettings(
        "box", timestep=timestep or timestep_in_use.get(), pad_modulus=modulus,
        torque_limit=torque_limit, sensor="ideal",
    )  # fmt: skip


def _hand_spec(settings: TrialSettings, hand: Hand, radius: float | None = None) -> mujoco.MjSpec:
    """Table and hand; the options are those of the workcell."""
    spec = mujoco.MjSpec.from_file(str(models_dir() / "cell" / "cell.xml"))
    base, place = spec.worldbody, HAND_PLACE
    if radius is not None:
        place = np.array([radius, 0.0, 0.0])
        base = spec.worldbody.add_body(name="turntable", pos=HAND_PLACE - place)
        base.explicitinertial = True
        base.mass, base.inertia, base.ipos = 1.0, (1e4, 1e4, 1e4), (0.0, 0.0, 0.0)
        base.add_joint(name="turn", type=mujoco.mjtJoint.mjJNT_HINGE, axis=(0.0, 0.0, 1.0))
    spec.attach(hand_spec(hand), prefix=HAND, frame=base.add_frame(pos=place))
    for body in spec.bodies:
        if body.name.startswith(HAND):
            body.gravcomp = 1.0
    spec.option.timestep = settings.timestep
    spec.option.gravity = [0.0, 0.0, 0.0]
    return spec


def _test_body(
    spec: mujoco.MjSpec, hand: Hand, place: Frame, shapes: Sequence[Shape],
    inertia: Sequence[float] = (1e-3, 1e-3, 1e-3),
) -> mujoco.MjsBody:  # fmt: skip
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, place.rotation.ravel())
    palm = HAND_PLACE + hand_kinematics(hand).palm_offset()[0]
    body = spec.worldbody.add_body(name=f"{OBJECT}object", pos=palm + place.position, quat=quat)
    body.explicitinertial = True
    body.mass, body.inertia, body.ipos = TEST_BODY_MASS, inertia, (0.0, 0.0, 0.0)
    kinds = {
        "box": mujoco.mjtGeom.mjGEOM_BOX,
        "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
        "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    }
    for shape in shapes:
        size = np.zeros(3)
        size[: len(shape.size)] = shape.size
        turn = np.empty(4)
        mujoco.mju_quatZ2Vec(turn, np.asarray(shape.axis, dtype=float))
        body.add_geom(
            type=kinds[shape.kind], size=size, pos=shape.pos, quat=turn, contype=1,
            conaffinity=15, condim=3, density=0.0,
        )  # fmt: skip
    return body


def _scene(
    spec: mujoco.MjSpec, settings: TrialSettings, friction: float, spoil: Spoil, hand: Hand
) -> Scene:
    """Compile, and give the pads their rubber by the scene's own function."""
    model = spec.compile()
    joints = {model.joint(k).name for k in range(model.njnt)}
    alone = hand_kinematics(hand).model
    names = {model.actuator(k).name for k in range(model.nu)}  # of a welded hand: none
    motors = [model.actuator(HAND + n) for n in hand.motor_names if HAND + n in names]
    driven = [model.joint(int(motor.trnid[0])) for motor in motors]
    of_hand = [HAND + alone.joint(k).name for k in range(alone.njnt)]
    test_body = model.body(f"{OBJECT}object").id
    moves = model.body_jntnum[test_body] > 0
    first = model.joint(int(model.body_jntadr[test_body])) if moves else None
    none = np.empty(0, dtype=np.int64)
    scene = Scene(
        model=model,
        settings=settings,
        motors=np.array([motor.id for motor in motors], dtype=np.int64),
        motor_qpos=np.array([joint.qposadr[0] for joint in driven], dtype=np.int64),
        motor_dof=np.array([joint.dofadr[0] for joint in driven], dtype=np.int64),
        hand=hand,
        palm_motion=palm_motion_of(settings.arm, hand),
        hand_qpos=np.array([model.joint(n).qposadr[0] for n in of_hand if n in joints], np.int64),
        joint_positions=hand_kinematics(hand).joint_positions,
        arm_motors=none, arm_qpos=none, arm_dof=none, arm_speed_limit=none,
        palm=model.body(HAND + hand.palm).id,
        object_body=test_body,
        obj=object_info(settings.object),
        object_qpos=int(first.qposadr[0]) if first is not None else -1,
        object_dof=int(first.dofadr[0]) if first is not None else -1,
        table=model.geom("table").id,
        fixture=-1,
        taxel=taxel_index(model, hand),
        geom_group=geom_groups(model),
        geom_finger=geom_fingers(model, hand),
    )  # fmt: skip
    set_contacts(scene)
    model.geom_solref[scene.taxel >= 0] *= (spoil.stiffness, np.sqrt(spoil.stiffness))
    model.opt.impratio *= spoil.impratio
    set_friction(scene, friction * spoil.friction)
    return scene


def set_friction(scene: Scene, friction: float) -> None:
    """Sliding friction of everything that can touch the test body."""
    scene.model.geom_friction[:, 0] = friction
