"""What can be grasped: the paper's four objects, and folders of users."""

from sdh_sim.objects.catalogue import (
    OBJECT,
    PAPER_ORDER,
    find_objects,
    object_info,
    object_names,
    object_spec,
    user_object,
)
from sdh_sim.objects.object_info import ObjectInfo, Spread
from sdh_sim.objects.surface import ObjectSurface, surface_of

__all__ = [
    "OBJECT",
    "PAPER_ORDER",
    "ObjectInfo",
    "ObjectSurface",
    "Spread",
    "find_objects",
    "object_info",
    "object_names",
    "object_spec",
    "surface_of",
    "user_object",
]
