"""YAML within bounds: mappings, lists and text; nothing in a file can name, build or repeat.

PyYAML splits the file into events; what is built of them is decided here. Anchors, aliases and tags
are refused, so that a small file cannot become a large value. Scalars stay text: the reader of a
format says which are numbers ("1e-3" is none to YAML 1.1).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import yaml

from sdh_sim.errors import one_line
from sdh_sim.grasp_files.grasp_entry import FormatError

MAX_DEPTH = 8
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # ten times as fast, where it is built


def read_yaml(data: bytes, max_nodes: int) -> Any:
    """The document of a file: dicts, lists and text; None for a null or an empty document.

    Args:
        data: content of the file.
        max_nodes: largest number of values in it.

    Raises:
        FormatError: not YAML, more than one document, an anchor, alias or tag, a key twice, too
            deep or too large.
    """
    try:
        return _document(yaml.parse(data, Loader=_LOADER), max_nodes)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        place = "" if mark is None else f" in line {mark.line + 1}"
        problem = getattr(error, "problem", None) or getattr(error, "reason", None) or "unreadable"
        raise FormatError(f"is not YAML{place}: {one_line(problem, 100)}") from error
    except (UnicodeError, ValueError, RecursionError) as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(f"is not YAML: {one_line(error, 100)}") from error


def _document(events: Iterator[yaml.Event], max_nodes: int) -> Any:
    result: Any = None
    documents = nodes = 0
    open_nodes: list[_Open] = []
    for event in events:
        if isinstance(event, yaml.DocumentStartEvent):
            documents += 1
            if documents > 1:
                raise FormatError("holds several YAML documents; give one")
            continue
        if isinstance(event, yaml.CollectionEndEvent):
            value = open_nodes.pop().value
        elif isinstance(event, yaml.NodeEvent):
            _refuse_references(event)
            nodes += 1
            if nodes > max_nodes:
                raise FormatError(f"has more than {max_nodes} values; split it")
            if isinstance(event, yaml.CollectionStartEvent):
                if len(open_nodes) == MAX_DEPTH:
                    raise FormatError(f"is nested more than {MAX_DEPTH} deep{_line(event)}")
                is_map = isinstance(event, yaml.MappingStartEvent)
                open_nodes.append(_Open({} if is_map else []))
                continue
            assert isinstance(event, yaml.ScalarEvent)
            null = event.style is None and event.value in ("", "~", "null", "Null", "NULL")
            value = None if null else event.value
        else:
            continue
        if open_nodes:
            open_nodes[-1].add(value, event)
        else:
            result = value
    return result


class _Open:
    """A mapping or list whose end has not come, and the key that waits for its value."""

    def __init__(self, value: dict[str, Any] | list[Any]) -> None:
        self.value = value
        self._key: str | None = None

    def add(self, value: Any, event: yaml.Event) -> None:
        if isinstance(self.value, list):
            self.value.append(value)
        elif self._key is not None:
            self.value[self._key] = value
            self._key = None
        elif not isinstance(value, str):
            raise FormatError(f"has a key that is no text{_line(event)}")
        elif value in self.value:
            raise FormatError(f"has the key {one_line(repr(value[:60]))} twice{_line(event)}")
        else:
            self._key = value


def _refuse_references(event: yaml.NodeEvent) -> None:
    if isinstance(event, yaml.AliasEvent) or event.anchor is not None:
        raise FormatError(
            f"has the anchor or alias {one_line(repr(event.anchor), 40)}{_line(event)}; write the "
            "value itself"
        )
    if getattr(event, "tag", None) is not None:
        raise FormatError(f"has a tag{_line(event)}; leave it out")


def _line(event: yaml.Event) -> str:
    return f" in line {event.start_mark.line + 1}"
