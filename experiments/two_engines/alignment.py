"""What may differ between the engines beside their solvers, and in which order it is aligned."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

GUESSED_DEMAND = 1.1  # torque that a saturated motor's servo is taken to ask for, over its limit
HARD = 3e4  # stiffness of contacts without rubber, where it is not taken from MuJoCo [N/m]
DISSIPATION = 5.0  # of contacts, where it is not taken from MuJoCo [s/m]


@dataclass(frozen=True)
class Alignment:
    """Which known differences are taken away; each is one of the fields.

    Attributes:
        references: servo references are those of the trial, not guessed from the torques.
        points: the object stands on the table with the corners of its collision shapes, as in
            MuJoCo, not with the one deepest point.
        table: friction of the table and stiffness of its contacts are MuJoCo's; else the object's
            friction, and that of hard parts.
        hard: contacts without rubber are as stiff as MuJoCo has them; else ``HARD``.
        lift: the hand rises, as in the trial; else the table falls.
        dissipation: contacts lose as much energy as in MuJoCo (linear in the speed, with the time
            constant that its contacts have), and Drake solves them by its convex approximation
            ``sap``, in which as in MuJoCo's a contact that slips presses harder, and what sticks
            creeps as little; else ``DISSIPATION`` by Hunt and Crossley, solved by ``lagged``, in
            which what slips presses no harder, and what sticks creeps by up to 0.1 mm/s.
    """

    references: bool = False
    points: bool = False
    table: bool = False
    hard: bool = False
    lift: bool = False
    dissipation: bool = False


NAMES = tuple(field.name for field in fields(Alignment))
"""Of the differences, in the order in which they are aligned."""


def levels() -> dict[str, Alignment]:
    """Nothing aligned (``none``), then one difference after the other (named by the last one)."""
    found = {"none": Alignment()}
    last = found["none"]
    for name in NAMES:
        last = replace(last, **{name: True})
        found[name] = last
    return found


ALIGNMENTS = levels()
FULL = NAMES[-1]
"""Name of the alignment with all known differences taken away."""
ALIGNED = ALIGNMENTS[FULL]
