"""The elements and attributes of a hand's MJCF: what counts, what is dropped, what is refused.

Shape, mass and mechanics count. What a scene of its own would need (lights, sensors, options) and
what the testbed sets itself (contact parameters of geoms) is dropped and named in one note. What
would run code, open other files or cannot be honoured is refused with the reason.
"""

from __future__ import annotations

_POSE = ("pos", "quat", "axisangle", "euler", "xyaxes", "zaxis")
_LIMITS = ("solreflimit", "solimplimit", "solreffriction", "solimpfriction", "margin")
_SERVO = (
    *("name", "class", "joint", "tendon", "gear", "ctrlrange", "ctrllimited", "forcerange"),
    *("forcelimited", "lengthrange"),
)
_TIE = ("name", "class", "active", "solref", "solimp")

CHILDREN = {
    "mujoco": (
        *("compiler", "default", "asset", "worldbody", "contact", "tendon", "equality"),
        "actuator",
    ),
    "default": (
        *("default", "geom", "joint", "mesh", "material", "tendon", "equality", "general"),
        "position",
    ),
    "asset": ("mesh", "material"),
    "worldbody": ("body", "frame"),
    "body": ("body", "frame", "geom", "joint", "inertial"),
    "frame": ("body", "frame", "geom", "joint", "inertial"),
    "contact": ("exclude",),
    "tendon": ("fixed",),
    "fixed": ("joint",),
    "equality": ("joint", "tendon", "connect", "weld"),
    "actuator": ("position", "general"),
}
"""Elements that count, by the element they stand in."""

ATTRIBUTES: dict[str, tuple[str, ...]] = {
    "mujoco": ("model",),
    "compiler": (
        *("angle", "eulerseq", "meshdir", "assetdir", "strippath", "fitaabb", "coordinate"),
        *("autolimits", "balanceinertia", "boundmass", "boundinertia", "inertiafromgeom"),
        "inertiagrouprange",
    ),
    "default": ("class",),
    "mesh": (
        *("name", "class", "file", "scale", "refpos", "refquat", "inertia", "maxhullvert"),
        *("vertex", "face"),
    ),
    "material": ("name", "class", "rgba", "specular", "shininess", "reflectance"),
    "body": ("name", "childclass", *_POSE),
    "frame": ("name", "childclass", *_POSE),
    "inertial": (*_POSE, "mass", "diaginertia", "fullinertia"),
    "geom": (
        *("name", "class", "type", "size", "fromto", "mesh", "fitscale", "mass", "density"),
        *("shellinertia", "material", "rgba", "group", "contype", "conaffinity"),
        *_POSE,
    ),
    "joint": (
        *("name", "class", "type", "pos", "axis", "range", "limited", "ref", "stiffness"),
        *("springref", "springdamper", "damping", "armature", "frictionloss"),
        *("actuatorfrcrange", "actuatorfrclimited"),
        *_LIMITS,
    ),
    "fixed": (
        *("name", "class", "range", "limited", "stiffness", "springlength", "damping"),
        *("frictionloss", "armature", "actuatorfrcrange", "actuatorfrclimited"),
        *_LIMITS,
    ),
    "exclude": ("name", "body1", "body2"),
    "position": (*_SERVO, "kp", "kv", "dampratio", "inheritrange"),
    "general": (*_SERVO, "gaintype", "biastype", "dyntype", "gainprm", "biasprm", "dynprm"),
    "connect": (*_TIE, "body1", "body2", "anchor"),
    "weld": (*_TIE, "body1", "body2", "relpose", "anchor", "torquescale"),
}
ATTRIBUTES["tendon"] = ATTRIBUTES["fixed"]  # of a default class
ATTRIBUTES["equality"] = _TIE
ATTRIBUTES |= {name: () for name in ("asset", "worldbody", "contact", "actuator")}
"""Attributes that count, by element; those in ``WITHIN`` come first."""

WITHIN: dict[tuple[str, str], tuple[str, ...]] = {
    ("fixed", "joint"): ("joint", "coef"),
    ("equality", "joint"): (*_TIE, "joint1", "joint2", "polycoef"),
    ("equality", "tendon"): (*_TIE, "tendon1", "tendon2", "polycoef"),
    ("mujoco", "tendon"): (),
    ("mujoco", "equality"): (),
}
"""Attributes of elements whose name means different elements, by parent and element."""

_SCENERY = ("site", "camera", "light")
DROPPED = {
    "mujoco": ("option", "size", "visual", "statistic", "custom", "keyframe", "sensor"),
    "default": (
        *("site", "camera", "light", "pair", "motor", "velocity", "intvelocity", "damper"),
        *("cylinder", "muscle", "adhesion"),
    ),
    "asset": ("texture",),
    "material": ("layer",),
    "worldbody": _SCENERY,
    "body": _SCENERY,
    "frame": _SCENERY,
    "contact": ("pair",),
}
"""Elements that say nothing about shape and mechanics, by the element they stand in."""

_CONTACT = (
    *("friction", "condim", "priority", "solmix", "solref", "solimp", "margin", "gap"),
    *("fluidshape", "fluidcoef", "user"),
)
DROPPED_ATTRIBUTES: dict[str, tuple[str, ...]] = {
    "default": ("group",),  # of files for robosuite; MuJoCo knows no such attribute
    "compiler": (
        *("settotalmass", "exactmeshinertia", "discardvisual", "fusestatic", "usethread"),
        *("alignfree", "saveinertial", "texturedir", "convexhull", "conflict"),
    ),
    "mesh": ("normal", "texcoord", "smoothnormal", "material", "content_type", "octree"),
    "material": ("texture", "texrepeat", "texuniform", "emission", "metallic", "roughness"),
    "body": ("user", "sleep", "gravcomp"),
    "geom": _CONTACT,
    "joint": ("group", "user", "actuatorgravcomp"),
    "fixed": ("group", "user", "width", "rgba", "material"),
    "tendon": ("group", "user", "width", "rgba", "material"),
    "position": ("group", "user"),
    "general": ("group", "user"),
}
"""Attributes of the same kind, and those that the testbed sets, by element."""

_ELSEWHERE = "it would read another model; put its bodies into this file"
_NO_CODE = "it would run other code; take it out"
REASONS = {
    "include": "it stands where no element can be included; put it below <mujoco> or in a body",
    "plugin": _NO_CODE,
    "extension": _NO_CODE,
    "freejoint": "the arm carries the hand; take the free joint out",
    "spatial": "tendons are fixed ones here, sums of joint positions; write it as <fixed>",
    "motor": "motors are position servos here; write it as <position> with kp and kv",
    "velocity": "motors are position servos here; write it as <position> with kp and kv",
    "intvelocity": "motors are position servos here; write it as <position> with kp and kv",
    "deformable": "parts of a hand are rigid; give the shape as a mesh",
    "flexcomp": "parts of a hand are rigid; give the shape as a mesh",
    "composite": "parts of a hand are rigid; give the shape as a mesh",
    "replicate": "write the copies out",
    "attach": _ELSEWHERE,
    "model": _ELSEWHERE,
    "hfield": "shapes are sphere, capsule, ellipsoid, cylinder, box and mesh",
    "mocap": "the arm carries the hand; take mocap out",
    "builtin": "write the mesh to a file",
    "geom": "what is fixed to the arm belongs into a body; put it into the hand's first body",
    "joint": "write it into a body",
}
"""Why an element or attribute is refused, and what to do."""
