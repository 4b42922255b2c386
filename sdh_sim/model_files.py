"""Where the MJCF models lie: beside the package in a checkout, inside it when installed."""

from __future__ import annotations

from functools import cache
from pathlib import Path


@cache
def models_dir() -> Path:
    """Folder that holds ``schunk_sdh2``, ``kuka_kr5_sixx_r850``, ``objects`` and ``cell``.

    Raises:
        FileNotFoundError: the installation lacks its models.
    """
    package = Path(__file__).resolve().parent
    for candidate in (package / "models", package.parent / "models"):
        if (candidate / "schunk_sdh2").is_dir():
            return candidate
    raise FileNotFoundError(
        f"no models found in {package / 'models'} or {package.parent / 'models'}; "
        "reinstall the package or run from a complete checkout"
    )
