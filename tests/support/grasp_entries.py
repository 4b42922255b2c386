"""Grasps for files: some by preshape, some by angles, everything optional there or not."""

from __future__ import annotations

import numpy as np

from sdh_sim.grasp_files import GraspEntry
from sdh_sim.robot.sdh2_constants import PRESHAPES


def entries(
    count: int, objects: tuple[str, ...] = ("box", "oval_bottle"), seed: int = 0
) -> list[GraspEntry]:
    """Grasps with values that need all their digits; every third is by angles."""
    rng = np.random.default_rng(seed)
    return [_entry(number, objects[number % len(objects)], rng) for number in range(count)]


def _entry(number: int, name: str, rng: np.random.Generator) -> GraspEntry:
    turn = rng.normal(size=4)
    pose = np.concatenate((rng.normal(0.0, 0.1, 3), turn / np.linalg.norm(turn)))
    yaw = None if number % 2 else float(rng.normal(0.0, 1e-5))
    confidence = float(rng.random())
    if number % 3 == 0:
        return GraspEntry(
            name,
            f"own {number}, „é“",
            pose,
            open=rng.uniform(0.0, 0.5, 7),
            closed=rng.uniform(0.5, 1.5, 7),
            object_yaw=yaw,
            confidence=confidence,
        )
    preshape = list(PRESHAPES)[number % len(PRESHAPES)]
    ratio = float(rng.random()) if number % 4 else None
    return GraspEntry(
        name, f"random {number}", pose, preshape, ratio, object_yaw=yaw, confidence=confidence
    )
