"""The code blocks of the documentation: found, run, and what they print beside what pages show.

    python -m tests.support.doc_blocks PAGE

runs a page's blocks one after the other, as a notebook, and prints what each printed as JSON.
"""

from __future__ import annotations

import contextlib
import io
import json
import re
import shlex
import sys
from dataclasses import dataclass
from pathlib import Path

_FENCE = re.compile(r"^```(?P<tag>\S*)[^\n]*\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
_NUMBER = re.compile(r"-?\d+(\.\d+)?(e[-+]?\d+)?|\binf\b|\bnan\b")


@dataclass(frozen=True)
class Block:
    """A fenced block: its tag, its text, the line that its text starts on, its output if shown."""

    tag: str
    text: str
    line: int
    shown: str | None = None


def blocks(page: Path) -> list[Block]:
    """The Python blocks of a page; a ``text`` block right after one is what it prints."""
    text = page.read_text(encoding="utf-8")
    found: list[Block] = []
    end = -1
    for match in _FENCE.finditer(text):
        line = text.count("\n", 0, match.start("text")) + 1
        if match["tag"] == "python":
            found.append(Block("python", match["text"], line))
        elif match["tag"] == "text" and found and not text[end : match.start()].strip():
            last = found[-1]
            found[-1] = Block(last.tag, last.text, last.line, match["text"])
        end = match.end()
    return found


def shown_commands(page: Path) -> list[tuple[list[str], str]]:
    """The arguments of a page's ``sdh-sim`` commands, each with the output below it, if any."""
    text = page.read_text(encoding="utf-8")
    found = re.findall(r"^    (sdh-sim [a-z].*)\n(\n```text\n(?:.*\n)*?```)?", text, re.MULTILINE)
    return [
        (shlex.split(command)[1:], output.strip().removeprefix("```text").removesuffix("```"))
        for command, output in found
    ]


def run(page: Path) -> list[str]:
    """Run a page's blocks in one namespace; what each printed."""
    names: dict[str, object] = {"__name__": "__main__"}
    outputs = []
    for block in blocks(page):
        printed = io.StringIO()
        # Empty lines above, so that a traceback names the line of the page.
        code = compile("\n" * (block.line - 1) + block.text, str(page), "exec")
        with contextlib.redirect_stdout(printed):
            try:
                exec(code, names)
            except Exception as error:
                if type(error).__name__ != "RenderError":  # pictures need OpenGL, tests do not
                    raise
        outputs.append(printed.getvalue())
    return outputs


def words(text: str) -> str:
    """The output without its numbers and spacing, which differ from one processor to another."""
    return "".join(_NUMBER.sub("#", text).split())


if __name__ == "__main__":
    print(json.dumps(run(Path(sys.argv[1]))))
