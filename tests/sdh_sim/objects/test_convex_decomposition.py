"""Convex decomposition: its process, its cache, and CoACD itself where it is installed."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from sdh_sim.errors import MeshError
from sdh_sim.objects import convex_decomposition as decomposition
from sdh_sim.objects import user_object
from tests.support.object_files import FACTS, info_of, object_folder, refusal

ASKED = FACTS + "decompose = true"
# Stands for CoACD: the box of a mesh in two halves along x. It counts its runs in a file.
STAND_IN = """
import os, pathlib, numpy as np
class Mesh:
    def __init__(self, vertices, faces):
        self.vertices = vertices
def set_log_level(level):
    print("noise on standard output")
def run_coacd(mesh, threshold, max_convex_hull, seed):
    log = pathlib.Path(os.environ["RUNS"])
    log.write_text(log.read_text() + "x")
    {}
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    middle = 0.5 * (low[0] + high[0])
    found = []
    for a, b in ((low[0], middle), (middle, high[0])):
        corners = [[x, y, z] for x in (a, b) for y in (low[1], high[1]) for z in (low[2], high[2])]
        found.append([np.array(corners), np.array([[0, 1, 2]])])
    return found
"""


@pytest.fixture
def stand_in(tmp_path, monkeypatch):
    """Installs the stand-in with more lines of code in it; the file that counts its runs."""
    place, runs = tmp_path / "site", tmp_path / "runs"
    place.mkdir()
    runs.write_text("")
    monkeypatch.setenv("RUNS", str(runs))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("PYTHONPATH", str(place), prepend=":")
    monkeypatch.syspath_prepend(str(place))

    def install(code: str = "") -> Path:
        (place / "coacd.py").write_text(STAND_IN.replace("{}", code))
        importlib.invalidate_caches()
        return runs

    yield install
    sys.modules.pop("coacd", None)


def ring() -> trimesh.Trimesh:
    return trimesh.creation.annulus(0.02, 0.04, 0.1)


def test_without_coacd_the_message_says_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert 'pip install "sdh-sim[decompose]"' in refusal(object_folder(tmp_path, ring(), ASKED))
    # What is convex needs none.
    assert user_object(object_folder(tmp_path / "b", facts=ASKED)).parts == 1


def test_parts_are_computed_once_and_kept_beside_the_folder(tmp_path, stand_in):
    runs = stand_in()
    path = object_folder(tmp_path, ring(), ASKED)
    files = sorted(path.rglob("*"))
    found = user_object(path)
    assert (found.parts, found.hull_ratio) == (2, pytest.approx(1.0))
    assert "decomposed by CoACD, mass distribution from the convex parts" in found.reference.notes
    assert info_of(path).extents_m == pytest.approx((0.08, 0.08, 0.1), abs=1e-4)
    assert info_of(path).com_m == pytest.approx(np.zeros(3), abs=1e-4)
    assert runs.read_text() == "x"
    assert sorted(path.rglob("*")) == files
    [kept] = decomposition.cache_folder().iterdir()
    for damage in (b"", kept.read_bytes()[:-9], kept.read_bytes()[:40] + b"\0" * 900):
        kept.write_bytes(damage)
        runs.write_text("")
        assert user_object(path).reference.sha256 == found.reference.sha256
        assert runs.read_text() == "x"
        assert user_object(path).parts == 2
        assert runs.read_text() == "x"


def test_without_a_place_for_the_cache_it_is_computed_again(tmp_path, stand_in, monkeypatch):
    runs = stand_in()
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    path = object_folder(tmp_path, ring(), ASKED)
    assert user_object(path).parts == user_object(path).parts == 2
    assert runs.read_text() == "xx"


def test_other_parts_are_another_object(tmp_path, stand_in):
    stand_in()
    path = object_folder(tmp_path, ring(), ASKED)
    before = user_object(path).reference.sha256
    [kept] = decomposition.cache_folder().iterdir()
    kept.unlink()
    stand_in("mesh.vertices = mesh.vertices * 0.99")
    assert user_object(path).reference.sha256 != before


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("os._exit(7)", "exit status 7"),
        ("raise ValueError('odd mesh')", "ValueError: odd mesh"),
        ("return []", "CoACD makes no parts of"),
        ("os.write(1, b'text'); os._exit(0)", "gives no readable parts"),
    ],
)
def test_a_process_that_fails_is_one_line(tmp_path, stand_in, code, message):
    stand_in(code)
    assert message in refusal(object_folder(tmp_path, ring(), ASKED))


def test_a_process_without_end_is_ended(tmp_path, stand_in, monkeypatch):
    stand_in("import time; time.sleep(60)")
    monkeypatch.setattr(decomposition, "MAX_SECONDS", 2.0)
    with pytest.raises(MeshError, match="is not decomposed after 2 s"):
        decomposition.decomposed(np.array(ring().vertices), np.array(ring().faces))


def test_coacd_makes_convex_parts_of_a_ring(tmp_path, monkeypatch):
    pytest.importorskip("coacd", reason="the extra 'decompose' is not installed")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    found = user_object(object_folder(tmp_path, ring(), ASKED))
    assert found.parts >= 4
    # The parts leave the hole open: their inertia is nearly that of the ring.
    solid = ring()
    solid.density = 0.4 / solid.volume
    info = info_of(tmp_path / "block")
    assert info.inertia_kgm2 == pytest.approx(solid.moment_inertia, rel=0.1, abs=1e-6)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "other"))  # computed anew, the same
    assert user_object(tmp_path / "block").reference.sha256 == found.reference.sha256
