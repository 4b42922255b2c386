"""The process that runs CoACD: a mesh comes on standard input, the parts go to standard output.

``convex_decomposition`` starts it. CoACD prints what it does to standard output, so that is moved
aside before it is loaded.
"""

from __future__ import annotations

import io
import json
import os
import sys

import numpy as np


def main() -> None:
    """Decompose one mesh (npz with ``v0`` (n, 3), ``f0`` (m, 3)) into an npz of v0, f0, v1, …"""
    parameters = json.loads(sys.argv[1])
    with np.load(io.BytesIO(sys.stdin.buffer.read()), allow_pickle=False) as mesh:
        vertices, faces = mesh["v0"], mesh["f0"]
    result = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    import coacd  # type: ignore[import-not-found]

    coacd.set_log_level("error")
    # Its tolerances are absolute: a mesh of a size of its own making gives the same parts for any.
    centre = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    size = float(np.ptp(vertices, axis=0).max())
    parts = coacd.run_coacd(coacd.Mesh((vertices - centre) / size, faces), **parameters)
    arrays = {}
    for number, (corners, triangles) in enumerate(parts):
        arrays[f"v{number}"] = np.asarray(corners, float) * size + centre
        arrays[f"f{number}"] = np.asarray(triangles, np.int32)
    with result:
        np.savez(result, allow_pickle=False, **arrays)


if __name__ == "__main__":
    main()
