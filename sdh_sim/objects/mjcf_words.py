"""The elements and attributes of MJCF: what counts, what is ignored, what is refused.

What describes the shape is honoured. What says nothing about it is ignored, and named in one line.
What has a meaning that this testbed cannot honour is refused with the reason, because whoever wrote
it expects it to have an effect. MuJoCo's XML reference says what each of them means.
"""

from __future__ import annotations

import re

SHAPES = ("sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh")
POSE = {"pos": 3, "quat": 4, "axisangle": 4, "euler": 3, "xyaxes": 6, "zaxis": 3}
NAME = re.compile(r"[A-Za-z0-9_./ -]{1,64}")
TEXT = re.compile(r"[^<>&]{0,128}")
FLAG = ("true", "false")
MANY = 1 << 20  # numbers; the size of the file is bounded

# What an attribute may be: so many numbers at most, one of some words, or text of a pattern.
Attribute = int | tuple[str, ...] | re.Pattern[str]

CHILDREN = {
    "mujoco": ("compiler", "default", "asset", "worldbody"),
    "default": ("default", "geom", "mesh", "material"),
    "asset": ("mesh", "material"),
    "worldbody": ("body", "frame", "geom"),
    "body": ("body", "frame", "geom", "joint", "freejoint"),
    "frame": ("body", "frame", "geom"),
}
"""Elements that count, by the element they stand in."""

ATTRIBUTES: dict[str, dict[str, Attribute]] = {
    "mujoco": {"model": TEXT},
    "compiler": {
        "angle": ("radian", "degree"),
        "eulerseq": re.compile("[xyzXYZ]{3}"),
        "meshdir": TEXT,
        "assetdir": TEXT,
        "strippath": FLAG,
        "fitaabb": FLAG,
        "coordinate": ("local",),
    },
    "default": {"class": NAME},
    "mesh": {
        **{"name": NAME, "class": NAME, "file": TEXT, "scale": 3, "refpos": 3, "refquat": 4},
        **{"inertia": ("legacy", "exact", "convex", "shell"), "maxhullvert": 1},
        **{"vertex": MANY, "face": MANY},
    },
    "material": {
        **{"name": NAME, "class": NAME, "rgba": 4, "specular": 1, "shininess": 1},
        "reflectance": 1,
    },
    "body": {"name": NAME, "childclass": NAME, **POSE},
    "frame": {"name": NAME, "childclass": NAME, **POSE},
    "geom": {
        **{"name": NAME, "class": NAME, "mesh": NAME, "material": NAME},
        **{"type": SHAPES, "size": 3, "fromto": 6, "rgba": 4, "group": 1},
        **{"contype": 1, "conaffinity": 1, "fitscale": 1, "mass": 1, "density": 1},
        **POSE,
    },
    "joint": {"type": ("free",)},
    "freejoint": {},
}
"""Attributes that count, by element."""

_SCENERY = ("site", "camera", "light", "inertial")
IGNORED_ELEMENTS = {
    "mujoco": (
        *("option", "size", "visual", "statistic", "custom", "keyframe", "sensor", "contact"),
    ),
    "default": (
        *("site", "camera", "light", "joint", "pair", "equality", "tendon", "general", "motor"),
        *("position", "velocity", "intvelocity", "damper", "cylinder", "muscle", "adhesion"),
    ),
    "asset": ("texture",),
    "material": ("layer",),
    "worldbody": _SCENERY,
    "body": _SCENERY,
    "frame": _SCENERY,
}
"""Elements that say nothing about the shape, by the element they stand in."""

IGNORED_ATTRIBUTES = {
    "compiler": (
        *("autolimits", "balanceinertia", "boundmass", "boundinertia", "settotalmass"),
        *("inertiafromgeom", "inertiagrouprange", "exactmeshinertia", "discardvisual"),
        *("fusestatic", "usethread", "alignfree", "saveinertial", "texturedir", "convexhull"),
        "conflict",
    ),
    "mesh": ("normal", "texcoord", "smoothnormal", "material", "content_type", "octree"),
    "material": ("texture", "texrepeat", "texuniform", "emission", "metallic", "roughness"),
    "body": ("user", "sleep"),
    "geom": (
        *("friction", "condim", "priority", "solmix", "solref", "solimp", "margin", "gap"),
        *("shellinertia", "fluidshape", "fluidcoef", "user"),
    ),
}
"""Attributes that say nothing about the shape, by element."""

NEUTRAL = {("body", "gravcomp"): (0.0,), ("body", "mocap"): ("false",)}
"""Attributes that are ignored with these values and refused with others."""

REASONS = {
    "include": "it stands where no element can be included; put it below <mujoco> or <worldbody>",
    "plugin": "it would run other code; take it out",
    "extension": "it would run other code; take it out",
    "joint": "the object would move in itself; take the joint out, so that the parts are one body",
    "actuator": "an object moves nothing by itself; take it out",
    "tendon": "it would pull at the object; take it out",
    "equality": "it would tie the object to something; take it out",
    "deformable": "objects are rigid; give the shape as a mesh",
    "flexcomp": "objects are rigid; give the shape as a mesh",
    "composite": "objects are rigid; give the shape as a mesh",
    "replicate": "write the copies out",
    "attach": "it would read another model; put its bodies into this file",
    "model": "it would read another model; put its bodies into this file",
    "hfield": "shapes are " + ", ".join(SHAPES),
    "mocap": "the scene moves the object; take mocap out",
    "gravcomp": "the object's weight is what the hand lifts; take gravcomp out",
    "builtin": "write the mesh to a file",
}
"""Why an element or attribute is refused, and what to do."""
