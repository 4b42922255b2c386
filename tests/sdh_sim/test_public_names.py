"""The library's names: all there, documented, and imported only when used."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import graspq
import sdh_sim
from tests.support.repository import ROOT


@pytest.mark.parametrize("name", sdh_sim.__all__)
def test_every_public_name_is_its_modules_own(name):
    value = getattr(sdh_sim, name)
    module = sys.modules[f"sdh_sim.{sdh_sim._MODULE_OF[name]}"]
    assert value is getattr(module, name)
    assert name in dir(sdh_sim)


def test_the_table_of_modules_and_the_list_of_names_agree():
    assert sorted(sdh_sim._MODULE_OF) == sorted(sdh_sim.__all__)


def test_type_checkers_see_the_same_names():
    text = Path(sdh_sim.__file__).read_text(encoding="utf-8")
    block = text.split("if TYPE_CHECKING:\n")[1].split("\n\n")[0]
    tree = ast.parse(textwrap.dedent(block))
    seen = [a.name for n in tree.body if isinstance(n, ast.ImportFrom) for a in n.names]
    assert sorted(seen) == sorted(sdh_sim.__all__)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = sdh_sim.no_such_name


def test_importing_the_package_brings_nothing_heavy():
    code = "import sdh_sim, sys; print(*sorted(sys.modules))"
    result = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert not {"numpy", "mujoco", "pyarrow", "rerun"} & set(result.stdout.split())


@pytest.mark.parametrize("package", [graspq, sdh_sim], ids=lambda package: package.__name__)
def test_the_reference_has_every_public_name_and_no_other(package):
    page = ROOT / "docs" / "api" / f"{package.__name__}.md"
    listed = re.findall(rf"^::: {package.__name__}\.(\w+)$", page.read_text(), re.MULTILINE)
    assert sorted(listed) == sorted(package.__all__)


@pytest.mark.parametrize("package", [graspq, sdh_sim], ids=lambda package: package.__name__)
def test_type_information_ships(package):
    assert (Path(package.__file__).parent / "py.typed").is_file()
