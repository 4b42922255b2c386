"""Files of grasps: tables (Parquet, CSV, JSON) and isaac_grasp YAML, read and written.

Nothing is simulated here; ``grasping`` makes a plan of an entry.
"""

from sdh_sim.grasp_files.files import (
    MAX_BYTES,
    MAX_GRASPS,
    find_grasp_set,
    read_grasp_set,
    read_grasps,
    write_grasps,
)
from sdh_sim.grasp_files.grasp_entry import GraspEntry

__all__ = [
    "MAX_BYTES",
    "MAX_GRASPS",
    "GraspEntry",
    "find_grasp_set",
    "read_grasp_set",
    "read_grasps",
    "write_grasps",
]
