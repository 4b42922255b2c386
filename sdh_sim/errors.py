"""The error of whatever a user gave: an option, an object's folder, a metric."""

from __future__ import annotations


class SettingsError(ValueError):
    """A setting that cannot be used; the message names it, what came and what would do."""


class RenderError(OSError):
    """No headless OpenGL, or no film writer; the message names the package that helps."""
