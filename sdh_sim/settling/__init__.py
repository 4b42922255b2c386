"""What a grasp does when the table lets go, predicted from the snapshot, quasi-statically."""

from sdh_sim.settling.load_ramp import CAP, Ramp, load_ramp
from sdh_sim.settling.process import Allowed, Process, Rubber, Settling, settle, weight_directions
from sdh_sim.settling.settled_grasp import Settled, settle_grasp

__all__ = [
    "CAP",
    "Allowed",
    "Process",
    "Ramp",
    "Rubber",
    "Settled",
    "Settling",
    "load_ramp",
    "settle",
    "settle_grasp",
    "weight_directions",
]
