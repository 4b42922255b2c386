"""The workcell as one MuJoCo model, and the simulation of it."""

from sdh_sim.cell.scene import ARM_GEOM, HAND_GEOM, OBJECT_GEOM, TABLE_GEOM, Scene
from sdh_sim.cell.scene_builder import build_scene, scene_of
from sdh_sim.cell.simulation import Observer, Simulation

__all__ = [
    "ARM_GEOM",
    "HAND_GEOM",
    "OBJECT_GEOM",
    "TABLE_GEOM",
    "Observer",
    "Scene",
    "Simulation",
    "build_scene",
    "scene_of",
]
