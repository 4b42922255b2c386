"""Convex decomposition by CoACD (Wei et al., ACM Transactions on Graphics 41(4), 2022).

It runs in a process of its own: it is native code that may crash on a damaged mesh or take for
ever, and it prints. The same mesh gives the same parts (fixed seed). They are kept in the user's
cache folder, below the SHA-256 of mesh, parameters and version; what is damaged there is made anew.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.metadata
import importlib.util
import io
import json
import logging
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np

from sdh_sim.atomic_files import write_atomic
from sdh_sim.errors import MeshError
from sdh_sim.user_files.mesh_limits import MAX_FACES, MeshPiece

# CoACD's own defaults but for the seed, which it documents, and as many parts as are taken.
PARAMETERS = {"threshold": 0.05, "max_convex_hull": 64, "seed": 0}
MAX_SECONDS = 900.0
_LOG = logging.getLogger(__name__)
_PROCESS = Path(__file__).with_name("coacd_process.py")


def decomposed(vertices: np.ndarray, faces: np.ndarray) -> list[MeshPiece]:
    """Convex parts that together are about the solid within a surface.

    Args:
        vertices: (n, 3) [m].
        faces: triangles (m, 3), closed or not.

    Returns:
        vertices (n, 3) [m] and triangles (m, 3) of each part.

    Raises:
        MeshError: CoACD is not installed, or does not come to an end with this mesh.
    """
    if importlib.util.find_spec("coacd") is None:
        raise MeshError(
            "is to be decomposed, which needs CoACD; install it: pip install "
            '"sdh-sim[decompose]", or leave decompose out'
        )
    mesh = _packed([(vertices, faces)])
    try:
        version = importlib.metadata.version("coacd")
    except importlib.metadata.PackageNotFoundError:
        version = ""
    key = hashlib.sha256(json.dumps([PARAMETERS, version]).encode() + mesh).hexdigest()
    path = cache_folder() / f"{key}.npz"
    kept = _from_cache(path)
    if kept is not None:
        return kept
    # It may take minutes, in which nothing else would be seen.
    _LOG.warning("decomposing a mesh of %d triangles by CoACD; the parts are kept", len(faces))
    result = _run(mesh)
    found = _unpacked(result)
    if not found:
        raise MeshError("is a mesh that CoACD makes no parts of; repair it, or use hull = true")
    with contextlib.suppress(OSError):  # without a cache it is computed again, no more
        path.parent.mkdir(parents=True, exist_ok=True)
        own = path.with_name(f"{key}.{os.getpid()}")
        write_atomic(own, hashlib.sha256(result).digest() + result)
        os.replace(own, path)
    return found


def cache_folder() -> Path:
    """Where decompositions are kept: below XDG_CACHE_HOME, or the user's .cache."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    root = Path(base) if os.path.isabs(base) else Path.home() / ".cache"
    return root / "sdh-sim" / "decompositions"


def _run(mesh: bytes) -> bytes:
    """What the process prints for a mesh; raises MeshError where it fails."""
    try:
        done = subprocess.run(
            [sys.executable, "-P", str(_PROCESS), json.dumps(PARAMETERS)],
            input=mesh,
            capture_output=True,
            timeout=MAX_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise MeshError(
            f"is not decomposed after {MAX_SECONDS:.0f} s; simplify it, or use hull = true"
        ) from error
    if done.returncode:
        lines = done.stderr.decode("utf-8", "replace").strip().splitlines()
        reason = ": ".join([f"exit status {done.returncode}", *lines[-1:]])[:140]
        raise MeshError(f"is a mesh that CoACD fails on ({reason}); repair it, or use hull = true")
    return done.stdout


def _from_cache(path: Path) -> list[MeshPiece] | None:
    """The parts in a file of the cache; None: it is missing or damaged."""
    try:
        data = path.read_bytes()
        digest, result = data[:32], data[32:]
        return _unpacked(result) if hashlib.sha256(result).digest() == digest else None
    except (OSError, MeshError):
        return None


def _packed(pieces: list[MeshPiece]) -> bytes:
    """Pieces as the bytes of an npz file, the same for the same pieces."""
    file = io.BytesIO()
    arrays = {}
    for number, (vertices, faces) in enumerate(pieces):
        arrays[f"v{number}"] = np.ascontiguousarray(vertices, float)
        arrays[f"f{number}"] = np.ascontiguousarray(faces, np.int32)
    np.savez(file, allow_pickle=False, **arrays)
    return file.getvalue()


def _unpacked(data: bytes) -> list[MeshPiece]:
    """The pieces that ``_packed`` made bytes of; raises MeshError where they are none."""
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            count = len(file.files) // 2
            found = [(file[f"v{k}"], file[f"f{k}"].astype(np.int64)) for k in range(count)]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise MeshError("is a mesh that CoACD gives no readable parts of") from error
    if sum(len(faces) for _, faces in found) > MAX_FACES:
        raise MeshError(f"is decomposed into more than {MAX_FACES} triangles; simplify it")
    return found
