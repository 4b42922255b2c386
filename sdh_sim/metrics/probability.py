"""Probabilities over errors of perception: of bearing the task, of force closure; and robust ε.

The tracked pose, the friction and the mass are what they are known to be off by: copies of the
grasp with other errors of the same size are what might be true instead. Readings, joint angles and
torques stay, so that the same pads touch in every copy, elsewhere on the object.

Weisz, Allen: Pose error robust grasping from contact wrench space metrics, ICRA 2012; Mahler et
al.: Dex-Net 2.0, RSS 2017.
"""

from __future__ import annotations

from dataclasses import astuple
from typing import NamedTuple

import numpy as np

import graspq as gq
from graspq.errors import as_number
from sdh_sim.metrics.built_in import AUGMENT, EDGES
from sdh_sim.metrics.field_metric import FieldMetric
from sdh_sim.metrics.hand_springs import kinematics_of
from sdh_sim.sensing import PerceivedGrasp, TrackingErrors, add_tracking_error, pad_contacts
from sdh_sim.sensing.perceived_grasp import gravity_task

ERRORS = TrackingErrors(position_error=2e-3, angle_error=0.02, friction_error=0.05, mass_error=0.05)
"""What the metrics take the tracker and the scale to be off by; as the noise of ``--repeats``."""
SAMPLES, SEED = 64, 0
CLOSED = 1e-9  # ε from which on a grasp counts as closed


class Probabilities(NamedTuple):
    """What copies of a grasp with errors say.

    Attributes:
        task: share of the copies with q* > 1, L∞.
        closure: share of the copies that are force closed.
        epsilon: mean ε of the copies, L1, 0 where not closed.
        median_q: median q* of the copies, L∞.
    """

    task: float
    closure: float
    epsilon: float
    median_q: float


def probabilities(
    grasp: PerceivedGrasp,
    errors: TrackingErrors = ERRORS,
    samples: int = SAMPLES,
    seed: int = SEED,
) -> Probabilities:
    """Evaluate copies of a grasp with errors of perception.

    A share has a standard error of √(p (1 - p) / samples), 0.06 at most with 64.

    Args:
        grasp: with its hand known (``perceive`` fills it) and at least one contact.
        errors: standard deviations of the errors of its pose, friction and mass.
        samples: number of copies.
        seed: of their errors: the same grasp has the same copies.

    Raises:
        graspq.GraspError: no contact, no hand, no sample, or errors that are not finite and >= 0.
    """
    if not grasp.contacts:
        raise gq.GraspError("contacts: got none; give a grasp with at least one contact")
    if isinstance(samples, bool) or not isinstance(samples, int | np.integer) or samples < 1:
        raise gq.GraspError(f"samples: expected an integer >= 1, got {samples!r}")
    for name, value in zip(errors.__dataclass_fields__, astuple(errors), strict=True):
        as_number(name, value)
    sets, tasks = _copies(grasp, errors, int(samples), seed)
    q = gq.task_scaling_batch(sets, tasks, workers=1).value
    epsilon = gq.epsilon_batch(sets, bound="l1", workers=1)
    return Probabilities(
        task=float((q > 1.0).mean()),
        closure=float((epsilon > CLOSED).mean()),
        epsilon=float(np.where(epsilon > CLOSED, epsilon, 0.0).mean()),
        median_q=float(np.median(q)),
    )


def _copies(
    grasp: PerceivedGrasp, errors: TrackingErrors, samples: int, seed: int
) -> tuple[list[list[np.ndarray]], list[np.ndarray]]:
    """Wrench sets (6, l) of every contact, and the task (6, m), of every copy."""
    kinematics = kinematics_of(grasp)
    limits = kinematics.hand.group_limits(grasp.torque_limits)
    rng = np.random.default_rng(seed)
    sets, tasks = [], []
    for _ in range(samples):
        seen, known = add_tracking_error(grasp.snapshot, grasp.obj, errors, rng)
        contacts = pad_contacts(
            seen, known, limits, grasp.pads, kinematics, threshold=grasp.threshold
        )
        sets.append(
            [gq.contact_wrenches(pad.contact, edges=EDGES, augment=AUGMENT) for pad in contacts]
        )
        tasks.append(gravity_task(seen, known))
    return sets, tasks


class _Last:
    """The grasp looked at last and its probabilities, which three metrics share."""

    grasp: PerceivedGrasp | None = None
    found: Probabilities | None = None


def _of(grasp: PerceivedGrasp) -> Probabilities:
    if _Last.found is None or _Last.grasp is not grasp:
        _Last.found = probabilities(grasp)
        _Last.grasp = grasp
    return _Last.found


def task_probability(grasp: PerceivedGrasp) -> float:
    """Share of copies with errors of perception that have q* > 1, L∞."""
    return _of(grasp).task


def closure_probability(grasp: PerceivedGrasp) -> float:
    """P_fc: share of copies with errors of perception that are force closed."""
    return _of(grasp).closure


def robust_epsilon(grasp: PerceivedGrasp) -> float:
    """Mean ε, L1, of copies with errors of perception; 1 N beside 1 N m."""
    return _of(grasp).epsilon


_COPIES = (
    f"{SAMPLES} copies, seed {SEED}; standard deviations {1e3 * ERRORS.position_error:g} mm along "
    f"and {ERRORS.angle_error:g} rad about each axis, {100 * ERRORS.friction_error:g} % of the "
    f"friction, {100 * ERRORS.mass_error:g} % of the mass, unless others are declared. Normals are "
    "looked up anew; the pads in contact stay the same."
)
_BLIND = "contacts that no pad feels; that another pose would have other pads in contact"

METRICS: tuple[FieldMetric, ...] = (
    FieldMetric(
        "task_probability",
        "P(q* > 1)",
        "probability",
        task_probability,
        "",
        "this project's own",
        f"q* of equation 9, 12 edges, hard fingers at the taxels. {_COPIES}",
        _BLIND,
        threshold=0.5,
    ),
    FieldMetric(
        "closure_probability",
        "P_fc",
        "probability",
        closure_probability,
        "",
        "Weisz and Allen 2012",
        f"ε above 0, 12 edges, hard fingers at the taxels. {_COPIES} The source varies pose alone.",
        f"the weight, torque limits but for their ratios; {_BLIND}",
    ),
    FieldMetric(
        "robust_epsilon",
        "robust ε",
        "probability",
        robust_epsilon,
        "N",
        "Mahler et al. 2017 (Dex-Net 2.0)",
        f"Mean ε, L1, 1 N beside 1 N m, moments about the centre of mass. {_COPIES} The source "
        "takes unit forces; here each contact has its own limit.",
        f"the weight; {_BLIND}",
    ),
)
"""Metrics over errors of perception, in the order of the documentation."""
