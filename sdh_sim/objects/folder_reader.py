"""The folder of a user's object: files read whole, within bounds, and from nowhere else.

No file outside the folder is opened, whatever the files in it say, and what is read is read once:
the SHA-256 is of the very bytes that become the object.
"""

from __future__ import annotations

import hashlib
import os
import stat
from pathlib import Path, PurePosixPath

from sdh_sim.errors import ObjectError

FACTS = "object.toml"
MAX_FILES = 65  # that make the object
MAX_ENTRIES = 1000  # in the folder


def show(value: object, length: int = 80) -> str:
    """A user's value in a message: one line without control characters, cut to a length."""
    text = repr(value)
    return text if len(text) <= length else text[: length - 1] + "…"


class Folder:
    """A folder and the files of it that have been read.

    Attributes:
        path: absolute path of the folder.

    Raises:
        ObjectError: it is no folder.
    """

    def __init__(self, path: str | Path) -> None:
        try:
            self.path = Path(path).expanduser().absolute()
            self._root = self.path.resolve(strict=True)
            if not self._root.is_dir():
                raise NotADirectoryError(0, "it is not a folder")
        except (OSError, ValueError, RuntimeError) as error:
            reason = getattr(error, "strerror", None) or "not a path"
            raise ObjectError(
                f"object: {show(str(path), 400)}: {reason}; give a folder with {FACTS} and a mesh "
                "or an MJCF file"
            ) from error
        if not str(self.path).isprintable():
            raise ObjectError(f"object: {show(str(path), 400)}: the path must be printable")
        self._read: dict[str, bytes] = {}

    def fault(self, what: str) -> ObjectError:
        """The error for something about this folder."""
        # What files say goes into messages: no control characters, no change of direction.
        clean = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in what)
        return ObjectError(f"object: {self.path}: {clean}")

    def names(self) -> list[str]:
        """Files of the folder itself, sorted."""
        found: list[str] = []
        try:
            with os.scandir(self._root) as entries:
                for entry in entries:
                    if len(found) >= MAX_ENTRIES:
                        raise self.fault(f"it holds more than {MAX_ENTRIES} files; give a folder "
                                         "of the object's own")  # fmt: skip
                    found.append(entry.name)
        except OSError as error:
            raise self.fault(f"cannot be read ({error.strerror})") from error
        return sorted(found)

    def read(self, name: str, limit: int) -> bytes:
        """The content of a file, named relative to the folder with ``/``.

        Raises:
            ObjectError: the name leads out of the folder, it is no file, or is over the limit.
        """
        if name in self._read:
            return self._read[name]
        parts = PurePosixPath(name).parts
        if (
            not 0 < len(name) <= 255
            or not name.isprintable()
            or name.startswith(("/", "~"))
            or "\\" in name
            or ":" in name
            or ".." in parts
            or not parts
        ):
            raise self.fault(f"file {show(name)} is not the name of a file in this folder")
        if len(self._read) >= MAX_FILES:
            raise self.fault(f"it takes more than {MAX_FILES} files; join meshes")
        self._read[name] = data = self._bytes(name, self._root.joinpath(*parts), limit)
        return data

    def _bytes(self, name: str, path: Path, limit: int) -> bytes:
        try:
            real = path.resolve(strict=True)
            if not real.is_relative_to(self._root):
                raise self.fault(f"file {show(name)} is a link that leads out of this folder")
            # A pipe would block for ever, a device never end: hence the flag and the check.
            handle = os.open(real, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
            with open(handle, "rb") as file:
                if not stat.S_ISREG(os.fstat(handle).st_mode):
                    raise self.fault(f"{show(name)} is not a file")
                data = file.read(limit + 1)
        except (OSError, RuntimeError) as error:
            reason = getattr(error, "strerror", None) or "a link without end"
            raise self.fault(f"cannot read {show(name)}: {reason}") from error
        if len(data) > limit:
            raise self.fault(
                f"{show(name)} has more than {limit} bytes, the most that is read of such a file"
            )
        return data

    def sha256(self) -> str:
        """Of the names and bytes of all files read so far."""
        digest = hashlib.sha256()
        for name, data in sorted(self._read.items()):
            digest.update(f"{name}\0{len(data)}\0".encode())
            digest.update(data)
        return digest.hexdigest()
