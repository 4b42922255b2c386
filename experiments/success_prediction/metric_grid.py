"""Every metric under other assumptions, evaluated again on stored snapshots."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import graspq as gq
from sdh_sim.metrics import grasp_of, hand_bound, wrench_sets
from sdh_sim.sensing import PerceivedGrasp
from sdh_sim.user_references import ObjectFolder

PADS = ("distal", "all")
BOUNDS = ("linf", "l1")
HAND_KINDS = ("capability", "held", "whole")
AUGMENTATIONS = ("none", "fl", "hf", "sf")
# The space of five contacts takes ten seconds, that of four one.
MOST_VOLUME_CONTACTS = 4

MapRows = Callable[[Callable[[Any], Any], Sequence[Any]], list[Any]]


@dataclass(frozen=True)
class Variant:
    """A metric and what it assumes.

    Attributes:
        kind: ``q``, ``epsilon``, ``volume``, ``capability``, ``held`` or ``whole``: capability of
            all that touches.
        bound: ``linf`` or ``l1``; empty for the hand's own bounds.
        edges: of the friction cone; None is the exact ellipsoid.
        augment: ``none``, ``fl``, ``hf`` or ``sf``; empty for the hand's own bounds.
        unloading: contacts may press with less than their limit; False takes equations (9), (10)
            to the letter.
        pads: ``distal`` or ``all``.
    """

    kind: str
    bound: str = ""
    edges: int | None = 12
    augment: str = ""
    unloading: bool = True
    pads: str = "distal"

    @property
    def key(self) -> str:
        """A name for a column."""
        parts = [self.kind, self.bound, self.augment]
        parts += ["exact" if self.edges is None else f"{self.edges}edges"]
        parts += ["" if self.unloading else "literal", self.pads]
        return "_".join(part for part in parts if part)

    @property
    def group(self) -> str:
        """The metric, without what it assumes."""
        bound = {"linf": " L∞", "l1": " L1", "": ""}[self.bound]
        sign = {"epsilon": "ε", "volume": "V"}.get(self.kind, "q*")
        return f"{sign}{bound or ' ' + self.kind + (' hand' if self.kind == 'whole' else '')}"

    @property
    def assumes(self) -> str:
        """The assumptions in short, without the pads."""
        cone = "exact cone" if self.edges is None else f"{self.edges} edges"
        parts = [cone, self.augment or "every taxel"]
        return ", ".join(parts + ([] if self.unloading else ["literal"]))

    @property
    def has_boundary(self) -> bool:
        """Whether 1 is a natural decision boundary."""
        return self.kind in ("q", *HAND_KINDS)


REPORTED = {
    "q_linf": Variant("q", "linf", augment="hf"),
    "q_l1": Variant("q", "l1", augment="hf"),
    "q_capability": Variant("capability"),
    "q_held": Variant("held"),
    "q_whole_hand": Variant("whole"),
}
"""Task scalings that the figures show, by their column in the table of trials."""


def grid(full: bool = False) -> list[Variant]:
    """The variants: one assumption changed at a time from the paper's, or all of them crossed.

    Not crossed are V, whose facets can be added up for the contact centres alone, and the exact
    cone's ε with a force at every taxel, which takes seconds a grasp.
    """
    found: list[Variant] = []
    for bound in BOUNDS:
        paper = Variant("q", bound, 12, "hf")
        if full:
            found += [
                replace(paper, augment=augment, edges=edges, unloading=unloading)
                for augment, edges, unloading in itertools.product(
                    AUGMENTATIONS, (12, None), (True, False)
                )
            ]
        else:
            found += [
                paper,
                replace(paper, edges=None),
                *(replace(paper, augment=augment) for augment in ("none", "fl", "sf")),
                replace(paper, unloading=False),
            ]
    found += [Variant(kind, edges=edges) for kind in HAND_KINDS for edges in (12, None)]
    for bound in BOUNDS:
        paper = Variant("epsilon", bound, 12, "hf")
        centre = replace(paper, augment="none")
        found += [paper, centre, replace(centre, edges=None)]
        if full:
            found += [replace(paper, augment=augment) for augment in ("fl", "sf")]
    found += [Variant("volume", bound, 12, "none") for bound in BOUNDS]
    return [replace(variant, pads=pads) for pads in PADS for variant in found]


def evaluate(variant: Variant, grasp: PerceivedGrasp) -> float:
    """Value of a variant; NaN where it cannot be computed, 0 for a grasp without contacts."""
    whole = variant.kind == "whole"
    if not grasp.contacts and not (whole and grasp.others):
        return 0.0
    try:
        if variant.kind in HAND_KINDS:
            hand = hand_bound(grasp, variant.kind == "held", whole)
            return float(gq.hand_task_scaling(hand, grasp.task, edges=variant.edges).value)
        if variant.kind == "volume" and len(grasp.contacts) > MOST_VOLUME_CONTACTS:
            return math.nan
        sets = wrench_sets(grasp, variant.edges, variant.augment)
        options = {"bound": variant.bound, "unloading": variant.unloading}
        if variant.kind == "q":
            return float(gq.task_scaling(sets, grasp.task, **options).value)
        measure = gq.epsilon if variant.kind == "epsilon" else gq.volume
        return float(measure(sets, **options))
    except gq.GraspError:  # such as a wrench space too close to flat for its volume
        return math.nan


def evaluate_row(
    job: tuple[Mapping[str, Any], Sequence[Variant], Mapping[str, ObjectFolder]],
) -> list[float]:
    """Values of the variants for one row; NaN where the trial ended before its snapshot."""
    row, variants, folders = job
    found: dict[Variant, float] = {}
    grasps = {pads: grasp_of(row, pads, folders=folders) for pads in PADS}
    # Where the proximal pads feel nothing, all pads see what the distal ones see.
    same = len({len(grasp.contacts) for grasp in grasps.values() if grasp is not None}) == 1
    for variant in variants:
        grasp = grasps[variant.pads]
        twin = found.get(replace(variant, pads=PADS[0])) if same else None
        if grasp is None:
            found[variant] = math.nan
        else:
            found[variant] = evaluate(variant, grasp) if twin is None else twin
    return [found[variant] for variant in variants]


def evaluate_all(
    rows: Sequence[Mapping[str, Any]],
    variants: Sequence[Variant],
    run: MapRows,
    folders: Mapping[str, ObjectFolder] | None = None,
) -> dict[Variant, np.ndarray]:
    """Values (n,) of every variant.

    Args:
        rows: as ``sdh_sim.metrics.stored_grasps.read_stored`` gives them.
        variants: what to evaluate.
        run: applies a function to every job, in order; may do so in several processes.
        folders: of users' objects, by name.

    Raises:
        SettingsError: an object that is neither built in nor among the folders.
    """
    jobs = [(row, variants, folders or {}) for row in rows]
    values = np.array(run(evaluate_row, jobs), dtype=float)
    return {variant: values[:, k] for k, variant in enumerate(variants)}
