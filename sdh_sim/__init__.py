"""Tactile grasp-and-lift trials of the Schunk SDH-2 hand in MuJoCo.

The names below are the library: each is imported from its module when it is first used, so that
``import sdh_sim`` brings neither MuJoCo nor a table.
"""

import importlib
from typing import TYPE_CHECKING, Any

from sdh_sim import graphics
from sdh_sim._version import __version__ as __version__

if TYPE_CHECKING:
    from sdh_sim.campaign import RunResult, run_campaign
    from sdh_sim.cli.field_comparison import leaderboard
    from sdh_sim.errors import CampaignError, RecordError, RunError, SettingsError
    from sdh_sim.grasp_files import GraspEntry, read_grasps, write_grasps
    from sdh_sim.grasping import GraspPlan, plan_of
    from sdh_sim.metrics import (
        METRICS,
        Prediction,
        evaluate,
        find_metrics,
        grasp_of,
        object_of,
        predict,
        snapshot_of,
    )
    from sdh_sim.model_files import models_dir
    from sdh_sim.objects import ObjectInfo, object_info, object_names, user_object
    from sdh_sim.records import COLUMNS, TrialRow, read_rows, read_table, stack
    from sdh_sim.robot import HandKinematics, closing_between, preshape_closing
    from sdh_sim.runs import RunFolder, RunPlan
    from sdh_sim.sensing import PadContact, PerceivedGrasp, TactileSnapshot, perceive
    from sdh_sim.settings import TrialSettings
    from sdh_sim.trial import Trial, TrialResult, run_trial
    from sdh_sim.viewing.recording import write_recording
    from sdh_sim.viewing.render import render_trial

__all__ = [
    "COLUMNS",
    "METRICS",
    "CampaignError",
    "GraspEntry",
    "GraspPlan",
    "HandKinematics",
    "ObjectInfo",
    "PadContact",
    "PerceivedGrasp",
    "Prediction",
    "RecordError",
    "RunError",
    "RunFolder",
    "RunPlan",
    "RunResult",
    "SettingsError",
    "TactileSnapshot",
    "Trial",
    "TrialResult",
    "TrialRow",
    "TrialSettings",
    "closing_between",
    "evaluate",
    "find_metrics",
    "grasp_of",
    "leaderboard",
    "models_dir",
    "object_info",
    "object_names",
    "object_of",
    "perceive",
    "plan_of",
    "predict",
    "preshape_closing",
    "read_grasps",
    "read_rows",
    "read_table",
    "render_trial",
    "run_campaign",
    "run_trial",
    "snapshot_of",
    "stack",
    "user_object",
    "write_grasps",
    "write_recording",
]

_MODULES = {
    "cli.field_comparison": ("leaderboard",),
    "campaign": ("RunResult", "run_campaign"),
    "errors": ("CampaignError", "RecordError", "RunError", "SettingsError"),
    "grasp_files": ("GraspEntry", "read_grasps", "write_grasps"),
    "grasping": ("GraspPlan", "plan_of"),
    "metrics": (
        *("METRICS", "Prediction", "evaluate", "find_metrics"),
        *("grasp_of", "object_of", "predict", "snapshot_of"),
    ),
    "model_files": ("models_dir",),
    "objects": ("ObjectInfo", "object_info", "object_names", "user_object"),
    "records": ("COLUMNS", "TrialRow", "read_rows", "read_table", "stack"),
    "robot": ("HandKinematics", "closing_between", "preshape_closing"),
    "runs": ("RunFolder", "RunPlan"),
    "sensing": ("PadContact", "PerceivedGrasp", "TactileSnapshot", "perceive"),
    "settings": ("TrialSettings",),
    "trial": ("Trial", "TrialResult", "run_trial"),
    "viewing.recording": ("write_recording",),
    "viewing.render": ("render_trial",),
}
_MODULE_OF = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    """Import a public name from its module."""
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'sdh_sim' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"sdh_sim.{_MODULE_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """What the module holds and what it can import."""
    return sorted({*globals(), *__all__})


graphics.choose()  # before anything imports MuJoCo
