"""Where the published random grasps of Krug et al. (2017) are, when they are there."""

import os
from pathlib import Path

import pytest

from tests.support.repository import ROOT

NAME = "krug2017_random_grasps.npz"
BESIDE = ROOT / "../shared/reference" / NAME


def reference_path() -> Path | None:
    """The data file, from GRASPQ_REFERENCE_DATA or beside the repository; None when absent."""
    given = os.environ.get("GRASPQ_REFERENCE_DATA")
    path = Path(given) if given else BESIDE
    return path if path.is_file() else None


def need_reference() -> Path:
    """The data file, or skip the test."""
    path = reference_path()
    if path is None:
        pytest.skip(
            f"{NAME} is not there; point GRASPQ_REFERENCE_DATA at it to compare with the"
            " published values"
        )
    return path
