"""The import rule: a room imports only from rooms below it, and no arrow closes a circle.

``docs/architecture.md`` has the rooms and the reason for their order. Imports inside functions
count as those at the top of a file do. Those for type checkers alone count for the layers (who
names a type knows its room), not for circles and chains (nothing is loaded).
"""

from __future__ import annotations

import ast
import sys

import pytest

from tests.support.import_graph import (
    LAZY,
    LOAD,
    TYPES,
    ImportGraph,
    circle,
    imports_in,
    longest_chains,
)
from tests.support.repository import ROOT

# Lowest first; the rooms of a level do not know each other, the files of the ground may.
GROUND = {
    "errors", "user_references", "setting_table", "settings", "run_options", "atomic_files",
    "model_files", "poses", "thread_limits", "graphics", "_version",
}  # fmt: skip
LEVELS = [
    GROUND,
    {"user_files"},
    {"robot", "objects", "records"},
    {"cell", "grasp_files", "analysis"},
    {"sensing", "runs", "report"},
    {"grasping", "metrics", "settling"},
    {"trial"},
    {"viewing"},
    {"campaign"},
    {"cli"},
    {"__main__"},
]
OLD_NAMES = {"perception", "sdh2_constants", "user_metrics"}  # they point users to the new ones
GRASPQ_LEVELS = [
    {"errors", "scaling_result", "transmission", "_compiled"},
    {"ellipsoid", "limits", "posture", "contact_arrays"},
    {"contact", "inputs", "grasp_maps", "contact_geometry"},
    {"tasks", "hand_bound", "edge_weights"},
    {"_engines", "forces", "compliance"},
    {"scaling", "ball", "volume", "hand_scaling", "robustness", "slip", "closure_residuals"},
    {"batch", "wrench_space", "synthesis_losses", "surface_wrenches", "warm_up"},
]
ON_A_TRIALS_WAY = (
    *("robot", "objects", "cell", "sensing", "grasping", "metrics", "settling", "trial"),
)

LONGEST_CHAIN = 13  # files
ABOVE_GROUND = 5  # imports between the simulation and a file that imports nothing of the package
SETTINGS_STOPS = 12  # files


@pytest.fixture(scope="module")
def graph():
    return ImportGraph(ROOT, ("sdh_sim", "graspq", "experiments"))


def part(module: str) -> str:
    """The room or ground file of a module; empty for the package's own ``__init__``."""
    return module.partition(".")[2].partition(".")[0]


def wrong_arrows(graph: ImportGraph, package: str, levels: list[set[str]], ground: set[str]):
    """Arrows inside a package that do not lead downwards, in words."""
    level = {name: k for k, names in enumerate(levels) for name in names}
    for arrow in graph.arrows:
        if {arrow.source.partition(".")[0], arrow.target.partition(".")[0]} != {package}:
            continue
        source, target = part(arrow.source), part(arrow.target)
        if not source or source in OLD_NAMES or source == "modelgen":
            continue
        inside = source == target or {source, target} <= ground
        if not inside and not level.get(target, len(levels)) < level.get(source, -1):
            yield str(arrow)


def loaded_files(graph: ImportGraph) -> dict[str, set[str]]:
    """What each file of ``sdh_sim`` imports of it on load, doors aside."""
    targets = graph.targets(LOAD)
    files = {name for name in targets if name.startswith("sdh_sim.")} - graph.doors
    return {name: targets[name] & files for name in files}


def test_every_file_has_its_place(graph):
    for package, levels, others in (
        ("sdh_sim", LEVELS, {"modelgen", *OLD_NAMES}),
        ("graspq", GRASPQ_LEVELS, set()),
    ):
        known = set().union(*levels, others)
        names = {part(name) for name in graph.trees if name.startswith(f"{package}.")}
        assert names <= known, f"say in this test where {names - known} of {package} belong"


def test_a_room_imports_only_from_lower_rooms(graph):
    wrong = list(wrong_arrows(graph, "sdh_sim", LEVELS, GROUND))
    assert not wrong, "\n".join(wrong)


def test_graspq_is_built_in_layers(graph):
    wrong = list(wrong_arrows(graph, "graspq", GRASPQ_LEVELS, set()))
    assert not wrong, "\n".join(wrong)


def test_what_writes_the_models_knows_the_robot_alone(graph):
    allowed = {"modelgen", "robot", *GROUND}
    wrong = [
        str(a)
        for a in graph.arrows
        if (part(a.source) == "modelgen" and part(a.target) not in allowed)
        or (part(a.target) == "modelgen" and part(a.source) != "modelgen")
    ]
    assert not wrong, "\n".join(wrong)


def test_nobody_imports_an_old_name(graph):
    old = {f"sdh_sim.{name}" for name in OLD_NAMES}
    wrong = [str(arrow) for arrow in graph.arrows if arrow.target in old]
    assert not wrong, "\n".join(wrong)


