"""Words that were replaced do not come back: in names, comments, messages and pages.

``CONTRIBUTING.md`` has the word to use for each. A name is read as its words: ``keep_it`` and
``KeepIt`` as "keep it".
"""

from __future__ import annotations

import re

import pytest

from tests.support.repository import ROOT

THING = r"things?"
SHEET = r"(?<!data[ \n])(?<!style[ \n])sheets?"
# What must not occur, as a regular expression over whole words, and what to say instead.
REPLACED = {
    THING: "what it is: the object, the contact, ...",
    r"misperce\w*": "tracking error",
    r"keepers?": "session",
    r"desks?": "workspace",
    r"lanes?": "component, or vector",
    SHEET: "workspace",
    r"hop(e|es|ed|ing|eless\w*)": "what is checked",
    r"cells? (of|on) (the |a )?(pads?|fingertips?|fingers?|arrays?)": "taxel",
    r"(live|lit|dead|active|tactile|missing|neighbouring|counting|counted) cells?": "taxel",
    r"(find|plan|the|a) course": "motion plan",
    r"who is right": "which prediction is right",
    r"checked at the door": "checked when it is made",
    r"words? for its end": "message at the end",
    r"knife s edge": "near a limit",
    r"by a hair|a hair aside": "by how much",
}
# Where a word of the list is the field's own.
ALLOWED = {
    ("sdh_sim/modelgen/surface_nets.py", SHEET): "sheets of a surface",
    ("CHANGELOG.md", THING): "the old name of an attribute that pages showed",
    ("sdh_sim/sensing/perceived_grasp.py", THING): "that attribute",
    ("tests/sdh_sim/metrics/test_user_metrics.py", THING): "a test of that",
}
SELF = "tests/test_vocabulary.py"


def files() -> list[str]:
    """Every file of the project with words in it."""
    folders = ("sdh_sim", "graspq", "experiments", "tests", "docs", "models")
    paths = [*ROOT.glob("*.*"), *(p for folder in folders for p in (ROOT / folder).rglob("*.*"))]
    kinds = {".py", ".md", ".toml", ".yml", ".xml", ".css", ".j2", ".js", ".cff"}
    names = {str(p.relative_to(ROOT)) for p in paths if p.suffix in kinds}
    return sorted(names - {SELF})


def spoken(text: str) -> str:
    """A text with its names taken apart into words, in small letters, on one line each."""
    apart = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", text)
    return re.sub(r"[_\-'’]", " ", apart).lower()


def found_in(text: str, word: str) -> list[int]:
    """Lines on which a word occurs."""
    return [text.count("\n", 0, m.start()) + 1 for m in re.finditer(rf"\b(?:{word})\b", text)]


@pytest.fixture(scope="module")
def texts():
    found = {name: spoken((ROOT / name).read_text(encoding="utf-8")) for name in files()}
    found["CONTRIBUTING.md"], _, words = found["CONTRIBUTING.md"].partition("\n## words\n")
    assert "taxel" in words, "the table of words has moved"
    return found


@pytest.mark.parametrize(("word", "instead"), REPLACED.items(), ids=list(REPLACED))
def test_a_replaced_word_does_not_come_back(texts, word, instead):
    wrong = [
        f"{name}:{','.join(map(str, lines))}"
        for name, text in texts.items()
        if (name, word) not in ALLOWED and (lines := found_in(text, word))
    ]
    assert not wrong, f"say {instead!r} instead, in\n" + "\n".join(wrong)


def test_an_exception_is_needed(texts):
    spare = [key for key in ALLOWED if not found_in(texts.get(key[0], ""), key[1])]
    assert not spare


@pytest.mark.parametrize(
    ("text", "word", "count"),
    [
        ("nothing, anything", r"things?", 0),
        ("the_things = 1", r"things?", 1),
        ("class RunKeeper:", r"keepers?", 1),
        ("the data-sheet", SHEET, 0),
    ],
)
def test_names_are_read_as_words(text, word, count):
    assert len(found_in(spoken(text), word)) == count
