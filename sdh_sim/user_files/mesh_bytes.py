"""Binary meshes without a reader of their own: STL told from its text form, MuJoCo's MSH."""

from __future__ import annotations

import struct

import numpy as np

from sdh_sim.errors import MeshError

_STL_HEAD, _STL_TRIANGLE = 84, 50  # [bytes]


def stl_kind(data: bytes) -> tuple[bytes, str]:
    """The bytes of an STL file to read, and ``stl`` (binary) or ``stl_ascii``.

    The number of triangles in a binary file fixes its length, whatever its bytes look like as
    text: headers often begin with "solid", too. Bytes behind the last triangle are left out.

    Raises:
        MeshError: neither form.
    """
    count = struct.unpack_from("<I", data, 80)[0] if len(data) >= _STL_HEAD else 0
    expected = _STL_HEAD + _STL_TRIANGLE * count
    if len(data) == expected:
        return data, "stl"
    if data[:1024].lstrip()[:5].lower() == b"solid" and b"\0" not in data:
        return data, "stl_ascii"
    if count > 0 and expected < len(data):
        return data[:expected], "stl"
    raise MeshError(
        f"is not a mesh that can be read as STL: as binary it claims {count} triangles, "
        f"{expected} bytes, and has {len(data)}; as text it would begin with solid"
    )


def read_msh(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) and triangles (m, 3) of a MuJoCo MSH file.

    Its layout is in the MuJoCo documentation, XML reference, asset/mesh: four counts (vertices,
    normals, texture coordinates, triangles), then these arrays in single precision and indices.

    Raises:
        MeshError: the counts do not fit its bytes, or there is no triangle.
    """
    if len(data) < 16:
        raise MeshError("is not a mesh that can be read as MSH: it has no header")
    counts = struct.unpack_from("<4i", data)
    vertices, normals, coordinates, faces = counts
    expected = 16 + 12 * vertices + 12 * normals + 8 * coordinates + 12 * faces
    if min(counts) < 0 or expected != len(data):
        raise MeshError(
            f"is not a mesh that can be read as MSH: its counts {counts} do not fit {len(data)} "
            "bytes"
        )
    points = np.frombuffer(data, "<f4", 3 * vertices, 16).reshape(-1, 3)
    corners = np.frombuffer(data, "<i4", 3 * faces, expected - 12 * faces).reshape(-1, 3)
    if not faces:
        raise MeshError("holds no triangles")
    return points.astype(float), corners
