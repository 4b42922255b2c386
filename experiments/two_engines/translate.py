"""The compiled MuJoCo model of hand, taxels, object and table, rebuilt in Drake.

There is no second model file: bodies, joints, motors, shapes and contact laws are read from the
scene that the trials run in. The arm is left out, the palm moves along the world's z alone.
"""

# pyright: reportMissingImports=false
from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    Frame,
    Joint,
    ModelInstanceIndex,
    PdControllerGains,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
    RotationalInertia,
    SpatialInertia,
)
from pydrake.systems.framework import Diagram, DiagramBuilder

from experiments.two_engines.alignment import ALIGNED, Alignment
from experiments.two_engines.collision import Surfaces, add_surfaces, set_filters
from experiments.two_engines.shapes import transform_of
from sdh_sim.cell import Scene
from sdh_sim.errors import SettingsError
from sdh_sim.poses import rotation_of

# What carries the palm and the table: 20 N move it by 5 µm, as the trials' floating base.
CARRIER_MASS, CARRIER_FREQUENCY = 100.0, 200.0  # [kg], [rad/s]


@dataclass(frozen=True)
class DrakeScene:
    """Hand, object and table in Drake, in the world of the MuJoCo scene.

    Attributes:
        scene: of MuJoCo, that it was made from.
        alignment: what was made equal.
        diagram, plant, graph: of Drake.
        hand, palm_carrier, table_carrier: model instances; each has an input port for the
            references of its motors: those of ``scene.motors`` first, in their order.
        palm, obj, table: bodies; the first two have the frames of MuJoCo's.
        joints: of the hand by their id in MuJoCo.
        object_joints: of an object that slides or turns on some (of a rig) by their id; None where
            it is free.
        surfaces: ids of what collides.
    """

    scene: Scene
    alignment: Alignment
    diagram: Diagram
    plant: MultibodyPlant
    graph: SceneGraph
    hand: ModelInstanceIndex
    palm_carrier: ModelInstanceIndex
    table_carrier: ModelInstanceIndex
    palm: RigidBody
    obj: RigidBody
    table: RigidBody
    joints: dict[int, Joint]
    object_joints: dict[int, Joint] | None
    surfaces: Surfaces


def translate(
    scene: Scene, palm_pose: np.ndarray, object_pose: np.ndarray, alignment: Alignment = ALIGNED
) -> DrakeScene:
    """Rebuild a scene.

    Args:
        scene: of MuJoCo.
        palm_pose: where the palm is, in the world (7,) [m, 1].
        object_pose: where the object stands, in the world (7,) [m, 1].
        alignment: what is made equal.

    Raises:
        SettingsError: the hand has what this cannot translate: tendons, gears, springs, joints
            that neither slide nor turn, motors that are no position servos.
    """
    _check(scene)
    model = scene.model
    builder = DiagramBuilder()
    approximation = "sap" if alignment.dissipation else "lagged"
    config = MultibodyPlantConfig(
        time_step=scene.settings.timestep,
        contact_model="point",
        discrete_contact_approximation=approximation,
    )
    plant, graph = AddMultibodyPlant(config, builder)
    hand, others = plant.AddModelInstance("hand"), plant.AddModelInstance("object")
    carriers = [plant.AddModelInstance(f"{name}_carrier") for name in ("palm", "table")]
    bodies = {scene.palm: _add_body(plant, model, scene.palm, hand)}
    for body in _below(model, scene.palm):
        bodies[body] = _add_body(plant, model, body, hand)
    obj = _add_body(plant, model, scene.object_body, others)
    table = _carrier(plant, "table", carriers[1], np.zeros(3))
    below = _carrier(plant, "palm", carriers[0], palm_pose[:3])
    turn = transform_of(np.zeros(3), palm_pose[3:])
    plant.WeldFrames(below.body_frame(), bodies[scene.palm].body_frame(), turn)
    joints = {}
    for body, added in bodies.items():
        if body != scene.palm:
            parent = bodies[int(model.body_parentid[body])]
            joints |= _join(plant, model, body, added, parent)
    _add_motors(plant, scene, joints)
    _couple(plant, model, joints)
    object_joints = _guide(plant, model, scene.object_body, obj)
    for instance in (hand, others, *carriers):
        plant.set_gravity_enabled(instance, False)
    surfaces = add_surfaces(plant, scene, bodies, obj, table, object_pose, alignment)
    plant.Finalize()
    source = plant.get_source_id()
    assert source is not None
    set_filters(graph, source, scene, surfaces)
    return DrakeScene(
        scene, alignment, builder.Build(), plant, graph, hand, carriers[0], carriers[1],
        bodies[scene.palm], obj, table, joints, object_joints, surfaces,
    )  # fmt: skip


