"""All metrics by name: this project's own and those of the literature, and users' beside them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from sdh_sim.errors import SettingsError
from sdh_sim.metrics import (
    built_in,
    compliance,
    contact_geometry,
    grasp_map,
    posture,
    probability,
    slip,
    synthesis,
    wrench_space,
)
from sdh_sim.metrics.field_metric import FieldMetric
from sdh_sim.metrics.user_metrics import find_metrics, load_metric
from sdh_sim.sensing import PerceivedGrasp
from sdh_sim.user_references import UserMetric

ALL, FIELD = "all", "field"  # names of groups: every metric, and those of the literature
_HF = "Hard fingers at every active taxel, 12 edges, each contact's own greatest force"
_KRUG = "Krug, Bekiroglu and Roa 2017"
_UNSENSED = "contacts that no pad feels; what the object does when the table lets go"


def _scaling(name: str, label: str, bound: str, blind_to: str) -> FieldMetric:
    return FieldMetric(
        name, label, "task", built_in.METRICS[name], "weights",
        _KRUG if bound else "this project's own",
        f"{_HF}; {bound or 'bounds of the motors'}; the object's weight within the radius of its "
        "centre of mass.",
        blind_to, threshold=1.0, without_contact=0.0,
    )  # fmt: skip


OWN: tuple[FieldMetric, ...] = (
    _scaling("q_linf", "q* L∞", "L∞: each contact by itself", f"shared motors; {_UNSENSED}"),
    _scaling("q_l1", "q* L1", "L1: a sum for all contacts", f"shared motors; {_UNSENSED}"),
    _scaling("q_capability", "q* capability", "", _UNSENSED),
    _scaling("q_held", "q* held", "", f"that torques may change; {_UNSENSED}"),
    _scaling("q_whole_hand", "q* whole hand", "", "what the object does when the table lets go"),
    *(
        FieldMetric(
            f"{kind}_{bound}", f"{sign} {text}", "wrench space",
            built_in.METRICS[f"{kind}_{bound}"], unit,
            "Ferrari and Canny 1992; Miller and Allen 1999 (V)",
            f"{text} bound; {conventions}; 1 N beside 1 N m, moments about the centre of mass.",
            "the weight; shared motors; " + _UNSENSED, without_contact=0.0,
        )
        for kind, sign, unit, conventions in (
            ("epsilon", "ε", "N", _HF),
            ("volume", "V", "N³ (N m)³", "soft contacts at their centres, at most three"),
        )
        for bound, text in (("linf", "L∞"), ("l1", "L1"))
    ),
)  # fmt: skip
"""Metrics that every trial has a column of."""

LITERATURE: tuple[FieldMetric, ...] = (
    *wrench_space.METRICS,
    *grasp_map.METRICS,
    *contact_geometry.METRICS,
    *posture.METRICS,
    *compliance.METRICS,
    *slip.METRICS,
    *synthesis.METRICS,
    *probability.METRICS,
)
"""Metrics of the literature, by family."""
KNOWN = {metric.name: metric for metric in (*OWN, *LITERATURE)}


def chosen(asked: Sequence[str]) -> tuple[tuple[str, ...], tuple[UserMetric, ...]]:
    """What was asked for: names of known metrics, and users' own.

    Args:
        asked: ``all``, ``field``, names of ``KNOWN``, and users' metrics as ``find_metrics`` takes
            them; several may stand in one, with commas between.

    Raises:
        SettingsError: no such metric, or two of one name.
    """
    words = [word.strip() for text in asked for word in text.split(",") if word.strip()]
    known: list[str] = []
    others: list[str] = []
    for word in words:
        if word == ALL:
            known += KNOWN
        elif word == FIELD:
            known += [metric.name for metric in LITERATURE]
        elif word in KNOWN:
            known.append(word)
        else:
            others.append(word)
    unknown = [word for word in others if ":" not in word and not _installed(word)]
    if unknown:
        raise SettingsError(
            f"metrics: got {unknown[0]!r:.80}; give {ALL}, {FIELD}, a metric of your own as "
            f"file.py:function, or some of {', '.join(KNOWN)}"
        )
    own = find_metrics(others)
    refuse_twice(metric.name for metric in own)
    return tuple(dict.fromkeys(known)), own


def refuse_twice(own: Iterable[str]) -> None:
    """Raise SettingsError where a user's metric has the name of another one.

    Args:
        own: names of users' metrics.
    """
    taken = set(KNOWN)
    for name in own:
        if name in taken:
            raise SettingsError(
                f"metrics: there are two of the name {name}; give yours another name"
            )
        taken.add(name)


def _installed(name: str) -> bool:
    """Whether an entry point has that name."""
    try:
        find_metrics([name])
    except SettingsError:
        return False
    return True


def described(metric: UserMetric) -> FieldMetric:
    """A user's metric in the form of the others.

    ``high_is_good = False`` on the function says that low values are good.

    Raises:
        SettingsError: its code cannot be loaded.
    """
    return of_function(load_metric(metric), metric.name)


def of_function(
    function: Callable[[PerceivedGrasp], float], name: str | None = None
) -> FieldMetric:
    """A function of a perceived grasp in the form of the others.

    Args:
        function: its attributes ``threshold`` and ``high_is_good`` are read where it has them.
        name: of the metric; None takes the function's.

    Raises:
        SettingsError: a name or a threshold that cannot be used.
    """
    found = str(getattr(function, "__name__", "")) if name is None else name
    threshold = getattr(function, "threshold", None)
    checked = UserMetric(found, "function", "", threshold)
    return FieldMetric(
        found, found, "own", function, "", "yours", "", "",
        bool(getattr(function, "high_is_good", True)), checked.threshold,
    )  # fmt: skip
