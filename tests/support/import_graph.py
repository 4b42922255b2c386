"""Which file imports which, read from the source: nothing is run.

A file imports another *on load* where the import stands at module level, *lazily* where it stands
inside a function, and *for types* below ``if TYPE_CHECKING``. A name that comes through a door (a
package's ``__init__``) is followed to the file that defines it: arrows are between files.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

LOAD, LAZY, TYPES = "on load", "lazily", "for types"


@dataclass(frozen=True, order=True)
class Arrow:
    """One file imports another; both are module names, a door's is its package's."""

    source: str
    target: str
    when: str

    def __str__(self) -> str:
        return f"{self.source} -> {self.target} ({self.when})"


class ImportGraph:
    """The files of some packages and the arrows between them.

    Args:
        root: folder that holds the packages.
        packages: names of the packages.

    Attributes:
        trees: syntax tree of every module, by its name.
        doors: modules that are a package's ``__init__``.
    """

    def __init__(self, root: Path, packages: Iterable[str]) -> None:
        self.trees: dict[str, ast.Module] = {}
        self.doors: set[str] = set()
        for package in packages:
            for path in sorted((root / package).rglob("*.py")):
                parts = path.relative_to(root).with_suffix("").parts
                name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
                if parts[-1] == "__init__":
                    self.doors.add(name)
                self.trees[name] = ast.parse(path.read_text(encoding="utf-8"), str(path))

    @cached_property
    def arrows(self) -> list[Arrow]:
        """Every arrow, once for each way in which a file imports another."""
        return sorted(
            {
                Arrow(source, target, when)
                for source, tree in self.trees.items()
                for statement, when in imports_in(tree)
                for target in self._targets(source, statement)
                if target != source
            }
        )

    def targets(self, *kinds: str) -> dict[str, set[str]]:
        """For each file, those that it imports in one of these ways."""
        found: dict[str, set[str]] = {name: set() for name in self.trees}
        for arrow in self.arrows:
            if arrow.when in kinds:
                found[arrow.source].add(arrow.target)
        return found

    def _targets(self, source: str, statement: ast.Import | ast.ImportFrom) -> Iterator[str]:
        for alias in statement.names:
            absolute = isinstance(statement, ast.Import)
            name = alias.name if absolute else f"{statement.module}.{alias.name}"
            target = self.defined_in(name)
            if target in self.doors:  # from sdh_sim import records; records.stack(...)
                bound = alias.asname or name.rpartition(".")[2]
                used = {
                    node.attr
                    for node in ast.walk(self.trees[source])
                    if isinstance(node, ast.Attribute) and ast.unparse(node.value) == bound
                }
                yield from {self.defined_in(f"{target}.{x}") or target for x in used} or {target}
            elif target is not None:
                yield target

    def defined_in(self, name: str) -> str | None:
        """The file of a module, or of what a module holds; None where it is of no package here."""
        if name in self.trees:
            return name
        module, _, what = name.rpartition(".")
        if module not in self.trees:
            return None
        origin = self._exported.get(module, {}).get(what)
        return module if origin is None else self.defined_in(origin) or module

    @cached_property
    def _exported(self) -> dict[str, dict[str, str]]:
        """Where each door has its names from, also those that only type checkers see there."""
        return {
            door: {
                alias.asname or alias.name: f"{statement.module}.{alias.name}"
                for statement, when in imports_in(self.trees[door])
                if isinstance(statement, ast.ImportFrom) and when != LAZY
                for alias in statement.names
            }
            for door in self.doors
        }


def imports_in(
    tree: ast.AST, when: str = LOAD
) -> Iterator[tuple[ast.Import | ast.ImportFrom, str]]:
    """The import statements below a node, each with when it runs."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            yield node, when
        elif isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)):
            yield from imports_in(node, LAZY if when == LOAD else when)
        elif isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            yield from imports_in(ast.Module(node.body, []), TYPES)
            yield from imports_in(ast.Module(node.orelse, []), when)
        else:
            yield from imports_in(node, when)


def circle(targets: dict[str, set[str]]) -> list[str]:
    """Files each of which imports the next, from one back to itself; empty where none do."""
    try:
        TopologicalSorter(targets).prepare()
    except CycleError as error:
        return error.args[1][::-1]
    return []


def longest_chains(targets: dict[str, set[str]]) -> dict[str, list[str]]:
    """For each file the longest chain of imports that starts with it; there must be no circle."""
    chains: dict[str, list[str]] = {}
    for name in TopologicalSorter(targets).static_order():
        chains[name] = [name, *max((chains[t] for t in sorted(targets[name])), key=len, default=[])]
    return chains
