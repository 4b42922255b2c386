"""How many times its weight a grasp bears, by quasi-static increments (q_settled).

As the load test of the simulation has it (q_sim): from the snapshot the table goes away, the weight
grows from nothing, and the grasp has given way when the object has moved further in the hand than a
held one may.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from sdh_sim.settling.process import Allowed, Process
    from sdh_sim.settling.quasi_static import State

CAP = 20.0  # loads beyond this many weights are not looked for
COARSE, FINE = 0.15, 0.02  # growth of the load per increment, as a share of it (of 1 below 1)
STEP_BACK = 0.85  # the fine ramp starts where the load was this share of the coarse result
FREE_STEPS = 20  # increments at most without table or weight
WAIT_STEPS, SLOW = 60, 2e-4  # the load waits for a motion that is faster than that [m]
BALANCED = 2e-5  # at rest: no increment moves anything as far [m]


class Ramp(NamedTuple):
    """Where a ramp ended.

    Attributes:
        load: at which the object gave way, in weights; 0 where it does without any.
        capped: it bore the largest load that is looked for; ``load`` is that one.
    """

    load: float
    capped: bool


def load_ramp(process: Process, gripped: State, allowed: Allowed, cap: float = CAP) -> Ramp:
    """Let the weight grow until the object gives way.

    Args:
        process: of the grasp.
        gripped: its state before the table goes.
        allowed: motion in the hand since the snapshot that is none.
        cap: largest load to look for, in weights.
    """
    state = gripped
    for _ in range(FREE_STEPS):
        state = process.advance(state, 0.0)
        if allowed.exceeded_by(process.motion(state)):
            return Ramp(0.0, False)
        if state.moved < BALANCED:
            break
    coarse, states = _grow(process, 0.0, state, COARSE, allowed, cap)
    if coarse.capped:
        return coarse
    size, state = max((s for s in states if s[0] <= STEP_BACK * coarse.load), key=lambda s: s[0])
    return _grow(process, size, state, FINE, allowed, cap)[0]


def _grow(
    process: Process, size: float, state: State, rate: float, allowed: Allowed, cap: float
) -> tuple[Ramp, list[tuple[float, State]]]:
    """Let the load grow from a size on; also loads and states on the way, the first included."""
    states = [(size, state)]
    while size < cap:
        size = min(cap, size + rate * max(size, 1.0))
        for _ in range(WAIT_STEPS):
            state = process.advance(state, size)
            if allowed.exceeded_by(process.motion(state)):
                return Ramp(size, False), states
            if state.moved < SLOW:
                break
        states.append((size, state))
    return Ramp(cap, True), states
