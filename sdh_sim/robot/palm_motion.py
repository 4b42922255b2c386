"""What carries the hand: where its six joints bring the palm, and how fast they may go."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import numpy as np

SPEED_SHARE = 0.9  # of the joint speed limits that a path may use


class PalmMotion(ABC):
    """Finds joint positions for poses of the palm.

    Attributes:
        standoff: length of the straight approach to a grasp [m].
        speed_limit: of the joints (6,) [rad/s or m/s].
    """

    standoff: float
    speed_limit: np.ndarray

    @abstractmethod
    def palm_pose(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Position (3,) [m] and rotation (3, 3) of the palm in the world at joint positions."""

    @abstractmethod
    def solve(
        self, position: np.ndarray, rotation: np.ndarray, start: np.ndarray, steps: int = 60
    ) -> np.ndarray | None:
        """Joint positions (6,) for a palm pose, from a start; None when it is not reached.

        Args:
            position: (3,) [m] in the world.
            rotation: (3, 3), columns are the palm's axes in the world.
            start: joint positions to start from (6,) [rad or m].
            steps: iterations, where there are any.
        """

    @abstractmethod
    def reach(self, position: np.ndarray, rotation: np.ndarray) -> np.ndarray | None:
        """Joint positions (6,) for a palm pose from anywhere; None when out of reach."""

    def straight(
        self, start: np.ndarray, motion: np.ndarray, spacing: float = 0.03
    ) -> np.ndarray | None:
        """Joint path (n, 6) that moves the palm along a straight line without turning it.

        Args:
            start: joint positions at the beginning (6,) [rad or m].
            motion: displacement of the palm in the world (3,) [m].
            spacing: distance between waypoints [m].

        Returns:
            Waypoints at equal distances along the line, or None when one is out of reach.
        """
        position, rotation = self.palm_pose(start)
        count = max(2, math.ceil(float(np.linalg.norm(motion)) / spacing) + 1)
        path = [np.asarray(start, dtype=float)]
        for share in np.linspace(0.0, 1.0, count)[1:]:
            found = self.solve(position + share * np.asarray(motion), rotation, path[-1], steps=20)
            if found is None or np.abs(found - path[-1]).max() > 0.5:
                return None
            path.append(found)
        return np.array(path)

    def duration(self, path: np.ndarray, at_least: float) -> float:
        """Time [s] for a minimum-jerk run along a path that keeps every joint speed limit."""
        # Greatest slope of the minimum-jerk profile is 15/8 of the mean speed.
        per_share = np.abs(np.diff(path, axis=0)).max(axis=0) * (len(path) - 1)
        needed = 1.875 * float((per_share / (SPEED_SHARE * self.speed_limit)).max())
        return max(at_least, needed)


def along(path: np.ndarray, share: float) -> np.ndarray:
    """Joint positions (6,) at a share 0..1 of a path's minimum-jerk course in time."""
    return at(path, minimum_jerk(share))


def minimum_jerk(share: float) -> float:
    """Share of a path that is behind, at a share of the time, without jerks at its ends."""
    s = min(max(share, 0.0), 1.0)
    return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)


def at(path: np.ndarray, share: float) -> np.ndarray:
    """Joint positions (6,) at a share 0..1 of a path."""
    course = share * (len(path) - 1)
    low = min(int(course), len(path) - 2)
    return path[low] + (course - low) * (path[low + 1] - path[low])
