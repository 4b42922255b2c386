"""The frame of the fuzz tests: damage an input, hand it to its readers, accept clear refusals only.

    python -m tests.fuzz.damaged_runs --seconds 3600 --seed 7

An input that gives anything but a refusal of one line, or that kills the process, stays in the
folder that is printed first.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.support.repository import ROOT


class Target:
    """Input files, the ways to damage them and what reads them.

    Attributes:
        refusals: errors that may come out.
        slowest: the longest that a reader may take [s].
    """

    refusals: tuple[type[Exception], ...] = ()
    slowest = 20.0

    def damage(self, rng: np.random.Generator) -> str:
        """Write sound inputs of which one is damaged; says which and how."""
        raise NotImplementedError

    def readers(self) -> list[Callable[[], object]]:
        """Everything that reads them."""
        raise NotImplementedError

    def check_message(self, text: str) -> None:
        """Raise AssertionError where a refusal's one line is not clear."""


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """The bytes after a few random changes: flips, cuts, copies, extreme values."""
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 5))):
        if not out:
            break
        # Half of the changes go to the end, where a parquet file says what it holds.
        low = max(0, len(out) - 12_000) if rng.integers(2) else 0
        at = int(rng.integers(low, len(out)))
        span = int(rng.integers(1, 9))
        match int(rng.integers(6)):
            case 0:
                out[at] ^= 1 << int(rng.integers(8))
            case 1:
                out[at : at + span] = rng.bytes(span)
            case 2:
                out[at : at + span] = bytes([int(rng.choice([0, 1, 127, 128, 255]))]) * span
            case 3:
                del out[at : at + span]
            case 4:
                out = out[:at]
            case _:
                start = int(rng.integers(len(out)))
                out[at:at] = out[start : start + 8 * span]
    return bytes(out)


def fuzz(target: Target, seconds: float, seed: int) -> Counter[str]:
    """Damage and read for so long; how many inputs of each kind were refused or read.

    Raises:
        AssertionError: something but a clear refusal came out, or too late; it names the input.
    """
    counts = Counter[str]()
    stop = time.monotonic() + seconds
    number = 0
    while time.monotonic() < stop:
        rng = np.random.default_rng([seed, number])
        kind = target.damage(rng)
        where = f"seed {seed}, input {number} ({kind})"
        number += 1
        for reader in target.readers():
            begin = time.monotonic()
            try:
                reader()
                counts[f"{kind} read"] += 1
            except KeyboardInterrupt:
                raise
            except target.refusals as error:
                text = str(error)
                assert text, f"{where}: no message"
                assert "\n" not in text, f"{where}: {text!r}"
                assert len(text) < 2000, f"{where}: too long"
                try:
                    target.check_message(text)
                except AssertionError as unclear:
                    raise AssertionError(f"{where}: {text!r}") from unclear
                counts[f"{kind} refused"] += 1
            except BaseException as error:
                raise AssertionError(where) from error
            taken = time.monotonic() - begin
            assert taken < target.slowest, f"{where}: took {taken:.0f} s"
    return counts


def main(make_target: Callable[[Path], Target], memory: int | None = None) -> None:
    """Fuzz in a new folder as the command line says, then print the counts.

    Args:
        make_target: makes the inputs in a folder.
        memory: bytes of address space; a claim of more must be refused, not tried.
    """
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    if memory is not None:
        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    place = Path(tempfile.mkdtemp())
    print(place, flush=True)
    for name, count in sorted(fuzz(make_target(place), asked.seconds, asked.seed).items()):
        print(f"{name}: {count}")


def run_driver(module: str, folder: Path, shortest: float) -> str:
    """Run a driver in a process of its own: a crash in native code would take the tests with it.

    Args:
        module: name of the driver in this folder.
        folder: for its inputs.
        shortest: seconds, unless SDH_SIM_FUZZ_SECONDS asks for others; 10 or more take a new seed.

    Returns:
        what it printed.
    """
    seconds = float(os.environ.get("SDH_SIM_FUZZ_SECONDS", shortest))
    seed = 0 if seconds < 10 else int(np.random.default_rng().integers(2**31))
    command = [sys.executable, "-m", f"tests.fuzz.{module}"]
    done = subprocess.run(
        [*command, "--seconds", str(seconds), "--seed", str(seed)],
        cwd=ROOT,
        env={**os.environ, "TMPDIR": str(folder)},
        capture_output=True,
        text=True,
        timeout=seconds + 90,
        check=False,
    )
    assert done.returncode == 0, f"seed {seed}: {done.stderr}"
    return done.stdout
