"""Which steps of a trial follow which, as its settings say."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sdh_sim.sensing import directions_of
from sdh_sim.settings import GRAVITY_DIRECTIONS
from sdh_sim.trial import load_test
from sdh_sim.trial.outcome import Motion, classify

if TYPE_CHECKING:
    from sdh_sim.trial.trial import Trial

NO_CONTACT = "no_contact"


def to_verdict(trial: Trial) -> str:
    """All that the settings ask for, from the grasp to the load test.

    Returns:
        how the trial failed, ``none`` where the grasp held.

    Raises:
        Diverged: the simulation did.
    """
    settings, row = trial.settings, trial.row
    loaded = settings.load_test != "none"
    trial.acquire()
    trial.snapshot()
    if settings.settle != "none":
        trial.settle()
    if not trial.touched:
        if loaded:
            row.q_sim, row.q_sim_capped = 0.0, False
        return NO_CONTACT
    if settings.support == "none":
        return weigh_all(trial, loaded)[0]
    if settings.lift_off:
        trial.lift_off()
    failure = classify(trial.lift())
    held = failure == "none"
    if held and settings.disturbance != "none":
        trial.disturb()
    if held and settings.load_test == "directions":
        trial.load_directions()
    if loaded:
        trial.load()
    return failure


def weigh_all(trial: Trial, loaded: bool) -> tuple[str, Motion]:
    """Weigh along every direction of the settings, and where asked load until it gives way.

    Returns:
        the first failure in the order of the directions (``none``: all hold), and the largest
        motion.

    Raises:
        Diverged: the simulation did.
    """
    moved, turned, factors = np.full((3, len(GRAVITY_DIRECTIONS)), np.nan)
    failure, fell = "none", False
    for direction in directions_of(trial.settings.gravity):
        at = GRAVITY_DIRECTIONS.index(direction)
        motion = trial.weigh(direction)
        moved[at], turned[at] = motion.displacement_mm, motion.rotation_deg
        fell |= motion.fell
        own = classify(motion)
        failure = own if failure == "none" else failure
        if loaded:
            factors[at] = trial.load(direction=direction).load
    row = trial.row
    row.direction_displacement_mm, row.direction_rotation_deg = moved, turned
    motion = Motion(float(np.nanmax(moved)), float(np.nanmax(turned)), fell)
    row.displacement_mm, row.rotation_deg = motion[:2]
    if loaded:
        row.direction_q_sim = factors
        row.q_sim = float(np.nanmin(factors))
        row.q_sim_capped = row.q_sim >= load_test.CAP
    return failure, motion