def test_a_file_imports_its_neighbours_not_the_door_of_its_room(graph):
    # Such a door is still being loaded when its own files ask it for names.
    wrong = [
        f"{name}: from {statement.module} import {alias.name}"
        for name, tree in graph.trees.items()
        if name not in graph.doors
        for statement, _ in imports_in(tree)
        if isinstance(statement, ast.ImportFrom) and statement.module == name.rpartition(".")[0]
        for alias in statement.names
        if f"{statement.module}.{alias.name}" not in graph.trees
    ]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize(
    ("package", "strangers"),
    [("graspq", {"mujoco", "sdh_sim", "experiments"}), ("sdh_sim", {"experiments", "tests"})],
)
def test_a_package_does_not_know_what_is_built_on_it(graph, package, strangers):
    wrong = []
    for name, tree in graph.trees.items():
        if name.partition(".")[0] != package:
            continue
        for statement, _ in imports_in(tree):
            modules = (
                [alias.name for alias in statement.names]
                if isinstance(statement, ast.Import)
                else [statement.module or ""]
            )
            wrong += [f"{name} -> {m}" for m in modules if m.partition(".")[0] in strangers]
    assert not wrong, "\n".join(wrong)


def test_compiled_code_needs_numpy_and_numba_alone(graph):
    allowed = {"graspq", "numpy", "numba", *sys.stdlib_module_names}
    wrong = [
        f"{name} -> {module}"
        for name, tree in graph.trees.items()
        if name.startswith("graspq._compiled")
        for statement, _ in imports_in(tree)
        for module in (
            [alias.name for alias in statement.names]
            if isinstance(statement, ast.Import)
            else [statement.module or ""]
        )
        if module.partition(".")[0] not in allowed
    ]
    assert not wrong, "\n".join(wrong)


def test_there_is_no_circle(graph):
    found = circle(graph.targets(LOAD, LAZY))
    assert not found, " -> ".join(found)


def test_no_chain_of_imports_is_long(graph):
    chain = max(longest_chains(loaded_files(graph)).values(), key=len)
    assert len(chain) <= LONGEST_CHAIN, f"{len(chain)} files: " + " -> ".join(chain)


def test_the_simulation_is_near_the_ground(graph):
    chain = longest_chains(loaded_files(graph))["sdh_sim.cell.simulation"]
    assert len(chain) - 1 <= ABOVE_GROUND, f"{len(chain) - 1} imports: " + " -> ".join(chain)


def test_few_files_handle_the_settings_of_a_trial(graph):
    """Files on a trial's way that read a ``TrialSettings`` or hand it on.

    A file counts when its code (annotations aside) uses the name ``settings``, an attribute
    ``.settings``, or a parameter annotated with ``TrialSettings``, whatever it is called.
    """
    found = {
        name: sorted(settings_used(tree))
        for name, tree in graph.trees.items()
        if name.startswith("sdh_sim.") and part(name) in ON_A_TRIALS_WAY and settings_used(tree)
    }
    assert len(found) <= SETTINGS_STOPS, f"{len(found)} files: {found}"
    assert "sdh_sim.trial.trial" in found, "the count finds nothing: have names changed?"


def settings_used(tree: ast.Module) -> set[int]:
    """Lines of a file that use a trial's settings."""
    arguments = [node for node in ast.walk(tree) if isinstance(node, ast.arg)]
    names = {
        argument.arg
        for argument in arguments
        if argument.annotation and "TrialSettings" in ast.unparse(argument.annotation)
    } | {"settings"}
    return {
        node.lineno
        for node in ast.walk(tree)
        if (isinstance(node, ast.Attribute) and node.attr == "settings")
        or (isinstance(node, ast.Name) and node.id in names and isinstance(node.ctx, ast.Load))
    }


def test_the_graph_sees_what_it_should(graph, tmp_path):
    files = {
        "a/__init__.py": "from a.low import Value\n",
        "a/low.py": "Value = 1\n",
        "a/high.py": "from typing import TYPE_CHECKING\nimport b\nif TYPE_CHECKING:\n"
        "    from b.late import x\ndef f():\n    from a import Value\n",
        "b/__init__.py": "",
        "b/late.py": "from a.high import f\nx = 1\n",
    }
    for path, text in files.items():
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_text(text, encoding="utf-8")
    small = ImportGraph(tmp_path, ("a", "b"))
    assert [str(arrow) for arrow in small.arrows] == [
        "a -> a.low (on load)",
        "a.high -> a.low (lazily)",
        "a.high -> b (on load)",
        "a.high -> b.late (for types)",
        "b.late -> a.high (on load)",
    ]
    assert circle(small.targets(LOAD, LAZY)) == []
    assert set(circle(small.targets(LOAD, LAZY, TYPES))) == {"a.high", "b.late"}
    assert longest_chains(small.targets(LOAD))["b.late"] == ["b.late", "a.high", "b"]