def _check(scene: Scene) -> None:
    model = scene.model
    if (scene.motor_qpos < 0).any() or model.ntendon:
        raise SettingsError(
            f"hand {scene.hand.name}: its motors act through tendons or gears, which the second "
            "engine's model has not; take one whose motors drive joints, as the SDH-2"
        )
    if np.any(model.jnt_stiffness):
        raise SettingsError(
            f"hand {scene.hand.name}: springs on its joints are not translated; take another hand"
        )


def _below(model: mujoco.MjModel, root: int) -> list[int]:
    """Bodies that hang on a body, parents first."""
    found = [root]
    for body in range(root + 1, model.nbody):
        if model.body_parentid[body] in found:
            found.append(body)
    return found[1:]


def inertia_of(model: mujoco.MjModel, body: int) -> SpatialInertia:
    """Of a body about its frame's origin, in its axes [kg, m, kg m²]."""
    turn = rotation_of(model.body_iquat[body])
    central = turn @ np.diag(model.body_inertia[body]) @ turn.T
    upper = central[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    return SpatialInertia.MakeFromCentralInertia(
        float(model.body_mass[body]), model.body_ipos[body], RotationalInertia(*upper)
    )


def _add_body(
    plant: MultibodyPlant, model: mujoco.MjModel, body: int, instance: ModelInstanceIndex
) -> RigidBody:
    return plant.AddRigidBody(model.body(body).name, instance, inertia_of(model, body))


def _carrier(
    plant: MultibodyPlant, name: str, instance: ModelInstanceIndex, place: np.ndarray
) -> RigidBody:
    """A body that slides along the world's z from a place (3,) [m], moved by a stiff servo."""
    inertia = SpatialInertia.SolidBoxWithMass(CARRIER_MASS, 1.0, 1.0, 1.0)
    body = plant.AddRigidBody(f"{name}_carrier", instance, inertia)
    start = plant.AddFrame(
        FixedOffsetFrame(f"{name}_start", plant.world_frame(), RigidTransform(place), instance)
    )
    joint = PrismaticJoint(f"{name}_rise", start, body.body_frame(), np.array([0.0, 0.0, 1.0]))
    motor = plant.AddJointActuator(f"{name}_rise", plant.AddJoint(joint))
    stiffness = CARRIER_MASS * CARRIER_FREQUENCY**2
    damping = 2.0 * CARRIER_MASS * CARRIER_FREQUENCY
    motor.set_controller_gains(PdControllerGains(p=stiffness, d=damping))
    return body


def _join(
    plant: MultibodyPlant, model: mujoco.MjModel, body: int, added: RigidBody, parent: RigidBody
) -> dict[int, Joint]:
    """The joint of a body, by its id; a body without one is welded to its parent."""
    frame = plant.AddFrame(
        FixedOffsetFrame(
            f"{added.name()}_on_parent", parent.body_frame(),
            transform_of(model.body_pos[body], model.body_quat[body]),
        )
    )  # fmt: skip
    if not model.body_jntnum[body]:
        plant.WeldFrames(frame, added.body_frame())
        return {}
    number = int(model.body_jntadr[body])
    if model.body_jntnum[body] > 1:
        raise SettingsError(
            f"joint {model.joint(number).name!r}: the second engine takes one joint for a body"
        )
    return {number: _add_joint(plant, model, number, frame, added)}


def _add_joint(
    plant: MultibodyPlant, model: mujoco.MjModel, number: int, frame: Frame, added: RigidBody
) -> Joint:
    types = mujoco.mjtJoint
    kinds = {types.mjJNT_HINGE: RevoluteJoint, types.mjJNT_SLIDE: PrismaticJoint}
    kind = kinds.get(int(model.jnt_type[number]))
    if kind is None or model.jnt_pos[number].any():
        raise SettingsError(
            f"joint {model.joint(number).name!r}: the second engine takes a hinge or a slide "
            "through the body's origin"
        )
    lower, upper = model.jnt_range[number] if model.jnt_limited[number] else (-np.inf, np.inf)
    damping = float(model.dof_damping[model.jnt_dofadr[number]])
    joint = kind(
        model.joint(number).name, frame, added.body_frame(), model.jnt_axis[number],
        lower, upper, damping,
    )  # fmt: skip
    return plant.AddJoint(joint)


def _guide(
    plant: MultibodyPlant, model: mujoco.MjModel, body: int, obj: RigidBody
) -> dict[int, Joint] | None:
    """Joints between the world and an object by their id, one after the other; a free one: None."""
    count, first = int(model.body_jntnum[body]), int(model.body_jntadr[body])
    if count == 1 and model.jnt_type[first] == mujoco.mjtJoint.mjJNT_FREE:
        return None
    place = transform_of(model.body_pos[body], model.body_quat[body])
    frame: Frame = plant.AddFrame(FixedOffsetFrame("object_place", plant.world_frame(), place))
    if not count:
        plant.WeldFrames(frame, obj.body_frame())
        return {}
    joints = {}
    for number in range(first, first + count):
        carried = obj
        if number < first + count - 1:
            name = f"before_{model.joint(number + 1).name}"
            carried = plant.AddRigidBody(name, obj.model_instance(), SpatialInertia.Zero())
        joints[number] = _add_joint(plant, model, number, frame, carried)
        frame = carried.body_frame()
    return joints


def _add_motors(plant: MultibodyPlant, scene: Scene, joints: dict[int, Joint]) -> None:
    """Position servos on the motors' joints; on others rotors alone, for their armature."""
    model = scene.model
    driven = {int(model.actuator_trnid[motor, 0]): int(motor) for motor in scene.motors}
    passive = [number for number in joints if number not in driven]
    for number in (*driven, *passive):
        joint = joints[number]
        motor = driven.get(number)
        limit = float(model.actuator_forcerange[motor, 1]) if motor is not None else np.inf
        actuator = plant.AddJointActuator(f"{joint.name()}_motor", joint, limit)
        actuator.set_default_rotor_inertia(float(model.dof_armature[model.jnt_dofadr[number]]))
        actuator.set_default_gear_ratio(1.0)
        if motor is not None:
            p, d = model.actuator_gainprm[motor, 0], -model.actuator_biasprm[motor, 2]
            actuator.set_controller_gains(PdControllerGains(p=float(p), d=float(d)))


def _couple(plant: MultibodyPlant, model: mujoco.MjModel, joints: dict[int, Joint]) -> None:
    """Equalities that make one joint follow another in proportion."""
    for k in range(model.neq):
        first, second = int(model.eq_obj1id[k]), int(model.eq_obj2id[k])
        if model.eq_type[k] != mujoco.mjtEq.mjEQ_JOINT or first not in joints:
            continue
        offset, ratio = model.eq_data[k, :2]
        if model.eq_data[k, 2:5].any() or second not in joints:
            raise SettingsError(
                f"equality {model.equality(k).name!r}: the second engine couples two joints in "
                "proportion, nothing else"
            )
        at = model.jnt_qposadr[[first, second]]
        offset += model.qpos0[at[0]] - ratio * model.qpos0[at[1]]
        plant.AddCouplerConstraint(joints[first], joints[second], float(ratio), float(offset))
