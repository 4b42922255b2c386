"""Tables of a ``hand.toml``: values of a type each, every key asked for once."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from typing import Any

from sdh_sim.errors import HandError

FILE = "hand.toml"
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,47}")


class TomlTable:
    """A table of the file: values of a type each, every key asked for once.

    Args:
        where: the table in messages.
        values: by key.
    """

    def __init__(self, where: str, values: object) -> None:
        if not isinstance(values, dict):
            raise HandError(f"{where or FILE} is {show(values)}; expected a table")
        self._where, self._values, self._asked = where, values, set[str]()

    def error(self, key: str, problem: str) -> HandError:
        """The error for a key."""
        return HandError(f"{self._where}.{key}".lstrip(".") + f" {problem}")

    def get(
        self, key: str, kind: type | tuple[type, ...], expected: str, default: Any = ...
    ) -> Any:
        """The value of a key; ``default`` where it may be left out."""
        self._asked.add(key)
        if key not in self._values:
            if default is ...:
                raise self.error(key, f"is missing; expected {expected}")
            return default
        value = self._values[key]
        if not isinstance(value, kind) or (isinstance(value, bool) and bool not in _types(kind)):
            raise self.error(key, f"is {show(value)}; expected {expected}")
        return value

    def name(self, key: str, default: Any = ...) -> str:
        """A name."""
        value = self.get(key, str, "a name", default)
        if value is not default and not _NAME.fullmatch(value):
            raise self.error(key, f"is {show(value)}; a name has letters, digits, _ and -")
        return value

    def number(self, key: str, low: float, high: float, default: Any = ...) -> float:
        """A finite number within bounds."""
        value = self.get(key, (int, float), "a number", default)
        if value is not default and not low <= value <= high:
            raise self.error(key, f"is {show(value)}; allowed is {low:g} to {high:g}")
        return float(value)

    def whole(self, key: str, low: int, high: int, default: Any = ...) -> int:
        """A whole number within bounds."""
        value = self.get(key, int, "a whole number", default)
        if value is not default and not low <= value <= high:
            raise self.error(key, f"is {show(value)}; allowed is {low} to {high}")
        return value

    def numbers(self, key: str, count: int, default: Any = ...) -> tuple[float, ...]:
        """So many finite numbers."""
        value = self.get(key, list, f"a list of {count} numbers", default)
        if value is default:
            return value
        good = all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in value)
        if len(value) != count or not good or not all(map(math.isfinite, value)):
            raise self.error(key, f"is {show(value)}; expected {count} finite numbers")
        return tuple(map(float, value))

    def names(self, key: str, known: Sequence[str] | None, default: Any = ...) -> tuple[str, ...]:
        """A list of names, of those known where that is given."""
        value = self.get(key, list, "a list of names", default)
        for item in value:
            if not isinstance(item, str) or (known is not None and item not in known):
                hint = "a name" if known is None else f"one of {', '.join(known)}"
                raise self.error(key, f"has {show(item)}; expected {hint}")
        return tuple(value)

    def tables(self, key: str, most: int, default: Any = ...) -> Iterator[tuple[str, TomlTable]]:
        """The tables below a key by name, in the order of the file."""
        found = self.get(key, dict, "tables by name", default)
        if len(found) > most:
            raise self.error(key, f"has {len(found)} tables; at most {most} are taken")
        for name, values in found.items():
            if not _NAME.fullmatch(name):
                raise self.error(key, f"has {show(name)}; a name has letters, digits, _ and -")
            below = TomlTable(f"{self._where}.{key}.{name}".lstrip("."), values)
            yield name, below
            below.finish()

    def finish(self) -> None:
        """Raise HandError where the table has a key that nobody asked for."""
        for key in self._values:
            if key not in self._asked:
                raise self.error(
                    show(key, 40), f"is not known; known here are {', '.join(sorted(self._asked))}"
                )


def _types(kind: type | tuple[type, ...]) -> tuple[type, ...]:
    return kind if isinstance(kind, tuple) else (kind,)


def show(value: object, length: int = 60) -> str:
    """A value in a message, cut to a length."""
    text = repr(value)
    return text if len(text) <= length else text[: length - 1] + "…"
