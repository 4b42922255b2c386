"""Random grasps: pose of the hand, preshape, and the error of its position."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from sdh_sim.grasping.fingertips import fingertip_reach
from sdh_sim.grasping.grasp_plan import OBJECT_POSITION, GraspPlan
from sdh_sim.objects import DEFAULT_SPREAD, ObjectInfo, Spread
from sdh_sim.robot import Hand

# Spread of the random grasps. It was set by looking at simulated success alone (30 to 70 % for
# each object at the paper's torques), never at a metric.
AZIMUTH = math.radians(50)  # approach from the side: yaw off the arm's forward direction
SIDE_TILT = math.radians(15)  # downward tilt of a side approach, at most
ROLL = math.radians(12)  # standard deviation of the roll about the approach
SIDE_MARGIN = (0.055, 0.025)  # lowest grasp over the table, highest below the top [m]
TOP_DEPTH = (0.015, 0.07)  # depth of the grasp centre below the object's top [m]
TOP_ROOM = 0.010  # from there to the table, at least, on objects that allow it [m]
# Low objects: the fingertips stay this far above the table, and the grasp centre this far above
# them [m].
TIP_CLEARANCE, LEAST_HOLD = 0.004, 0.010
# Pads reach this far past an object's near face at most; deeper, the proximal links would bear on
# its edges.
REACH_IN = 0.040

# By object: an error with which half of the grasps on a bottle fail makes nearly all fail on the
# heavy box.
SPREADS = {
    "box": Spread(0.5, 0.6, 0.004, math.radians(6)),
    "oval_bottle": Spread(0.6, 0.25, 0.010, math.radians(20)),
    "spray_bottle": Spread(0.8, 0.25, 0.014, math.radians(25)),
    "cylindrical_bottle": Spread(0.85, 0.0, 0.022, math.radians(180)),
}
# Fingertip grasps fail more readily: smaller errors keep about half of them stable.
PRECISION_SPREADS = {
    "box": Spread(0.5, 0.6, 0.003, math.radians(6)),
    "oval_bottle": Spread(0.6, 0.1, 0.002, math.radians(6)),
    "spray_bottle": Spread(0.8, 0.25, 0.005, math.radians(15)),
    "cylindrical_bottle": Spread(0.85, 0.0, 0.015, math.radians(180)),
}
DEFAULT_PRECISION_SPREAD = Spread(0.6, 0.25, 0.004, math.radians(10))


@dataclass(frozen=True)
class RandomGrasp:
    """How a random grasp was drawn.

    Attributes:
        approach: ``side`` or ``top``.
        preshape: name of one of the hand's closings.
        azimuth: yaw of the approach direction (side) or of the palm's x axis (top) [rad].
        roll: of the hand about its approach axis [rad].
        tilt: of the approach below the horizontal (side) or off the vertical (top) [rad].
        height: of the grasp centre over the table [m].
        depth: from the palm frame to the object's axis (side) or the grasp centre (top) along the
            palm's z [m].
        offset: position error of the hand in palm axes (3,) [m].
        object_yaw: of the object about the vertical [rad].
    """

    approach: str
    preshape: str
    azimuth: float
    roll: float
    tilt: float
    height: float
    depth: float
    offset: np.ndarray
    object_yaw: float

    def palm_rotation(self) -> np.ndarray:
        """Rotation of the palm in the world (3, 3)."""
        ca, sa = math.cos(self.azimuth), math.sin(self.azimuth)
        ct, st = math.cos(self.tilt), math.sin(self.tilt)
        if self.approach == "side":
            z = np.array([ca * ct, sa * ct, -st])
            x = np.array([-sa, ca, 0.0])
        else:
            z = np.array([sa * st, -ca * st, -ct])
            x = np.array([ca, sa, 0.0])
        y = np.cross(z, x)
        cr, sr = math.cos(self.roll), math.sin(self.roll)
        return np.column_stack((cr * x + sr * y, cr * y - sr * x, z))

    def palm_position(self, hand: Hand) -> np.ndarray:
        """Position of the palm of a hand in the world when it closes (3,) [m]."""
        centre = np.array([hand.reaches[self.preshape].centre, 0.0, self.depth])
        target = np.array([*OBJECT_POSITION, self.height])
        return target - self.palm_rotation() @ (centre - self.offset)

    def plan(self, hand: Hand) -> GraspPlan:
        """The grasp of a hand in the world."""
        return GraspPlan(
            self.palm_position(hand),
            self.palm_rotation(),
            self.object_yaw,
            hand.closing(self.preshape),
            drawn=self,
        )


def sample_grasp(
    hand: Hand, obj: ObjectInfo, rng: np.random.Generator, style: str = "any"
) -> RandomGrasp:
    """Draw one grasp; ``motion_plan`` finds out whether the arm can reach it.

    Args:
        hand: the hand.
        obj: the object.
        rng: of all that is random in it.
        style: ``any``, or ``precision`` for fingertip grasps.
    """
    precision = style == "precision"
    named, other = SPREADS, DEFAULT_SPREAD
    if precision:
        named, other = PRECISION_SPREADS, DEFAULT_PRECISION_SPREAD
    spread = obj.spread or named.get(obj.name, other)
    # From the side the hand needs room below and object above: a low object is taken from above.
    side = bool(rng.random() < spread.side) and obj.height >= sum(SIDE_MARGIN)
    wide = bool(rng.random() < spread.wide)
    preshapes = [
        name for name, r in hand.reaches.items() if not precision or r.precision_depth is not None
    ]
    preshape = preshapes[int(rng.integers(len(preshapes)))]
    flip = math.pi * float(rng.integers(2))
    if side:
        azimuth = float(rng.uniform(-AZIMUTH, AZIMUTH))
        roll = flip + float(rng.normal(0.0, ROLL))
        tilt = float(rng.uniform(0.0, SIDE_TILT))
        height = float(rng.uniform(SIDE_MARGIN[0], obj.height - SIDE_MARGIN[1]))
    else:
        azimuth = float(rng.uniform(-math.pi, math.pi))
        roll = 0.0
        tilt = float(rng.normal(0.0, math.radians(4)))
        deepest = min(TOP_DEPTH[1], max(TOP_DEPTH[0], obj.height - TOP_ROOM))
        height = obj.height - float(rng.uniform(TOP_DEPTH[0], deepest))
    reach = hand.reaches[preshape]
    low, high = (reach.precision_depth if precision else None) or reach.depth
    if not side:
        half = obj.half_wide if wide else obj.half_narrow
        low, height = _above_table(hand, preshape, half, low, height)
        high = max(low, high)
    ahead = obj.half_narrow if wide else obj.half_wide
    setback = max(0.0, ahead - REACH_IN) if side else 0.0
    # The palm's x, along which the hand closes, is a quarter turn ahead of a side approach.
    closing = azimuth + math.pi / 2 if side else azimuth
    quarters = 2 * int(rng.integers(2)) + int(wide)
    facing = closing - obj.narrow_yaw + quarters * math.pi / 2
    return RandomGrasp(
        approach="side" if side else "top",
        preshape=preshape,
        azimuth=azimuth,
        roll=roll,
        tilt=tilt,
        height=height,
        depth=float(rng.uniform(low, high)) + setback,
        offset=rng.normal(0.0, spread.offset, 3),
        object_yaw=math.remainder(facing + float(rng.normal(0.0, spread.yaw)), 2 * math.pi),
    )


def _above_table(
    hand: Hand, preshape: str, half: float, depth: float, height: float
) -> tuple[float, float]:
    """Least depth and height of a grasp from above that keep the fingertips off the table.

    Args:
        hand: the hand.
        preshape: name of one of its closings.
        half: half of the object's width along which the hand closes [m].
        depth: from the palm to the grasp centre, at least [m].
        height: of the grasp centre over the table, as drawn [m].
    """
    reach = fingertip_reach(hand, preshape, round(half, 3)).lowest + TIP_CLEARANCE
    height = max(height, TIP_CLEARANCE + LEAST_HOLD)
    return max(depth, reach - height), height


def what_fits(hand: Hand, obj: ObjectInfo) -> str:
    """Which objects a hand can take, beside this one's size, for a message."""
    widest = 1e3 * max(fingertip_reach(hand, name, 0.0).widest for name in hand.reaches)
    return (
        f"it stands {1e3 * obj.height:.0f} mm high and is {2e3 * obj.half_narrow:.0f} x "
        f"{2e3 * obj.half_wide:.0f} mm wide; the hand takes from above what is higher "
        f"than {1e3 * TIP_CLEARANCE:.0f} mm, from the side what is at least "
        f"{1e3 * sum(SIDE_MARGIN):.0f} mm high, and closes across {widest:.0f} mm at most"
    )
