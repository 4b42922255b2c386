"""Random and degenerate grasps for the tests of graspq."""

from __future__ import annotations

import numpy as np

import graspq as gq
from graspq.contact import tangent_basis

KINDS = (
    "random",
    "soft",
    "antipodal",
    "one_sided",
    "frictionless",
    "planar",
    "duplicate",
    "single",
    "symmetric",
    "tiny",
    "patch",
    "coaxial",
    "square",
    "clustered",
    "idle",
)


def unit(rng):
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def on_circle(angle, mu, force, soft):
    """A contact on a circle of 5 cm about z, which points to its centre."""
    p = np.array([0.05 * np.cos(angle), 0.05 * np.sin(angle), 0])
    return gq.Contact(p, [-np.cos(angle), -np.sin(angle), 0], mu, force, soft)


def contacts(rng, kind):
    """Contacts of one grasp; the kind says in what way it is special."""
    mu = rng.choice([0.1, 0.5, 1.0])
    soft = rng.choice([0.0, 0.02]) if kind not in ("random", "frictionless") else 0.0
    count = int(rng.integers(1, 5))
    force = rng.choice([0.5, 1.0, 7.0])
    if kind == "single":
        return [gq.Contact(unit(rng), unit(rng), mu, force, soft)]
    if kind == "antipodal":
        return [
            gq.Contact(s * np.array([0.05, 0, 0]), [-s, 0, 0], mu, force, soft) for s in (1.0, -1.0)
        ]
    if kind == "one_sided":
        return [
            gq.Contact([*(0.1 * rng.normal(size=2)), 0], [0, 0, 1.0], mu, force, soft)
            for _ in range(count)
        ]
    if kind == "planar":
        angle = rng.uniform(0, 2 * np.pi, count + 1)
        return [on_circle(a, mu, force, soft) for a in angle]
    if kind == "symmetric":
        angle = 2 * np.pi * np.arange(3) / 3
        return [on_circle(a, mu, force, soft) for a in angle]
    if kind == "coaxial":
        n = unit(rng)
        mu = rng.choice([0.0, mu])
        return [
            gq.Contact(0.05 * t * n, -np.sign(t) * n, mu, force, soft)
            for t in rng.normal(size=int(rng.integers(2, 5)))
        ]
    if kind == "square":
        mu, levels = rng.choice([0.0, mu]), rng.choice([0.0, 0.02])
        made = [
            gq.Contact(
                [0.05 * np.cos(a), 0.05 * np.sin(a), z],
                [-np.cos(a), -np.sin(a), 0],
                mu,
                force,
                soft,
            )
            for a in np.pi / 2 * np.arange(4)
            for z in {-levels, levels}
        ]
        return made[: int(rng.integers(3, 6))]
    if kind == "clustered":
        n, p, near = unit(rng), 0.1 * rng.normal(size=3), 10.0 ** rng.integers(-5, -1)
        turned = [n + near * rng.normal(size=3) for _ in range(3)]
        return [
            gq.Contact(
                p + near * rng.normal(size=3),
                rng.choice([-1, 1]) * m / np.linalg.norm(m),
                mu,
                force,
                soft,
            )
            for m in turned
        ]
    if kind == "idle":
        made = contacts(rng, "soft")[:2]
        return [*made, gq.Contact(rng.normal(size=3), unit(rng), mu, 0.0, 0.0)]
    size = 1e-3 if kind == "tiny" else 0.1
    if kind == "frictionless":
        mu, count = 0.0, int(rng.integers(1, 9))
    if kind == "soft":
        soft, count = 0.03, 3
    if kind == "random":
        count = 3
    made = []
    for _ in range(count):
        n, p = unit(rng), size * rng.normal(size=3)
        patch = None
        if kind == "patch":
            a, b = tangent_basis(n)
            patch = p + 0.003 * (rng.normal(size=(5, 1)) * a + rng.normal(size=(5, 1)) * b)
        made.append(gq.Contact(p, n, mu, force, soft, patch))
    return made + made[:1] if kind == "duplicate" else made


def grasp(rng, kind, edges=None):
    """Wrench sets of one grasp of the given kind."""
    edges = int(rng.choice([4, 6, 12])) if edges is None else edges
    augment = str(rng.choice(["none", "fl", "hf", "sf"])) if kind == "patch" else "none"
    return [gq.contact_wrenches(c, edges, augment) for c in contacts(rng, kind)]


def tasks(rng, wrenches):
    """A task set: generic, made of few columns, along an axis, or gravity."""
    kind = rng.integers(5)
    columns = np.hstack(wrenches)
    if kind == 0:
        scale = np.array([1, 1, 1, 0.1, 0.1, 0.1])
        return scale[:, None] * rng.normal(size=(6, int(rng.integers(1, 4))))
    if kind == 1:
        picked = columns[:, rng.integers(columns.shape[1], size=int(rng.integers(1, 7)))]
        return picked @ rng.uniform(size=(picked.shape[1], 1))
    if kind == 2:
        t = np.zeros((6, 1))
        t[rng.integers(6)] = rng.choice([-1.0, 1.0])
        return t
    if kind == 3:
        return gq.gravity_tasks(0.3, 0.02 * rng.normal(size=3), [0, 0, -9.81], samples=8)
    return columns @ rng.normal(size=(columns.shape[1], 2))
