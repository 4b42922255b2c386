"""The page answers back: every dot says its trial, tables sort, mispredictions are listed."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from html.parser import HTMLParser
from importlib.resources import files

import numpy as np
import pyarrow.parquet as pq
import pytest
from matplotlib.figure import Figure
from PIL import Image

from sdh_sim.analysis.cases import Case, mispredicted, worst
from sdh_sim.analysis.study import Study, read_study
from sdh_sim.records import write_rows
from sdh_sim.report import figure_style, write_report
from sdh_sim.report.case_parts import trials_section, worst_section
from sdh_sim.report.dots import POINTS, dots_of, draw_trials, say
from sdh_sim.report.look import Look

VOID = {"meta", "img", "br"}
COUNT = 16
FEW = 20


def rows() -> list[dict]:
    """Load-tested trials on two objects; one is infeasible, one held the largest load."""
    found = []
    for k in range(COUNT):
        load = 0.25 * k
        q = (1.3 * load + 0.1) if k % 4 else 0.0
        failure = "none" if load > 1.2 or k == 4 else "slipped"
        found.append({
            "trial": k, "object": ("box", "a <b> & c")[k % 2], "seed": 2**62 + k,
            "success": failure == "none", "failure": failure, "q_linf": q, "q_l1": 0.5 * q,
            "q_reason": "" if q else "no pads", "q_sim": load, "q_sim_capped": k == COUNT - 1,
            "unsensed_contact": k % 3 == 0,
        })  # fmt: skip
    found[5] |= {"success": False, "failure": "infeasible", "q_sim": None, "q_linf": None}
    found[6] |= {"q_l1": None}
    return found


class Page(HTMLParser):
    """What the tests need of a page; nesting is checked while reading."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.labels: list[list[str]] = []  # of each figure's dots
        self.marked: list[dict[str, str | None]] = []
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        assert len(given) == len(attrs), "an attribute twice"
        if tag not in VOID:
            self.open.append(tag)
        if "id" in given:
            self.ids.append(given["id"] or "")
        if tag == "a":
            self.links.append(given["href"] or "")
        if tag == "svg":
            assert given["role"] == "group"
            assert given["aria-label"]
            self.labels.append([])
        if tag == "circle":
            assert given["role"] == "img"
            self.marked.append(given)
        if tag == "img":
            assert given["alt"]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open[-2:] == ["circle", "title"]:
            self.labels[-1].append(data)


def look(case: Case) -> str:
    return f"sdh-sim show 'my run' --trial {case.trial}"


@pytest.fixture(scope="module")
def study(tmp_path_factory) -> Study:
    path = tmp_path_factory.mktemp("run") / "trials.parquet"
    write_rows(rows(), path)
    return read_study([path], resamples=FEW)


@pytest.fixture(scope="module")
def text(study, tmp_path_factory) -> str:
    folder = tmp_path_factory.mktemp("answers")
    return write_report(study, folder, "", look=Look(look)).read_text()


@pytest.fixture(scope="module")
def page(text) -> Page:
    return Page(text)


def test_every_dot_says_its_trial_and_how_to_look_at_it(page):
    known = {r["trial"]: r for r in rows() if r["failure"] != "infeasible"}
    tested = sorted([*known] * 2)  # under each of two metrics
    gave_way = [t for t in tested if t != COUNT - 1]
    found = []
    for labels in page.labels:
        found.append([])
        for label in labels:
            says, command = label.split("\n")
            trial = int(re.search(r"trial (\d+)", says)[1])  # type: ignore[index]
            row = known[trial]
            assert says.startswith(f"{row['object']}, trial {trial}, seed {row['seed']}: q* L")
            assert says.endswith("held" if row["success"] else "slipped")
            assert f"q_sim {'at least ' if trial == COUNT - 1 else ''}{row['q_sim']:.2f};" in says
            metric = "q_linf" if "q* L∞" in says else "q_l1"
            shown = "none" if row[metric] is None else f"{row[metric]:.2f}"
            assert f"{shown}, q_sim" in says
            assert command == f"sdh-sim show 'my run' --trial {trial}"
            found[-1].append(trial)
    assert [sorted(trials) for trials in found] == [tested, tested, gave_way]


