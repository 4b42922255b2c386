"""What a run notes of the packages it ran with."""

from __future__ import annotations

import importlib.metadata
import tomllib

from sdh_sim._version import __version__
from sdh_sim.runs import versions
from tests.support.repository import ROOT


def test_the_version_of_a_checkout_is_that_of_the_package():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert __version__ == project["version"]


def test_a_checkout_that_is_not_installed_has_a_version_too(monkeypatch):
    def missing(name: str) -> str:
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "version", missing)
    found = versions.__wrapped__()
    assert set(found) == {"python", "sdh-sim"}
    assert found["sdh-sim"] == __version__
