"""The tactile arrays, the snapshot of the hand, and what it tells of the contacts."""

from sdh_sim.sensing.pad_contact import PadContact
from sdh_sim.sensing.pad_contacts import pad_contacts
from sdh_sim.sensing.perceived_grasp import PerceivedGrasp, perceive
from sdh_sim.sensing.snapshot import TactileSnapshot
from sdh_sim.sensing.tactile_frames import TactileFrames, take_snapshot
from sdh_sim.sensing.tactile_sensor import SensorModel, TactileSensor
from sdh_sim.sensing.touched_pose import touched_pose
from sdh_sim.sensing.tracking_error import TrackingErrors, add_tracking_error
from sdh_sim.sensing.unsensed_contacts import unsensed_contacts
from sdh_sim.sensing.weight_directions import GRAVITY, directions_of, unit_vector

__all__ = [
    "GRAVITY",
    "PadContact",
    "PerceivedGrasp",
    "SensorModel",
    "TactileFrames",
    "TactileSensor",
    "TactileSnapshot",
    "TrackingErrors",
    "add_tracking_error",
    "directions_of",
    "pad_contacts",
    "perceive",
    "take_snapshot",
    "touched_pose",
    "unit_vector",
    "unsensed_contacts",
]
