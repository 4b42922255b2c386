"""What is stated of an object beside its shape: mass, friction, spread of its grasps and so on."""

from __future__ import annotations

import math
from dataclasses import dataclass

FACTS = "object.toml"
MESHES = (".stl", ".obj", ".ply", ".off", ".glb", ".gltf", ".msh")  # endings of files with a shape
MJCF = ".xml"


@dataclass(frozen=True)
class Spread:
    """Choices and errors of the random grasps on one object.

    Attributes:
        side: share of approaches from the side, the others come from above.
        wide: share of grasps that close across the wider side, the others across the narrower.
        offset: standard deviation of the position error along each palm axis [m].
        yaw: standard deviation of the object's yaw off square [rad].
    """

    side: float
    wide: float
    offset: float
    yaw: float


DEFAULT_SPREAD = Spread(side=0.6, wide=0.25, offset=0.007, yaw=math.radians(15))


@dataclass(frozen=True)
class Facts:
    """The content of ``object.toml``.

    Attributes:
        name: of the object in tables; the folder's name where it is not given.
        mass: [kg].
        friction: Coulomb's coefficient against the pads.
        com: centre of mass in the object's frame (3,) [m]; None: that of a homogeneous solid.
        inertia: xx yy zz xy xz yz about the centre of mass, the object's axes (6,) [kg m^2]; None:
            that of a homogeneous solid about its own centroid.
        model: file of the shape in the folder; None: the only one there.
        scale: metres per unit of length of a mesh file.
        up: axis of the object's frame that points up on the table.
        pose: number of the stable pose in which it stands, by its tilt from that, from 1; None: as
            ``up`` says where it rests so, else the first.
        hull: a mesh that is not closed or not convex may be replaced by its hull in contacts.
        decompose: it is decomposed into convex parts instead.
        spread: of the grasps; None: the default.
    """

    name: str
    mass: float
    friction: float
    com: tuple[float, ...] | None = None
    inertia: tuple[float, ...] | None = None
    model: str | None = None
    scale: float = 1.0
    up: str = "z"
    pose: int | None = None
    hull: bool = False
    decompose: bool = False
    spread: Spread | None = None
