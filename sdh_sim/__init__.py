"""Tactile grasp-and-lift trials of the Schunk SDH-2 hand in MuJoCo."""

import ctypes
import os
import sys

__version__ = "0.1.0"


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
