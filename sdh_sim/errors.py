"""Every error of the package that a caller may want to catch, from general to special.

A message says what came, what was expected and what to do, in one line where a user may see it.
"""

from __future__ import annotations


class SettingsError(ValueError):
    """A setting that cannot be used; the message names it, what came and what would do."""


class ObjectError(SettingsError):
    """An object's folder that cannot be used; the message says where, what and what would do."""


class HandError(SettingsError):
    """A hand's folder that cannot be used; the message says where, what and what would do."""


class GraspFileError(SettingsError):
    """A file of grasps that cannot be used; the message says where, what and what would do."""


class MeshError(ValueError):
    """A mesh that cannot be used; the message is the end of a sentence about its file."""


class MjcfError(ValueError):
    """An MJCF that cannot be used; the message is the end of a sentence about its file."""


class RecordError(ValueError):
    """A table or a row that cannot be used; the message says what came and what would do."""


class RunError(ValueError):
    """A run folder or plan that cannot be used; the message is one line with a way out."""


class NoFeasibleGrasp(RuntimeError):
    """No random grasp of an object is feasible; the message counts why and says what would be."""


class InfeasibleGrasp(RuntimeError):
    """A given grasp is out of reach or in collision; the message says which."""


class Diverged(Exception):
    """The simulation left the plausible numbers; the state is the one after the fatal step."""


class RenderError(OSError):
    """No headless OpenGL, or no film writer; the message names the package that helps."""


class WorkerDied(RuntimeError):
    """Worker processes end before they are ready; no trial is to blame."""


class CampaignError(RuntimeError):
    """A run that broke off; the message says why, what is kept and how to continue.

    Attributes:
        status: exit status of the command: 2 where the user's disk is at fault, else 1.
        details: traceback of the worker, or empty.
    """

    def __init__(self, message: str, status: int = 1, details: str = "") -> None:
        super().__init__(message)
        self.status = status
        self.details = details


class Interrupted(CampaignError):
    """The user, or the system, asked the run to stop; status is 128 plus the signal's number."""


def one_line(text: object, length: int = 200) -> str:
    """What comes from a file, as part of a message: its first line, cut to a length."""
    first = (str(text).splitlines() or [""])[0]
    return first if len(first) <= length else first[: length - 1] + "…"
