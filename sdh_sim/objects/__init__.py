"""What can be grasped: the paper's four objects, and users' folders with an object each.

Other rooms use what is named here; the other files read and check what users bring.
"""

from sdh_sim.objects.catalogue import (
    PAPER_ORDER,
    find_objects,
    object_info,
    object_names,
    object_spec,
    surface_corners,
    surface_of,
    user_object,
)
from sdh_sim.objects.contact_settings import HARD_SOLREF
from sdh_sim.objects.facts import DEFAULT_SPREAD, Spread
from sdh_sim.objects.object_info import OBJECT, ObjectInfo
from sdh_sim.objects.surface import ObjectSurface
from sdh_sim.objects.surface_corners import SurfaceCorners
from sdh_sim.objects.user_objects import UserObject

__all__ = [
    "DEFAULT_SPREAD",
    "HARD_SOLREF",
    "OBJECT",
    "PAPER_ORDER",
    "ObjectInfo",
    "ObjectSurface",
    "Spread",
    "SurfaceCorners",
    "UserObject",
    "find_objects",
    "object_info",
    "object_names",
    "object_spec",
    "surface_corners",
    "surface_of",
    "user_object",
]
