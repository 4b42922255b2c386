"""From what ``lift`` was asked for to the plan of a run."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from sdh_sim.cli.lift_request import COPIES, SEED, TRIALS, LiftRequest
from sdh_sim.errors import GraspFileError, SettingsError
from sdh_sim.grasp_files import (
    ENDINGS,
    GraspEntry,
    find_grasp_set,
    read_grasp_set,
    read_grasps,
)
from sdh_sim.metrics import find_metrics
from sdh_sim.objects import find_objects, object_names
from sdh_sim.robot import find_hand, hand_in
from sdh_sim.runs import RunPlan
from sdh_sim.settings import DEFAULT_HAND, FROM_FILE, RANDOM_GRASPS, TrialSettings
from sdh_sim.user_references import GraspSet, HandFolder


def make_plan(request: LiftRequest, stored: RunPlan | None) -> RunPlan:
    """The plan of the request; what it leaves out is the stored plan's, or the default.

    Raises:
        SettingsError: no object, or what was asked for cannot be used.
    """
    before = {} if stored is None else stored.folders
    names, folders = find_objects(_asked_objects(request, stored), before)
    metrics = find_metrics(request.metric, () if stored is None else stored.settings.metrics)
    given = {"object": names[0], "metrics": metrics, **request.settings}
    if "hand" in given:
        given["hand"], given["hand_folder"] = _asked_hand(given["hand"], stored)
    grasp_set, entries = _grasp_set(request, stored, names)
    given["grasp_set"] = grasp_set
    if grasp_set is not None:
        given["grasps"] = FROM_FILE
    if stored is None:
        settings, seed = TrialSettings(**given), SEED
        trials = TRIALS if grasp_set is None else COPIES
    else:
        settings = dataclasses.replace(stored.settings, **given)
        trials, seed = stored.trials, stored.seed
    hand_in(settings).check(settings.torque_limit, settings.pads)
    if settings.grasp_set is not None and settings.hand != DEFAULT_HAND:
        raise GraspFileError(
            f"grasps: files have grasps of {DEFAULT_HAND}, the run has the hand {settings.hand}; "
            "from Python any hand takes them, as GraspPlan and Trial(settings, plan=...)"
        )
    return RunPlan(
        names,
        settings,
        trials if request.trials is None else request.trials,
        seed if request.seed is None else request.seed,
        folders,
        _counts(names, entries) if grasp_set is not None else {},
    )


def _asked_hand(word: str, stored: RunPlan | None) -> tuple[str, HandFolder | None]:
    """The hand asked for; the name of the stored plan's own hand means that one."""
    if stored is not None and word == stored.settings.hand:
        return word, stored.settings.hand_folder
    return find_hand(word)


def grasp_file(request: LiftRequest) -> str | None:
    """The path given as ``--grasps``, None where there is none: it is no kind of random grasp.

    Raises:
        SettingsError: neither of the two.
    """
    word = request.settings.get("grasps")
    if word is None or word in RANDOM_GRASPS:
        return None
    if Path(word).suffix.lower() not in ENDINGS:
        raise SettingsError(
            f"grasps: got {word!r:.200}; choose {' or '.join(RANDOM_GRASPS)}, or give a file of "
            f"grasps, which ends in {', '.join(ENDINGS)}"
        )
    return word


def _asked_objects(request: LiftRequest, stored: RunPlan | None) -> Sequence[str]:
    if request.object:
        return request.object
    if stored is not None:
        return stored.objects
    path = grasp_file(request)
    if path is None:
        raise SettingsError(
            f"object: missing; give one of {', '.join(object_names())}, or all, or the path of a "
            "folder with an object of your own"
        )
    return tuple(dict.fromkeys(entry.object for entry in read_grasps(path)))


def _grasp_set(
    request: LiftRequest, stored: RunPlan | None, names: Sequence[str]
) -> tuple[GraspSet | None, list[GraspEntry]]:
    """The file of grasps that was asked for, or the stored plan's, and what is in it."""
    path = grasp_file(request)
    if path is not None:
        return find_grasp_set(path, names)
    if "grasps" in request.settings or stored is None or stored.settings.grasp_set is None:
        return None, []
    reference = stored.settings.grasp_set
    return reference, read_grasp_set(reference, names)


def _counts(names: Sequence[str], entries: Sequence[GraspEntry]) -> dict[str, int]:
    """Number of grasps of each object; raises GraspFileError where one has none."""
    found = Counter(entry.object for entry in entries)
    if none := [name for name in names if not found[name]]:
        raise GraspFileError(
            f"grasps: the file has none of {', '.join(none)}; leave that object out, or add grasps"
        )
    return {name: found[name] for name in names}
