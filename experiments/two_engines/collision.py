"""What collides in Drake: shapes with their contact laws, and which pairs of them may touch."""

# pyright: reportMissingImports=false
from __future__ import annotations

import itertools
from typing import NamedTuple

import mujoco
import numpy as np
from pydrake.geometry import (
    AddContactMaterial,
    CollisionFilterDeclaration,
    GeometryId,
    GeometrySet,
    ProximityProperties,
    Role,
    SceneGraph,
    SourceId,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import RigidBody

from experiments.two_engines.alignment import Alignment
from experiments.two_engines.contact_laws import (
    ContactLaw,
    hunt_crossley,
    law_of,
    object_friction,
    touchable,
)
from experiments.two_engines.shapes import shape_of, standing_points, transform_of
from sdh_sim.cell import Scene

RIGID = 1e9  # stiffness of the object's own surface: contacts are as what touches it says [N/m]
POINT = 1e-6  # radius of the points that the object stands on [m]


class Part(NamedTuple):
    """Geoms of the hand that collide with the same others.

    Attributes:
        body: id in MuJoCo.
        contype, conaffinity: contact bits there.
    """

    body: int
    contype: int
    conaffinity: int


class Surfaces(NamedTuple):
    """Geometries of Drake.

    Attributes:
        hand: of its hard parts, by their part.
        geom: id in MuJoCo of each of the hand's, taxels too.
        obj: of the object, that the hand meets.
        standing: of the object, that the table meets.
        table: of the table.
        idle: taxels (with their ids in MuJoCo) that have no role in contact until they are near.
        materials: of the taxels.
    """

    hand: dict[Part, list[GeometryId]]
    geom: dict[GeometryId, int]
    obj: list[GeometryId]
    standing: list[GeometryId]
    table: list[GeometryId]
    idle: dict[GeometryId, int]
    materials: dict[GeometryId, ProximityProperties]


def add_surfaces(
    plant: MultibodyPlant, scene: Scene, bodies: dict[int, RigidBody], obj: RigidBody,
    table: RigidBody, pose: np.ndarray, alignment: Alignment,
) -> Surfaces:  # fmt: skip
    """Register all that collides, before the plant is finalised.

    Args:
        plant: with the bodies.
        scene: of MuJoCo.
        bodies: of the hand, by their id in MuJoCo.
        obj, table: the other bodies.
        pose: of the object in the world (7,), as it stands.
        alignment: decides on the contact laws.
    """
    model = scene.model
    hand: dict[Part, list[GeometryId]] = {}
    geoms: dict[GeometryId, int] = {}
    idle: dict[GeometryId, int] = {}
    materials: dict[GeometryId, ProximityProperties] = {}
    for body, added in bodies.items():
        for geom in map(int, np.flatnonzero(touchable(model, body))):
            law = law_of(scene, geom, alignment)
            material = _material(law, alignment)
            made = _register(plant, model, geom, added, material)
            geoms[made] = geom
            if scene.taxel[geom] >= 0:
                idle[made], materials[made] = geom, material
                continue
            part = Part(body, int(model.geom_contype[geom]), int(model.geom_conaffinity[geom]))
            hand.setdefault(part, []).append(made)
    smooth = _material(ContactLaw(RIGID, 0.0, object_friction(scene)))
    own = [
        _register(plant, model, int(geom), obj, smooth)
        for geom in np.flatnonzero(touchable(model, scene.object_body))
    ]
    law = law_of(scene, scene.table, alignment)
    if not alignment.points:  # Drake combines the table's friction with that of the shapes in hand
        law = law._replace(friction=_partner(law.friction, object_friction(scene)))
    top = _register(plant, model, scene.table, table, _material(law, alignment))
    standing = own
    if alignment.points:
        smooth = _material(ContactLaw(RIGID, 0.0, law.friction))
        standing = [
            plant.RegisterCollisionGeometry(
                obj, RigidTransform(point), Sphere(POINT), f"point{k}", smooth
            )
            for k, point in enumerate(standing_points(model, scene.object_body, pose))
        ]
    return Surfaces(hand, geoms, own, standing, [top], idle, materials)


def _partner(wanted: float, own: float) -> float:
    """Coefficient that makes 2 a b / (a + b), with which Drake combines two, the wanted one."""
    return wanted * own / (2.0 * own - wanted)


def _material(law: ContactLaw, alignment: Alignment | None = None) -> ProximityProperties:
    """Contact law of a geometry; without an alignment it loses no energy of its own."""
    found = ProximityProperties()
    AddContactMaterial(
        properties=found,
        dissipation=hunt_crossley(alignment) if alignment else 0.0,
        point_stiffness=law.stiffness,
        friction=CoulombFriction(law.friction, law.friction),
    )
    found.AddProperty("material", "relaxation_time", law.relaxation)
    return found


def _register(
    plant: MultibodyPlant, model: mujoco.MjModel, geom: int, body: RigidBody,
    material: ProximityProperties,
) -> GeometryId:  # fmt: skip
    place = transform_of(model.geom_pos[geom], model.geom_quat[geom])
    name = model.geom(geom).name or f"geom{geom}"
    return plant.RegisterCollisionGeometry(body, place, shape_of(model, geom), name, material)


def set_filters(graph: SceneGraph, source: SourceId, scene: Scene, surfaces: Surfaces) -> None:
    """Let those pairs touch that touch in MuJoCo, of hand, object and table."""
    manager = graph.collision_filter_manager()
    for taxel in surfaces.idle:
        graph.RemoveRole(source, taxel, Role.kProximity)

    def exclude(first: list[GeometryId], second: list[GeometryId]) -> None:
        declared = CollisionFilterDeclaration()
        declared.ExcludeBetween(GeometrySet(first), GeometrySet(second))
        manager.Apply(declared)

    for first, second in itertools.combinations(surfaces.hand, 2):
        if not may_touch(scene.model, first, second):
            exclude(surfaces.hand[first], surfaces.hand[second])
    for part, shapes in surfaces.hand.items():
        if not meets_object(scene, part):
            exclude(shapes, surfaces.obj)
        exclude(shapes, surfaces.table)  # the trials' approach keeps them apart
        if surfaces.standing is not surfaces.obj:
            exclude(shapes, surfaces.standing)
    if surfaces.standing is not surfaces.obj:
        exclude(surfaces.obj, surfaces.table)


def may_touch(model: mujoco.MjModel, first: Part, second: Part) -> bool:
    """Whether MuJoCo looks for contacts between two parts of the hand."""
    if not _bits_meet(first.contype, first.conaffinity, second.contype, second.conaffinity):
        return False
    bodies = first.body, second.body
    if bodies[0] == bodies[1] or int(model.body_weldid[bodies[0]]) == model.body_weldid[bodies[1]]:
        return False
    fixed_to = model.body_weldid
    for one, other in (bodies, bodies[::-1]):  # nor between a body and its parent
        if fixed_to[model.body_parentid[fixed_to[one]]] == fixed_to[other]:
            return False
    low, high = sorted(bodies)
    return (low << 16) + high not in set(map(int, model.exclude_signature))


def meets_object(scene: Scene, part: Part) -> bool:
    """Whether MuJoCo looks for contacts between a part of the hand and the object."""
    geom = int(np.flatnonzero(touchable(scene.model, scene.object_body))[0])
    bits = int(scene.model.geom_contype[geom]), int(scene.model.geom_conaffinity[geom])
    return _bits_meet(part.contype, part.conaffinity, *bits)


def _bits_meet(type1: int, affinity1: int, type2: int, affinity2: int) -> bool:
    return bool(type1 & affinity2 or type2 & affinity1)
