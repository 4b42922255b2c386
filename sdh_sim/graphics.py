"""Which OpenGL MuJoCo draws with: without a screen, and never a reason why nothing else runs.

MuJoCo reads ``MUJOCO_GL`` when it is imported, not later, and its import fails where that names a
back end that it does not know or that is not installed. Most of this package draws nothing. So
``import sdh_sim`` looks at the variable first: where nothing is asked for it names what is there,
where what is asked for cannot be loaded it turns drawing off and keeps the name for whoever draws.
The variables are inherited, so worker processes do as the process that started them.
"""

from __future__ import annotations

import ctypes
import os
import sys

NAME, ASKED = "MUJOCO_GL", "SDH_SIM_MUJOCO_GL"  # ASKED: what was asked for and cannot be used
OFF = "disable"
_OFF = (OFF, "disabled", "off", "false", "0")
_ANY = ("", "enable", "enabled", "on", "true", "1", "glfw")  # MuJoCo's own window library
_OF_SYSTEM = {"linux": ("glx",), "win32": ("wgl",), "darwin": ("cgl",)}
_LIBRARIES = {"egl": ("libEGL.so.1", "libEGL.so"), "osmesa": ("libOSMesa.so.8", "libOSMesa.so")}


def choose() -> None:
    """Set ``MUJOCO_GL`` to what can be loaded; nothing where MuJoCo is there already."""
    if "mujoco" in sys.modules:
        return
    asked = os.environ.get(NAME)
    if asked is None:
        found = _there() if sys.platform.startswith("linux") else []
        if found:
            os.environ[NAME] = found[0]
    elif not _can_be_loaded(asked.lower().strip()):
        os.environ[ASKED], os.environ[NAME] = asked, OFF


def why_nothing_can_be_drawn() -> str | None:
    """What to do about ``MUJOCO_GL`` where it is the reason; else None."""
    name = os.environ.get(NAME, "")
    if name.lower().strip() not in _OFF:
        return None
    there = " or ".join(["unset it", *(f"set it to {name}" for name in _there())])
    if name == OFF and ASKED in os.environ:
        asked = os.environ[ASKED]
        return f"{NAME} is {asked!r:.80}, which cannot be used here; {there}"
    return f"{NAME} is {name!r}, which turns drawing off; {there}"


def _there() -> list[str]:
    """The back ends that draw without a screen and can be loaded, the better one first."""
    return [name for name in _LIBRARIES if _can_be_loaded(name)]


def _can_be_loaded(name: str) -> bool:
    if name in (*_OFF, *_ANY, *_OF_SYSTEM.get(sys.platform, ())):
        return True
    if name not in _LIBRARIES or not sys.platform.startswith("linux"):
        return False
    # PyOpenGL, which these two draw through, can be told to take another library.
    if os.environ.get("PYOPENGL_PLATFORM", name).lower() not in ("", name):
        return False
    return any(map(_loads, _LIBRARIES[name]))


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True
