"""Drake stepped as the trials step MuJoCo: references in, motion of the object in the hand out."""

# pyright: reportMissingImports=false
from __future__ import annotations

from typing import NamedTuple, cast

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import CollisionFilterDeclaration, GeometrySet
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    ContactResults,
    ExternallyAppliedSpatialForce,
    PointPairContactInfo,
)
from pydrake.multibody.tree import RigidBody
from pydrake.systems.analysis import Simulator

from experiments.two_engines.near import NearTaxels
from experiments.two_engines.shapes import transform_of
from experiments.two_engines.translate import DrakeScene
from sdh_sim.cell.simulation import TICK
from sdh_sim.errors import Diverged
from sdh_sim.poses import quaternion_of
from sdh_sim.sensing import GRAVITY

MAX_SPEED = 1e3  # as MuJoCo's simulation


class ObjectContact(NamedTuple):
    """A contact of the hand with the object.

    Attributes:
        geom: of the hand, its id in MuJoCo.
        link: that it is part of.
        point: in the world (3,) [m].
        force: on the object, in the world (3,) [N].
        normal: its part along the normal [N].
    """

    geom: int
    link: RigidBody
    point: np.ndarray
    force: np.ndarray
    normal: float


class DrakeSimulation:
    """Hand and object in motion; gravity acts on the object alone, as a force.

    Args:
        made: the translated scene.

    Attributes:
        made: as given.
        context: of the plant, with the state.
        tick_time: length of a control period [s].
        references: of the motors' servos (n,) [rad or m].
    """

    def __init__(self, made: DrakeScene) -> None:
        self.made = made
        step = made.scene.settings.timestep
        self.steps = max(1, round(TICK / step))
        self.tick_time = self.steps * step
        self._step = step
        self._simulator = Simulator(made.diagram)
        self._root = self._simulator.get_mutable_context()
        self.context = made.plant.GetMyMutableContextFromRoot(self._root)
        self.references = np.zeros(len(made.scene.motors))
        self._rise = self._table = 0.0
        self._table_meets = True
        self.set_weight(1.0)
        self._command(self.references, 0.0, 0.0)
        graph_context = made.graph.GetMyMutableContextFromRoot(self._root)
        self._near = NearTaxels(made, graph_context, self.context)

    def set_to(self, qpos: np.ndarray, object_pose: np.ndarray, references: np.ndarray) -> None:
        """Bring all to rest.

        Args:
            qpos: coordinates of MuJoCo's model, of which the hand's joints are taken.
            object_pose: of the object in the world (7,).
            references: of the servos (n,) [rad or m].
        """
        made, plant = self.made, self.made.plant
        address = made.scene.model.jnt_qposadr
        positions = plant.GetPositions(self.context)
        for number, joint in (made.joints | (made.object_joints or {})).items():
            positions[joint.position_start()] = qpos[address[number]]
        plant.SetPositions(self.context, positions)
        plant.SetVelocities(self.context, np.zeros(plant.num_velocities()))
        if made.object_joints is None:
            pose = transform_of(object_pose[:3], object_pose[3:])
            plant.SetFreeBodyPose(self.context, made.obj, pose)
        self.references = np.array(references, dtype=float)
        self._rise = self._table = 0.0
        self._command(self.references, 0.0, 0.0)
        self._simulator.Initialize()

    def set_weight(self, size: float) -> None:
        """Let so many times the object's weight act on its centre of mass, downwards."""
        obj = self.made.scene.obj
        self.set_force(np.array([0.0, 0.0, -size * obj.mass_kg * GRAVITY]), obj.com_m)

    def set_force(
        self, force: np.ndarray, point: np.ndarray, torque: np.ndarray | None = None
    ) -> None:
        """Let a force act on the object, and nothing else.

        Args:
            force: in the world (3,) [N].
            point: of the object, in its frame (3,) [m].
            torque: beside it, in the world (3,) [N m]; None is none.
        """
        applied = ExternallyAppliedSpatialForce()
        applied.body_index = self.made.obj.index()
        applied.p_BoBq_B = np.asarray(point, dtype=float)
        applied.F_Bq_W = SpatialForce(np.zeros(3) if torque is None else torque, force)
        port = self.made.plant.get_applied_spatial_force_input_port()
        port.FixValue(self.context, Value([applied]))

    def _command(self, references: np.ndarray, rise: float, table: float) -> None:
        made, plant = self.made, self.made.plant
        passive = len(made.joints) - len(references)
        hand = np.concatenate((references, np.zeros(passive)))
        for instance, wanted in (
            (made.hand, hand),
            (made.palm_carrier, np.array([rise])),
            (made.table_carrier, np.array([table])),
        ):
            port = plant.get_desired_state_input_port(instance)
            port.FixValue(self.context, np.concatenate((wanted, np.zeros(len(wanted)))))

    def tick(
        self, references: np.ndarray | None = None, rise: float | None = None,
        table: float | None = None,
    ) -> None:  # fmt: skip
        """One control period; references go to their new values evenly from step to step.

        Args:
            references: of the servos at the end (n,) [rad or m].
            rise: height of the palm above its start at the end [m].
            table: height of the table above its place at the end [m].

        None keeps what is.

        Raises:
            Diverged: Drake's solver gave up, or a speed is beyond any meaning.
        """
        start = np.concatenate((self.references, (self._rise, self._table)))
        end = start.copy()
        if references is not None:
            end[:-2] = references
        if rise is not None:
            end[-2] = rise
        if table is not None:
            end[-1] = table
        moving = bool((end != start).any())
        self._near.update()
        for k in range(1, self.steps + 1):
            if moving:
                now = start + (end - start) * (k / self.steps)
                self._command(now[:-2], now[-2], now[-1])
            try:
                self._simulator.AdvanceTo(self._root.get_time() + self._step)
            except RuntimeError as error:
                raise Diverged from error
        self.references, self._rise, self._table = end[:-2], float(end[-2]), float(end[-1])
        speed = self.made.plant.GetVelocities(self.context)
        if not speed.dot(speed) < MAX_SPEED**2:
            raise Diverged

    def object_in_hand(self) -> np.ndarray:
        """Pose of the object in the palm frame, x y z qw qx qy qz (7,)."""
        made = self.made
        found = made.plant.CalcRelativeTransform(
            self.context, made.palm.body_frame(), made.obj.body_frame()
        )
        return pose_of(found)

    def motor_torques(self) -> np.ndarray:
        """Of the motors in the last step (n,) [N m or N]."""
        port = self.made.plant.get_net_actuation_output_port(self.made.hand)
        return np.array(port.Eval(self.context))[: len(self.references)]

    def motor_positions(self) -> np.ndarray:
        """Of the motors (n,) [rad or m]."""
        made = self.made
        positions = made.plant.GetPositions(self.context)
        driven = [int(made.scene.model.actuator_trnid[m, 0]) for m in made.scene.motors]
        return np.array([positions[made.joints[number].position_start()] for number in driven])

    def object_speed(self) -> tuple[float, float]:
        """Of the object's frame [m/s] and of its turn [rad/s]."""
        found = self.made.plant.EvalBodySpatialVelocityInWorld(self.context, self.made.obj)
        along, about = found.translational(), found.rotational()
        return float(np.linalg.norm(along)), float(np.linalg.norm(about))

    def contacts(self) -> list[PointPairContactInfo]:
        """Contacts of the last step."""
        found = self.made.plant.get_contact_results_output_port().Eval(self.context)
        results = cast(ContactResults, found)
        count = results.num_point_pair_contacts()
        return [results.point_pair_contact_info(k) for k in range(count)]

    def on_table(self) -> bool:
        """Whether the object touches the table."""
        table = self.made.table.index()
        return any(table in (info.bodyA_index(), info.bodyB_index()) for info in self.contacts())

    def object_contacts(self) -> list[ObjectContact]:
        """Contacts of the hand with the object in the last step."""
        made, found = self.made, []
        for info in self.contacts():
            bodies, pair = (info.bodyA_index(), info.bodyB_index()), info.point_pair()
            if made.obj.index() not in bodies or made.table.index() in bodies:
                continue
            second = bodies[1] == made.obj.index()  # Drake's force is that on the second body
            force = info.contact_force() if second else -info.contact_force()
            normal = abs(float(force @ pair.nhat_BA_W))
            geom = made.surfaces.geom[pair.id_A if second else pair.id_B]
            link = made.plant.get_body(bodies[0] if second else bodies[1])
            found.append(ObjectContact(geom, link, info.contact_point(), force, normal))
        return found

    def hand_force(self) -> float:
        """Sum of the normal forces between hand and object [N]."""
        return sum(contact.normal for contact in self.object_contacts())

    def without_table(self) -> None:
        """From now on the object passes through the table."""
        surfaces = self.made.surfaces
        declared = CollisionFilterDeclaration()
        declared.ExcludeBetween(GeometrySet(surfaces.standing), GeometrySet(surfaces.table))
        context = self.made.graph.GetMyMutableContextFromRoot(self._root)
        self.made.graph.collision_filter_manager(context).Apply(declared)

    def save(self) -> np.ndarray:
        """Positions and velocities, for ``restore``."""
        return self.made.plant.GetPositionsAndVelocities(self.context)

    def restore(self, state: np.ndarray) -> None:
        """Go back to saved positions and velocities; the clock runs on."""
        self.made.plant.SetPositionsAndVelocities(self.context, state)


def pose_of(transform: RigidTransform) -> np.ndarray:
    """A transform as x y z qw qx qy qz (7,)."""
    turn = quaternion_of(transform.rotation().matrix())
    return np.concatenate((transform.translation(), turn))