def test_a_trial_has_the_same_number_in_every_figure(page):
    numbers = [mark["data-case"] for mark in page.marked]
    trials = [re.search(r"trial (\d+)", s)[1] for labels in page.labels for s in labels]  # type: ignore[index]
    assert len(numbers) == len(trials)
    assert len(set(zip(numbers, trials, strict=True))) == len(set(numbers)) == COUNT - 1


def test_ids_are_unique_and_links_lead_somewhere(page):
    assert len(set(page.ids)) == len(page.ids)
    assert {"trials", "rates-table", "metrics-table"} <= set(page.ids)
    assert "calibration-table" not in page.ids  # with fewer than ten of an outcome there is none
    assert len(page.links) == 6  # one a figure
    assert {link.removeprefix("#") for link in page.links} <= set(page.ids)


def test_the_table_behind_the_dots_has_the_same_numbers(study):
    *_, table = trials_section(study, Look(look)).parts
    known = [r for r in rows() if r["failure"] != "infeasible"]
    assert table.folded
    assert [row[1] for row in table.rows] == [str(r["trial"]) for r in known]
    for row, r in zip(table.rows, known, strict=True):
        assert row[2] == str(r["seed"])
        assert row[4] == f"{r['q_linf']:.2f}"
        assert row[5] == ("–" if r["q_l1"] is None else f"{r['q_l1']:.2f}")
        assert row[6].removeprefix("≥ ") == f"{r['q_sim']:.2f}"
    assert table.rows[-1][6].startswith("≥ ")


def test_the_data_of_a_figure_are_those_of_its_trials(study):
    for metric in study.load:
        tested = [case for case in study.cases if case.usable and case.q_sim is not None]
        assert [case.score(metric) for case in tested] == study.load[metric].q.tolist()
        for group in study.groups:
            own = [c for c in study.cases if c.usable and group in (c.object, "overall")]
            scored = study.findings[group, metric].scored
            assert [case.score(metric) for case in own] == scored.scores.tolist()
            assert [case.success for case in own] == scored.success.tolist()


def test_a_mark_lies_on_its_dot(study, tmp_path):
    with figure_style.style():
        figure = Figure(figsize=(3, 2), layout="constrained")
        axes = figure.add_subplot()
        axes.set_axis_off()
        axes.set(xlim=(0, 10), ylim=(0.1, 100), yscale="log")
        draw_trials(axes, np.array([2.0]), np.array([30.0]), study.cases[3:4], "q_l1",
                    marker="o", color="black", markersize=6)  # fmt: skip
        _, png = figure_style.save(figure, tmp_path / "dot")
    (dot,) = dots_of(figure)
    assert (dot.case, dot.metric) == (3, "q_l1")
    with Image.open(png) as image:
        dark = np.argwhere(np.asarray(image.convert("L")) < 128)
        scale = POINTS * 3 / image.size[0]
    assert (dot.y, dot.x) == pytest.approx(tuple((dark.mean(0) + 0.5) * scale), abs=0.3)


def test_the_worst_mispredictions_by_hand(study):
    promised, denied = mispredicted(study.cases, "q_linf", 1.0)
    assert [m.case.trial for m in promised] == [3]  # 1.3 * 0.75 + 0.1 > 1, slipped
    # q* of 0 under more load first.
    assert [m.case.trial for m in denied] == [12, 8, 4]
    assert [m.rank for m in denied] == [1, 2, 3]
    both = worst(study.cases, ("q_linf", "q_l1"), 1.0, 20)
    assert [(m.case.trial, m.metric) for m in both] == [
        (3, "q_linf"), (12, "q_linf"), (8, "q_linf"), (4, "q_linf"), (6, "q_l1"),
    ]  # fmt: skip
    assert [m.case.trial for m in worst(study.cases, ("q_linf",), 1.0, 2)] == [3, 12]


