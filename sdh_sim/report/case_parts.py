"""Parts of the page about single trials: marks on dots, the worst mispredictions, every trial."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from sdh_sim.analysis.cases import Case, Mistake, worst
from sdh_sim.analysis.comparison import METRICS, THRESHOLD, name_of
from sdh_sim.analysis.study import Study
from sdh_sim.report.dots import MOST, Dot, answering, outcome, say, value_text
from sdh_sim.report.look import Look
from sdh_sim.report.page import Exhibit, Exhibits, Mark, Paragraph, Part, Section, Table
from sdh_sim.report.table_cells import object_name

TRIALS = "trials"  # name of the table of every trial
LISTED = 8  # worst mispredictions, where no more pictures are asked for


def marks_of(dots: Sequence[Dot], cases: Sequence[Case], look: Look) -> list[Mark]:
    """What the dots of a figure say; their cases by number."""
    return [
        Mark(d.x, d.y, d.case, say(cases[d.case], [d.metric]), look.command(cases[d.case]))
        for d in dots
    ]


def worst_section(study: Study, look: Look) -> Section:
    """The worst mispredictions, with pictures of the first of them."""
    found = worst(study.cases, METRICS, THRESHOLD, max(LISTED, look.photographs))
    if not found:
        return Section("Worst mispredictions", [Paragraph("No trial was mispredicted.")])
    lead = (
        "In turn, of each metric, the failed grasps with the highest q* above the threshold and "
        "the held ones with the lowest below it; each trial once."
    )
    parts: list[Part] = [Paragraph(lead + (f" {look.hint}" if look.hint else ""))]
    entries, failed = [], []
    for number, mistake in enumerate(found):
        jpeg, note = b"", ""
        if look.photograph is not None and number < look.photographs:
            got = look.photograph(mistake.case)
            jpeg, note = (got, "") if isinstance(got, bytes) else (b"", got)
            if note:
                failed.append((note, mistake.case))
        entries.append(Exhibit(_mistake_text(mistake, look), look.command(mistake.case), jpeg))
    for note, group in groupby(failed, key=lambda pair: pair[0]):
        numbers = ", ".join(str(case.trial) for _, case in group)
        parts.append(Paragraph(f"No picture of trial {numbers}: {note}"))
    return Section("Worst mispredictions", [*parts, Exhibits(entries)])


def _mistake_text(mistake: Mistake, look: Look) -> str:
    case, metric, rank = mistake
    end, said = ("Held", "failure") if case.success else ("Failed", "success")
    text = f"{end} although {name_of(metric)} predicted {said} (number {rank} of these): "
    text += say(case, [m for m in METRICS if m in case.scores])
    if case.success and case.q_reason:
        text += f". Why L∞ says 0: {case.q_reason}"
    return text + _run(case, look)


def _run(case: Case, look: Look) -> str:
    return f" (run {look.names[case.source]})" if len(look.names) > 1 else ""


def trials_section(study: Study, look: Look) -> Section:
    """Every trial in a table that is folded away; the data behind the dots."""
    cases = answering(study.cases)
    if not cases:
        why = f"These are more than {MOST} trials: their dots do not answer. The table of trials "
        return Section("Every trial", [Paragraph(why + "of each run has them all.")])
    several = len(look.names) > 1
    metrics = study.scalings
    tested = any(case.q_sim is not None for case in cases)
    head = [
        *(["run"] if several else []),
        *("object", "trial", "seed", "outcome"),
        *(name_of(metric) for metric in metrics),
        *(["q_sim"] if tested else []),
    ]
    rows = [
        [
            *([look.names[case.source]] if several else []),
            *(object_name(case.object), str(case.trial), str(case.seed), outcome(case)),
            *(_cell(case.scores[metric]) for metric in metrics),
            *([("≥ " if case.capped else "") + _cell(case.q_sim)] if tested else []),
        ]
        for case in cases
    ]
    text = (0, 1, 4) if several else (0, 3)
    table = Table(f"All {len(cases)} trials compared", head, rows, text, (), TRIALS, folded=True)
    example = look.command(cases[0])
    way = [Paragraph(f"To look at one: {example}, or the number of another.")] if example else []
    return Section("Every trial", [*way, table])


def _cell(value: float | None) -> str:
    return "–" if value is None else value_text(value)
