"""Files of grasps: tables (Parquet, CSV, JSON) and isaac_grasp YAML, read and written.

Nothing is simulated here; ``grasping`` makes a plan of an entry.
"""

from sdh_sim.grasp_files.files import (
    ENDINGS,
    MAX_BYTES,
    MAX_GRASPS,
    check_ending,
    find_grasp_set,
    read_grasp_set,
    read_grasps,
    write_grasps,
)
from sdh_sim.grasp_files.grasp_entry import GraspEntry

__all__ = [
    "ENDINGS",
    "MAX_BYTES",
    "MAX_GRASPS",
    "GraspEntry",
    "check_ending",
    "find_grasp_set",
    "read_grasp_set",
    "read_grasps",
    "write_grasps",
]
