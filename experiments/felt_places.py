"""Where contacts act on the pads of real trials, and how far off the arrays put them.

For grasps at the moment of the snapshot: how far contacts lie from the taxel whose sphere of rubber
makes them, how much force acts beyond the border of the arrays, and how far the centre of pressure
is off if every force is read on the taxel of its sphere, and as the arrays read it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.command_line import Parser, at_least
from sdh_sim.campaign.paper_preset import PAPER_SETTINGS
from sdh_sim.cell.contacts import rubber_contacts, taxel_forces
from sdh_sim.cli.worker_pool import run_all
from sdh_sim.objects import PAPER_ORDER
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial

LEAST_FORCE = 0.5  # on a pad whose centre of pressure counts [N]


@dataclass(frozen=True)
class Felt:
    """The pads of one grasp.

    Attributes:
        offsets: of the contacts from the centre of their sphere's taxel (n,) [mm].
        forces: of the contacts (n,) [N].
        beyond: which of them act on no taxel (n,) bool.
        pads: per pad that bears ``LEAST_FORCE``, how far the centre of pressure is off [mm]: read
            on the spheres' taxels, read by the array, and read by the array against the force that
            acts on it alone; NaN where the array reads nothing (k, 3).
    """

    offsets: np.ndarray
    forces: np.ndarray
    beyond: np.ndarray
    pads: np.ndarray


def observe(job: tuple[str, int, Mapping[str, Any]]) -> Felt:
    """Grasp an object and look at its pads."""
    name, seed, conditions = job
    trial = Trial(TrialSettings(object=name, **conditions), seed)
    trial.acquire()
    scene, data = trial.scene, trial.simulation.data
    read = taxel_forces(scene, data)
    rubber = rubber_contacts(scene, data)
    spheres = scene.taxel[data.contact.geom[rubber.contact]].max(axis=1)
    pads = np.searchsorted(scene.hand.pad_offsets, spheres, side="right") - 1
    beyond = rubber.shares.sum(axis=1) == 0.0
    offsets, found = np.zeros(len(pads)), []
    for pad in np.unique(pads):
        here = np.flatnonzero(pads == pad)
        array, first = scene.hand.pads[pad].array, scene.hand.pad_offsets[pad]
        link = data.body(f"hand/{scene.hand.pads[pad].body}")
        local = (data.contact.pos[rubber.contact[here]] - link.xpos) @ link.xmat.reshape(3, 3)
        places = array.pitch * array.coordinates(local)
        own = array.pitch * _places(array.shape, spheres[here] - first)
        force = rubber.normal[here]
        offsets[here] = np.linalg.norm(places - own, axis=1)
        if force.sum() < LEAST_FORCE:
            continue
        true, on_array = force @ places / force.sum(), np.where(beyond[here], 0.0, force)
        taxels = read[first : first + array.live.size]
        errors = [np.linalg.norm(force @ own / force.sum() - true), np.nan, np.nan]
        if on_array.sum() > 0.0:
            centre = array.pitch * taxels @ _places(array.shape, np.arange(array.live.size))
            centre /= taxels.sum()
            errors[1] = np.linalg.norm(centre - true)
            errors[2] = np.linalg.norm(centre - on_array @ places / on_array.sum())
        found.append(1e3 * np.array(errors))
    return Felt(1e3 * offsets, rubber.normal, beyond, np.array(found).reshape(-1, 3))


def _places(shape: tuple[int, int], taxels: np.ndarray) -> np.ndarray:
    """Rows and columns (n, 2) of flat indices into an array."""
    return np.column_stack(np.unravel_index(taxels, shape)).astype(float)


def main(argv: list[str] | None = None) -> None:
    """Print the numbers."""
    parser = Parser(__doc__)
    parser.add_argument("--grasps", type=int, default=120, help="grasps, all objects [120]")
    parser.add_argument("--seed", type=int, default=3000, help="first seed [3000]")
    parser.add_argument(
        "--precision", action="store_true", help="fingertip grasps, as in the paper"
    )
    args = parser.parse_args(argv)
    at_least(parser, args, grasps=1, seed=0)
    conditions = PAPER_SETTINGS if args.precision else {}
    jobs = [(PAPER_ORDER[k % 4], args.seed + k // 4, conditions) for k in range(args.grasps)]
    seen = run_all(observe, jobs, "grasps")
    offsets, forces, beyond = (
        np.concatenate([getattr(felt, name) for felt in seen])
        for name in ("offsets", "forces", "beyond")
    )
    pads = np.concatenate([felt.pads for felt in seen])
    if not len(pads):
        print("no pad bears anything")
        return
    silent = np.isnan(pads[:, 1])
    print(f"{len(seen)} grasps, {len(pads)} pads with at least {LEAST_FORCE:g} N")
    print(f"contacts off the centre of their sphere's taxel: {_spread(offsets)}")
    print(f"force that acts on no taxel: {100 * forces[beyond].sum() / forces.sum():.0f} %")
    print(f"pads that read nothing: {silent.sum()}")
    print("centre of pressure off")
    print(f"  read on the taxel of each sphere: {_spread(pads[:, 0])}")
    print(f"  the same, pads that read something: {_spread(pads[~silent, 0])}")
    print(f"  read by the arrays: {_spread(pads[~silent, 1])}")
    print(f"  read by the arrays, against what acts on them: {_spread(pads[~silent, 2])}")


def _spread(values: np.ndarray) -> str:
    if not len(values):
        return "none"
    return f"median {np.median(values):.2f} mm, 90 % below {np.quantile(values, 0.9):.2f} mm"


if __name__ == "__main__":
    main()
