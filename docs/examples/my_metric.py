"""Two metrics of one's own; docs/extending.md shows them at work."""

import numpy as np

from sdh_sim import PerceivedGrasp
from sdh_sim.robot.sdh2_constants import TAXEL_PITCH


def opposition(grasp: PerceivedGrasp) -> float:
    """How far the contacts' normals cancel: 1 when they add up to nothing, 0 when all agree."""
    if not grasp.contacts:
        return 0.0
    normals = np.array([pad.contact.normal for pad in grasp.contacts])
    return 1.0 - float(np.linalg.norm(normals.mean(axis=0)))


opposition.threshold = 0.5  # success is predicted above it; a metric need not have one


def contact_area(grasp: PerceivedGrasp) -> float:
    """Area of the taxels that feel something [cm²]."""
    snapshot = grasp.snapshot
    felt = np.count_nonzero(snapshot.proximal) + np.count_nonzero(snapshot.distal)
    return felt * (100.0 * TAXEL_PITCH) ** 2
