"""One contact of hand and object as it is perceived."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import graspq as gq


@dataclass(frozen=True)
class PadContact:
    """One pad's contact as the hand perceives it.

    Attributes:
        pad: name, such as ``thumb_distal``.
        contact: position, normal, ``g*``, ``tau*`` and taxels, in the object frame at the centre of
            mass.
        jacobian: motor speeds to the velocity of the contact point (first three rows [m/rad]) and
            the angular velocity of its link (last three), object axes (6, 7).
    """

    pad: str
    contact: gq.Contact
    jacobian: np.ndarray
