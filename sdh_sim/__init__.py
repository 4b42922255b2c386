"""Tactile grasp-and-lift trials of the Schunk SDH-2 hand in MuJoCo.

The names below are the library: each is imported from its module when it is first used, so that
``import sdh_sim`` brings neither MuJoCo nor a table.
"""

import ctypes
import importlib
import os
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sdh_sim.campaign.campaign import run_campaign
    from sdh_sim.campaign.session import RunResult
    from sdh_sim.errors import CampaignError, RunError, SettingsError
    from sdh_sim.metrics.built_in import METRICS, evaluate
    from sdh_sim.metrics.prediction import Prediction, predict
    from sdh_sim.metrics.stored_grasps import grasp_of, object_of, snapshot_of
    from sdh_sim.metrics.user_metrics import find_metrics
    from sdh_sim.model_files import models_dir
    from sdh_sim.objects.catalogue import ObjectInfo, object_info, object_names, user_object
    from sdh_sim.records.parquet_files import read_rows, read_table
    from sdh_sim.records.rows import stack
    from sdh_sim.records.schema import COLUMNS, RecordError
    from sdh_sim.robot.hand import HandKinematics
    from sdh_sim.runs.folder import RunFolder
    from sdh_sim.runs.plan import RunPlan
    from sdh_sim.sensing.pad_contacts import PadContact
    from sdh_sim.sensing.perceived_grasp import PerceivedGrasp, perceive
    from sdh_sim.sensing.snapshot import TactileSnapshot
    from sdh_sim.settings import TrialSettings
    from sdh_sim.trial.trial import TrialResult, run_trial
    from sdh_sim.viewing.recording import write_recording
    from sdh_sim.viewing.render import render_trial

__version__ = "0.1.0"

__all__ = [
    "COLUMNS",
    "METRICS",
    "CampaignError",
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
    "TrialResult",
    "TrialSettings",
    "evaluate",
    "find_metrics",
    "grasp_of",
    "models_dir",
    "object_info",
    "object_names",
    "object_of",
    "perceive",
    "predict",
    "read_rows",
    "read_table",
    "render_trial",
    "run_campaign",
    "run_trial",
    "snapshot_of",
    "stack",
    "user_object",
    "write_recording",
]

_MODULES = {
    "campaign": ("CampaignError", "RunResult", "run_campaign"),
    "hand": ("HandKinematics",),
    "metrics": ("METRICS", "evaluate"),
    "model_files": ("models_dir",),
    "objects": ("ObjectInfo", "object_info", "object_names", "user_object"),
    "pad_contact": ("PadContact",),
    "perception": ("PerceivedGrasp", "perceive"),
    "prediction": ("Prediction", "predict"),
    "recording": ("write_recording",),
    "records": ("COLUMNS", "RecordError", "read_rows", "read_table", "stack"),
    "render": ("render_trial",),
    "run_folder": ("RunError", "RunFolder"),
    "run_plan": ("RunPlan",),
    "settings": ("SettingsError", "TrialSettings"),
    "stored": ("grasp_of", "object_of", "snapshot_of"),
    "tactile": ("TactileSnapshot",),
    "trial": ("TrialResult", "run_trial"),
    "user_metrics": ("find_metrics",),
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


def _choose_headless_gl() -> None:
    """Let MuJoCo draw without a screen; it reads MUJOCO_GL when it is imported, not later."""
    if not sys.platform.startswith("linux") or "MUJOCO_GL" in os.environ:
        return
    # Naming a backend whose library is missing would break `import mujoco` itself.
    for library, backend in (("libEGL.so.1", "egl"), ("libOSMesa.so.8", "osmesa")):
        try:
            ctypes.CDLL(library)
        except OSError:
            continue
        os.environ["MUJOCO_GL"] = backend
        return


_choose_headless_gl()
