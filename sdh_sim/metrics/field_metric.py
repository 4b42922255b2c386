"""What describes a metric of the literature, so that tables, pages and tests can speak of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from sdh_sim.sensing import PerceivedGrasp

FAMILIES = (
    "task",  # q* and relatives: against the weight of the object
    "wrench space",  # of the contacts' wrenches alone
    "grasp map",  # singular values of G
    "contact geometry",  # places and normals of the contacts
    "posture",  # joint angles and hand Jacobian
    "compliance",  # stiffness of pads and servos
    "synthesis",  # losses that grasp generators minimise
    "probability",  # over errors of perception
)


@dataclass(frozen=True)
class FieldMetric:
    """A grasp metric with what its readers have to know.

    Attributes:
        name: on the command line and in tables, lower case with underscores.
        label: in pictures and tables.
        family: one of ``FAMILIES``.
        function: of a perceived grasp with at least one contact; NaN, or ``graspq.GraspError``,
            where it cannot be computed.
        unit: of its values; empty: none.
        source: of the definition.
        conventions: choices that its values depend on, in a sentence or two.
        blind_to: what it cannot see.
        high_is_good: whether a larger value is a better grasp.
        threshold: the value beyond which it predicts success; None: it states none.
        without_contact: value of a grasp that no pad feels; None: beyond all others.
    """

    name: str
    label: str
    family: str
    function: Callable[[PerceivedGrasp], float]
    unit: str
    source: str
    conventions: str
    blind_to: str
    high_is_good: bool = True
    threshold: float | None = None
    without_contact: float | None = None

    @property
    def worst(self) -> float:
        """The value of a grasp that no pad feels."""
        if self.without_contact is not None:
            return self.without_contact
        return -math.inf if self.high_is_good else math.inf
