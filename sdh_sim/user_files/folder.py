"""A folder of a user's own: its files are read whole, within bounds.

No file outside the folder is opened, whatever the files in it say. Each file is read once, so that
the SHA-256 is that of the bytes that are used.
"""

from __future__ import annotations

import hashlib
import os
import stat
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from sdh_sim.errors import SettingsError

MAX_FILES = 65  # that an object or a hand is made of
MAX_ENTRIES = 1000  # in the folder, files that are not read included


@dataclass(frozen=True)
class FolderKind:
    """What a folder describes.

    Attributes:
        what: word for it, such as ``object``, with which messages begin.
        error: raised where the folder cannot be used.
        content: what the folder must hold, for messages.
    """

    what: str
    error: type[SettingsError]
    content: str


def show(value: object, length: int = 80) -> str:
    """A user's value in a message: one line without control characters, cut to a length."""
    text = repr(value)
    return text if len(text) <= length else text[: length - 1] + "…"


class Folder:
    """A folder and the files of it that have been read.

    Attributes:
        kind: what it describes.
        path: absolute path of the folder.

    Raises:
        SettingsError: of the kind's class: it is no folder, or its path is not printable.
    """

    def __init__(self, path: str | Path, kind: FolderKind) -> None:
        self.kind = kind
        try:
            self.path = Path(path).expanduser().absolute()
            self._root = self.path.resolve(strict=True)
            if not self._root.is_dir():
                raise NotADirectoryError(0, "it is not a folder")
        except (OSError, ValueError, RuntimeError) as error:
            reason = getattr(error, "strerror", None) or "not a path"
            raise kind.error(
                f"{kind.what}: {show(str(path), 400)}: {reason}; give a folder with {kind.content}"
            ) from error
        if not str(self.path).isprintable():
            raise kind.error(f"{kind.what}: {show(str(path), 400)}: the path must be printable")
        self._read: dict[str, bytes] = {}

    def error(self, problem: str) -> SettingsError:
        """An error whose message names this folder and says what the problem is."""
        # Messages quote files: no control characters, no change of writing direction.
        clean = "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in problem)
        return self.kind.error(f"{self.kind.what}: {self.path}: {clean}")

    def names(self) -> list[str]:
        """Names of the files and folders in the folder itself, sorted.

        Raises:
            SettingsError: too many of them, or the folder cannot be read.
        """
        found: list[str] = []
        try:
            with os.scandir(self._root) as entries:
                for entry in entries:
                    if len(found) >= MAX_ENTRIES:
                        raise self.error(
                            f"it holds more than {MAX_ENTRIES} files; give a folder of the "
                            f"{self.kind.what}'s own"
                        )
                    found.append(entry.name)
        except OSError as error:
            raise self.error(f"cannot be read ({error.strerror})") from error
        return sorted(found)

    def read(self, name: str, limit: int, counts: bool = True) -> bytes:
        """The content of a file.

        Args:
            name: of the file, relative to the folder, with ``/``.
            limit: largest size [bytes].
            counts: the object or hand is made of it, so that it belongs to the digest.

        Raises:
            SettingsError: the name leads out of the folder, or it is no file, is larger than the
                limit or cannot be read.
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
            raise self.error(f"file {show(name)} is not the name of a file in this folder")
        if len(self._read) >= MAX_FILES:
            raise self.error(f"it takes more than {MAX_FILES} files; join meshes")
        data = self._bytes(name, self._root.joinpath(*parts), limit)
        if counts:
            self._read[name] = data
        return data

    def _bytes(self, name: str, path: Path, limit: int) -> bytes:
        """The content of a file that lies inside the folder once links are followed."""
        try:
            real = path.resolve(strict=True)
            if not real.is_relative_to(self._root):
                raise self.error(f"file {show(name)} is a link that leads out of this folder")
            # Opening a pipe would wait for ever and a device has no end: hence flag and check.
            handle = os.open(real, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
            with open(handle, "rb") as file:
                if not stat.S_ISREG(os.fstat(handle).st_mode):
                    raise self.error(f"{show(name)} is not a file")
                data = file.read(limit + 1)
        except (OSError, RuntimeError) as error:
            reason = getattr(error, "strerror", None) or "a link without end"
            raise self.error(f"cannot read {show(name)}: {reason}") from error
        if len(data) > limit:
            raise self.error(
                f"{show(name)} has more than {limit} bytes, the most that is read of such a file"
            )
        return data

    def sha256(self, computed: bytes = b"") -> str:
        """Digest of the names and bytes of all files that count, read so far, in hexadecimal.

        Args:
            computed: what it is made of beside its files.
        """
        digest = hashlib.sha256()
        for name, data in sorted(self._read.items()):
            digest.update(f"{name}\0{len(data)}\0".encode())
            digest.update(data)
        digest.update(computed)
        return digest.hexdigest()
