"""How fast held objects creep in the hand, and how much of it is friction.

    python -m experiments.creep [--grasps 10] [--object FOLDER]

After lift and hold nothing is moved for some seconds. MuJoCo's friction is regularised: a contact
that is loaded along its surface yields at a speed in proportion to the load and in inverse
proportion to ``impratio`` (``experiments.validation``, friction_creep). What fingers do is told
apart: the links that touch carry their contact points along, and the object moves past them.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.command_line import Parser, at_least, fail
from sdh_sim import poses
from sdh_sim.cell import Simulation, build_scene
from sdh_sim.cell.contacts import touching
from sdh_sim.cell.scene import HAND_GEOM, OBJECT_GEOM
from sdh_sim.cli.worker_pool import run_all
from sdh_sim.errors import NoFeasibleGrasp, SettingsError
from sdh_sim.objects import PAPER_ORDER, find_objects
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial
from sdh_sim.trial.outcome import moved_between
from sdh_sim.user_references import ObjectFolder

RATIOS = (100.0, 1000.0)  # impratio
SPAN = 5.0  # [s]
AT_LIMIT = 0.99  # of its torque limit: the motor yields


class Job(NamedTuple):
    """A grasp to watch."""

    object: str
    folder: ObjectFolder | None
    seed: int
    ratio: float


class Creep(NamedTuple):
    """How a held object moves on.

    Attributes:
        object, ratio: as in the job.
        speed: of its centre of mass in the hand [µm/s].
        turn: about it [mdeg/s].
        fingers: speed of the links at the contacts, in the hand [µm/s].
        at_limit: motors at their torque limit.
    """

    object: str
    ratio: float
    speed: float
    turn: float
    fingers: float
    at_limit: int


def watch(job: Job) -> Creep | None:
    """Lift and look on for a while; None where the grasp does not hold."""
    settings = TrialSettings(job.object, folder=job.folder)
    scene = build_scene(settings)
    scene.model.opt.impratio = job.ratio
    try:
        trial = Trial(settings, job.seed, scene=scene)
    except NoFeasibleGrasp:
        return None
    if trial.grasp_and_lift()[0] != "none":
        return None
    simulation = trial.simulation
    before, points = simulation.object_in_hand(), _contact_points(simulation)
    simulation.wait(SPAN)
    moved, turned = moved_between(before, simulation.object_in_hand(), scene.obj.com_m)
    carried = np.array([_in_hand(simulation, body, at) - start for body, at, start in points])
    torque = np.abs(simulation.data.actuator_force[scene.motors])
    return Creep(
        job.object,
        job.ratio,
        1e3 * moved / SPAN,
        1e3 * turned / SPAN,
        1e6 * float(np.linalg.norm(carried.mean(axis=0))) / SPAN,
        int((torque > AT_LIMIT * simulation.limits).sum()),
    )


def _contact_points(simulation: Simulation) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """Link, point in its frame and in the palm's (3,) [m], of every contact with the object."""
    scene, data = simulation.scene, simulation.data
    found = []
    for k in np.flatnonzero(touching(scene, data, OBJECT_GEOM, HAND_GEOM)):
        first, second = data.contact.geom[k]
        geom = first if scene.geom_group[first] == HAND_GEOM else second
        body = int(scene.model.geom_bodyid[geom])
        pose = poses.body_pose(data, body)
        local = poses.rotation_of(pose[3:]).T @ (data.contact.pos[k] - pose[:3])
        found.append((body, local, _in_hand(simulation, body, local)))
    return found


def _in_hand(simulation: Simulation, body: int, point: np.ndarray) -> np.ndarray:
    """A point of a link in the palm frame (3,) [m]."""
    palm = poses.body_pose(simulation.data, simulation.scene.palm)
    world = poses.transform(poses.body_pose(simulation.data, body), point)
    return poses.rotation_of(palm[3:]).T @ (world - palm[:3])


def main(argv: list[str] | None = None) -> None:
    """Print the table."""
    parser = Parser(__doc__)
    parser.add_argument("--grasps", type=int, default=10, help="grasps of each object [10]")
    parser.add_argument("--seed", type=int, default=1, help="first seed [1]")
    parser.add_argument("--object", action="append", default=[], help="folder of an object")
    args = parser.parse_args(argv)
    at_least(parser, args, grasps=1, seed=0)
    try:
        names, folders = find_objects([str(Path(path)) for path in args.object], {})
    except SettingsError as error:
        fail(str(error))
    jobs = [
        Job(name, folders.get(name), args.seed + k, ratio)
        for name in (*PAPER_ORDER, *names)
        for k in range(args.grasps)
        for ratio in RATIOS
    ]
    found = [creep for creep in run_all(watch, jobs, "grasps") if creep is not None]
    Console(width=120).print(table_of(found, args.seed))


def table_of(found: list[Creep], seed: int) -> Table:
    """A line for every object and impratio: medians, and the worst."""
    table = Table(title=f"held objects {SPAN:g} s after the hold, seeds from {seed}")
    heads = ("object", "impratio", "held", "creep µm/s, median (largest)", "turn m°/s",
             "fingers µm/s", "motors at their limit")  # fmt: skip
    for head in heads:
        table.add_column(head, justify="left" if head == heads[0] else "right")
    for name in dict.fromkeys(creep.object for creep in found):
        for ratio in RATIOS:
            part = [creep for creep in found if (creep.object, creep.ratio) == (name, ratio)]
            if not part:
                continue
            middle = {key: float(np.median([getattr(c, key) for c in part])) for key in
                      ("speed", "turn", "fingers", "at_limit")}  # fmt: skip
            table.add_row(
                name if ratio == RATIOS[0] else "",
                f"{ratio:g}",
                str(len(part)),
                f"{middle['speed']:.1f} ({max(c.speed for c in part):.1f})",
                f"{middle['turn']:.1f}",
                f"{middle['fingers']:.1f}",
                f"{middle['at_limit']:g}",
            )
    return table


if __name__ == "__main__":
    main()
