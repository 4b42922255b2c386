"""What a result depends on besides its settings: versions of packages, the machine."""

from __future__ import annotations

import importlib.metadata
import platform
import sys
from functools import lru_cache

from sdh_sim._version import __version__

_PACKAGES = (
    "sdh-sim",
    "mujoco",
    "numpy",
    "scipy",
    "trimesh",
    "mink",
    "daqp",
    "pyarrow",
    "rerun-sdk",
)


@lru_cache(maxsize=1)
def versions() -> dict[str, str]:
    """Versions of Python and of the packages that decide a trial's numbers."""
    found = {"python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            if name == "sdh-sim":  # a checkout that is not installed
                found[name] = __version__
    return found


def machine() -> dict[str, str]:
    """The platform, as far as it can change the last bits of a result."""
    return {"platform": platform.platform(), "machine": platform.machine(), "os": sys.platform}
