"""What is kept on disk is never another version's, and a bad folder costs time and nothing else."""

import importlib
import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from graspq._compiled.jit import Entry
from graspq.warm_up import warm_up
from tests.support.repository import ROOT

PART = """
from .jit import compiled

@compiled
def part(x):
    return {factor} * x
"""
ENTRY = """
from .jit import entry
from .part import part

@entry
def result(x):
    return part(x) + 1.0
"""
CALL = """
from kernel import entries
value = entries.result(4.0)
stats = entries.result._kernel.stats
print(value, sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""


@pytest.fixture
def kernel(tmp_path):
    """A small package that compiles as graspq does: one part and one entry."""
    package = tmp_path / "kernel"
    package.mkdir()
    shutil.copy(ROOT / "graspq" / "_compiled" / "jit.py", package)
    (package / "__init__.py").touch()
    (package / "part.py").write_text(PART.format(factor=2.0))
    (package / "entries.py").write_text(ENTRY)
    return package


def call(package, stderr: int = subprocess.PIPE, env: dict[str, str] | None = None):
    """Value, times it was read from disk, times it was compiled; in a new process."""
    more = env or {}
    env = {**os.environ, "PYTHONPATH": str(package.parent), "PYTHONDONTWRITEBYTECODE": "1"}
    env["NUMBA_CACHE_DIR"] = str(package.parent / "cache")
    done = subprocess.run(
        [sys.executable, "-c", CALL],
        env={**env, **more},
        stdout=subprocess.PIPE,
        stderr=stderr,
        text=True,
        check=True,
        timeout=300,
    )
    return [float(x) for x in done.stdout.split()]


def kept(package):
    return sorted((package.parent / "cache").rglob("*.nb?"))


def test_the_second_process_reads_what_the_first_compiled(kernel):
    assert call(kernel) == [9.0, 0, 1]
    assert call(kernel) == [9.0, 1, 0]


def test_of_two_processes_at_once_one_compiles(kernel):
    with ThreadPoolExecutor() as pool:
        both = list(pool.map(call, [kernel, kernel]))
    assert sorted(both) == [[9.0, 0, 1], [9.0, 1, 0]]


def test_a_process_that_stands_still_is_not_waited_for_for_ever(kernel):
    fcntl = pytest.importorskip("fcntl", reason="there are no such locks on Windows")
    jit = kernel / "jit.py"
    text = jit.read_text()
    assert "PATIENCE = 120.0" in text
    jit.write_text(text.replace("PATIENCE = 120.0", "PATIENCE = 0.5"))
    with open(kernel / "entries.py", "rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        assert call(kernel) == [9.0, 0, 1]


def test_after_the_warm_up_everything_is_there():
    assert warm_up() > 0.0
    entries = {
        value
        for path in (ROOT / "graspq" / "_compiled").glob("*.py")
        for value in vars(importlib.import_module(f"graspq._compiled.{path.stem}")).values()
        if isinstance(value, Entry)
    }
    assert len(entries) == 5
    assert not [entry for entry in entries if entry._kernel is None or entry.busy]


def test_a_change_in_a_part_is_seen_though_the_entry_is_as_before(kernel):
    assert call(kernel) == [9.0, 0, 1]
    (kernel / "part.py").write_text(PART.format(factor=3.0))
    assert call(kernel) == [13.0, 0, 1]
    # The other version comes back to what it had kept.
    (kernel / "part.py").write_text(PART.format(factor=2.0))
    assert call(kernel) == [9.0, 1, 0]


@pytest.mark.parametrize("suffix", [".nbi", ".nbc"])
@pytest.mark.parametrize("content", [b"not what it was", None])
def test_a_damaged_file_is_replaced(kernel, suffix, content):
    call(kernel)
    for path in kept(kernel):
        if path.suffix == suffix:
            path.write_bytes(path.read_bytes()[:-30] if content is None else content)
    assert call(kernel)[0] == 9.0
    call(kernel)
    assert call(kernel) == [9.0, 1, 0]


def test_without_a_folder_that_can_be_written_it_compiles_every_time(kernel):
    # A file where a folder must be stops every user, root too.
    blocked = kernel.parent / "file"
    blocked.touch()
    (kernel / "__pycache__").touch()
    nowhere = {"NUMBA_CACHE_DIR": "", "HOME": str(blocked), "XDG_CACHE_HOME": str(blocked / "x")}
    assert call(kernel, env=nowhere)[0] == 9.0
    assert not kept(kernel)


def test_only_a_person_who_waits_is_told_and_only_once(kernel):
    pty = pytest.importorskip("pty", reason="needs a terminal, which POSIX has")
    said = []
    for _ in range(2):
        master, slave = pty.openpty()
        call(kernel, stderr=slave)
        os.write(slave, b".")
        said.append(os.read(master, 10_000).decode())
        os.close(slave)
        os.close(master)
    assert "compiling result for the first time" in said[0]
    assert said[1] == "."
    shutil.rmtree(kernel.parent / "cache")
    with (kernel.parent / "log").open("w+") as log:
        call(kernel, stderr=log)
        log.seek(0)
        assert log.read() == ""


VALUES = """
import numpy as np, graspq as gq
from tests.support.random_grasps import grasp, tasks
rng = np.random.default_rng(0)
for _ in range(12):
    sets = grasp(rng, "soft", 12)
    print(gq.epsilon(sets).hex(), gq.task_scaling(sets, tasks(rng, sets)).value.hex())
"""


def test_a_process_that_compiles_gives_the_bits_of_one_that_reads(tmp_path):
    # Fast arithmetic may be ordered otherwise in code that is compiled for one process and in what
    # is kept for the next; what values come from must not use it.
    env = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(tmp_path)}
    printed = [
        subprocess.run(
            [sys.executable, "-c", VALUES], env=env, capture_output=True, check=True, timeout=300
        ).stdout
        for _ in range(2)
    ]
    assert len(printed[0].split()) == 24
    assert printed[0] == printed[1]