def test_pictures_stand_with_the_worst_or_it_is_said_why_not(study):
    asked = []

    def photograph(case: Case) -> bytes | str:
        asked.append(case.trial)
        return b"jpeg" if case.trial == 3 else "no headless OpenGL"

    section = worst_section(study, Look(look, ("run",), photograph, 3))
    assert asked == [3, 12, 8]
    *texts, listed = section.parts
    assert [entry.jpeg for entry in listed.entries] == [b"jpeg", *[b""] * 4]
    assert [p.text for p in texts[1:]] == ["No picture of trial 12, 8: no headless OpenGL"]
    assert listed.entries[0].text.startswith("Failed although q* L∞ predicted success (number 1 of")
    assert listed.entries[1].text.endswith("; held. Why L∞ says 0: no pads")
    assert listed.entries[0].command == "sdh-sim show 'my run' --trial 3"
    hinted = worst_section(study, Look(look, hint="Pictures: give some."))
    assert hinted.parts[0].text.endswith("Pictures: give some.")


def test_runs_are_told_apart(tmp_path):
    paths = []
    for name in ("one", "two"):
        paths.append(tmp_path / f"{name}.parquet")
        write_rows(rows(), paths[-1])
    both = read_study(paths, resamples=FEW)
    assert [case.source for case in both.cases] == [0] * COUNT + [1] * COUNT
    seen = Look(lambda case: f"{case.source}", ("one", "two"))
    *_, table = trials_section(both, seen).parts
    assert [row[0] for row in table.rows] == ["one"] * (COUNT - 1) + ["two"] * (COUNT - 1)
    assert worst_section(both, seen).parts[-1].entries[0].text.endswith("(run one)")


def test_a_table_that_does_not_say_which_trials_it_has(tmp_path):
    path = tmp_path / "trials.parquet"
    write_rows(rows(), path)
    pq.write_table(pq.read_table(path).drop_columns(["seed"]), path)
    assert read_study([path], resamples=FEW).cases == ()


def test_many_trials_do_not_answer(study, monkeypatch):
    monkeypatch.setattr("sdh_sim.report.dots.MOST", COUNT - 1)
    (sentence,) = trials_section(study, Look(look)).parts
    assert "their dots do not answer" in sentence.text


def test_what_a_dot_says_is_one_line(study):
    case = study.cases[6]
    assert case.scores["q_l1"] is None
    assert say(case, ["q_linf", "q_l1"]) == (
        f"box, trial 6, seed {2**62 + 6}: q* L∞ 2.05, q* L1 none, q_sim 1.50; held"
    )


SORTS = [
    (["2", "10", "–", "1"], ["1", "2", "10", "–"], ["10", "2", "1", "–"]),
    (["−0.1 (−0.2 to 0)", "0.05", "inf"], ["−0.1 (−0.2 to 0)", "0.05", "inf"],
     ["inf", "0.05", "−0.1 (−0.2 to 0)"]),
    (["≥ 20.00", "3.10", "1.2e-04"], ["1.2e-04", "3.10", "≥ 20.00"],
     ["≥ 20.00", "3.10", "1.2e-04"]),
    (["oval", "box", ""], ["box", "oval", ""], ["oval", "box", ""]),
]  # fmt: skip


def test_the_script_is_sound_and_sorts(tmp_path):
    node = shutil.which("node")
    if node is None:
        pytest.skip("no Node.js to check the page's script with")
    script = (files("sdh_sim.report") / "report.js").read_text(encoding="utf-8")
    file = tmp_path / "sorts.js"
    file.write_text(
        f"const document = {{ querySelectorAll: () => [] }};\n{script}\n"
        f"const sorts = {json.dumps([given for given, _, _ in SORTS])};\n"
        "console.log(JSON.stringify(sorts.map((given) => [1, -1].map((sign) => {\n"
        "  const order = comparison(given.map((text) => [text]), 0, sign);\n"
        "  return given.map((_, k) => k).sort(order).map((k) => given[k]);\n}))));\n",
        encoding="utf-8",
    )
    done = subprocess.run([node, file], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [[up, down] for _, up, down in SORTS]


def test_the_script_is_in_the_page_and_cannot_end_early(text):
    script = (files("sdh_sim.report") / "report.js").read_text(encoding="utf-8")
    assert script in text
    assert not re.search(r"</|<!--|eval|innerHTML|import|fetch", script)
