"""The page docs/extending.md: its commands run and print what it shows."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pyarrow.parquet as pq

from sdh_sim.cli.app import main
from sdh_sim.records import FAILURES
from tests.support.doc_blocks import shown_commands
from tests.support.metric_files import EXAMPLE
from tests.support.repository import ROOT

PAGE = ROOT / "docs" / "extending.md"


def words(text: str) -> set[str]:
    """Words and file names; no numbers, and not how trials failed, which differ by machine."""
    return set(re.findall(r"[A-Za-z_∞*.]{3,}", text)) - set(FAILURES)


def test_the_page_does_what_it_says(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    source = re.search(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert source is not None
    assert EXAMPLE.read_text().endswith(source[1])
    facts = re.search(r"```toml\n(.*?)```", PAGE.read_text(), re.DOTALL)
    assert facts is not None
    assert facts[1] == (ROOT / "docs/examples/mug/object.toml").read_text()
    commands = shown_commands(PAGE)
    assert [arguments[0] for arguments, _ in commands] == ["objects", "lift", "lift", "compare"]
    for arguments, shown in commands:
        if "box" in arguments:
            continue  # takes long, and is the next one without metrics
        arguments = ["8" if a == "20" else a for a in arguments]
        assert main(arguments) == 0
        out = capsys.readouterr().out
        if arguments[0] == "objects":
            assert out.split() == shown.split()
        else:
            # Eight trials are too few for a best threshold.
            lines = [line for line in shown.splitlines() if not line.startswith("Best threshold:")]
            assert words("\n".join(lines)) <= words(out), out
    table: Any = pq.read_table(tmp_path / "runs/mug/trials.parquet")
    area = np.array(table.column("metric_contact_area").to_pylist(), float)
    assert np.nanmax(area) < 456 * 0.34**2
    assert (area[~np.isnan(area)] >= 0.0).all()
