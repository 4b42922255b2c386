"""A file of graspq imports only from lower layers, lazily too, and never in a circle."""

import ast

from tests.support.repository import ROOT

# Ground first; what is in one line may import from the same line, without a circle.
LAYERS = (
    ("errors", "scaling_result", "_compiled"),
    ("ellipsoid", "limits", "transmission"),
    ("contact", "inputs"),
    ("tasks", "hand_bound"),
    ("_engines", "forces"),
    ("scaling", "ball", "volume", "hand_scaling"),
    ("batch", "wrench_space"),
    ("",),
)
LEVEL = {name: level for level, names in enumerate(LAYERS) for name in names}


def imports():
    """Every module of graspq and the modules of graspq that it imports."""
    folder = ROOT / "graspq"
    files = {
        ".".join(p.relative_to(folder).with_suffix("").parts).removesuffix("__init__").strip("."): p
        for p in folder.rglob("*.py")
    }
    found = {}
    for name, path in files.items():
        found[name] = set()
        for node in ast.walk(ast.parse(path.read_text())):
            wanted = []
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("graspq"):
                inside = node.module.removeprefix("graspq").strip(".")
                wanted = [f"{inside}.{a.name}".strip(".") for a in node.names] + [inside]
            elif isinstance(node, ast.Import):
                wanted = [a.name.removeprefix("graspq.") for a in node.names if "graspq" in a.name]
            found[name] |= {w for w in wanted if w in files and w not in ("", name)}
    return found


def test_no_arrow_goes_up():
    for name, used in imports().items():
        for other in used:
            assert LEVEL[other.split(".")[0]] <= LEVEL[name.split(".")[0]], f"{name} -> {other}"


def test_there_is_no_circle():
    left = imports()
    while left:
        ground = [name for name, used in left.items() if not used & left.keys()]
        assert ground, f"in a circle, or above one: {sorted(left)}"
        for name in ground:
            del left[name]


def test_compiled_code_needs_numpy_and_numba_alone():
    import sys

    for path in (ROOT / "graspq" / "_compiled").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = []
            if isinstance(node, ast.Import):
                names = [a.name for a in node.names]
            elif isinstance(node, ast.ImportFrom) and not node.level:
                names = [node.module]
            for name in names:
                top = name.split(".")[0]
                assert top in ("graspq", "numpy", "numba") or top in sys.stdlib_module_names
