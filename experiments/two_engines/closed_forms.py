"""Closed forms of ``experiments.validation`` in both engines: which one is nearer to mechanics.

    python -m experiments.two_engines.closed_forms

A box is squeezed by two fingers in MuJoCo and carried into Drake at rest. Friction is lowered until
it drops: Coulomb's law says at μ = m g / ΣN.
"""

from __future__ import annotations

from importlib.util import find_spec
from typing import NamedTuple

import mujoco
import numpy as np

from experiments.command_line import Parser, fail
from experiments.two_engines.alignment import ALIGNMENTS, NAMES, Alignment
from experiments.validation import friction
from experiments.validation.result_rows import threshold
from experiments.validation.rigs import GRAVITY, TEST_BODY_MASS, set_friction
from sdh_sim import poses
from sdh_sim.cell import Scene

SOLVERS = {"lagged": ALIGNMENTS[NAMES[-2]], "sap": ALIGNMENTS[NAMES[-1]]}
RAMP, FALL = 0.1, 0.3  # the weight grows, and a fall is waited for [s]


class Drop(NamedTuple):
    """Friction at which a clamped box drops.

    Attributes:
        predicted: m g / ΣN, with the normal forces of the same engine.
        found: by bisection; NaN where it lies outside half to one and a half times that.
    """

    predicted: float
    found: float


def hung_in_drake(
    scene: Scene, rest: mujoco.MjData, coefficient: float, alignment: Alignment
) -> tuple[float, float]:
    """Put the weight on a clamped box in Drake.

    Args:
        scene: of ``friction.clamp``; its friction is set.
        rest: the box at rest in the clamp.
        coefficient: of friction.
        alignment: of the translation.

    Returns:
        how far it sinks after the weight has grown [m], and the sum of the normal forces on it [N].
    """
    from experiments.two_engines.engine import DrakeSimulation
    from experiments.two_engines.translate import translate

    set_friction(scene, coefficient)
    palm, box = poses.body_pose(rest, scene.palm), poses.body_pose(rest, scene.object_body)
    simulation = DrakeSimulation(translate(scene, palm, box, alignment))
    simulation.set_to(rest.qpos, box, rest.ctrl[scene.motors])
    ticks = round(RAMP / simulation.tick_time)
    for k in range(1, ticks + 1):
        force = np.array([k / ticks * TEST_BODY_MASS * GRAVITY, 0.0, 0.0])
        simulation.set_force(force, np.zeros(3))
        simulation.tick()
    before, grip = simulation.object_in_hand()[0], simulation.hand_force()
    for _ in range(round(FALL / simulation.tick_time)):
        simulation.tick()
    return float(simulation.object_in_hand()[0] - before), grip


def drop_in_drake(torque: float, alignment: Alignment) -> Drop:
    """Friction at which the box drops that motors at a torque [N m] squeeze."""
    scene, rest = friction.clamp((torque, 1.0934))
    _, grip = hung_in_drake(scene, rest, 1.0, alignment)
    predicted = TEST_BODY_MASS * GRAVITY / grip

    def drops(inverse: float) -> bool:
        return hung_in_drake(scene, rest, 1.0 / inverse, alignment)[0] > friction.DROP

    return Drop(predicted, 1.0 / threshold(drops, 0.5 / predicted, 1.5 / predicted))


def main(argv: list[str] | None = None) -> None:
    """Print the comparison."""
    Parser(__doc__).parse_args(argv)
    if find_spec("pydrake") is None:
        fail('the second engine, Drake, is not installed: pip install -e ".[crosscheck]"')
    for row in friction.clamp_drop(short=True).rows:
        print(_line("MuJoCo", Drop(row.predicted, row.simulated)))
    for name, alignment in SOLVERS.items():
        print(_line(f"Drake, {name}", drop_in_drake(1.6401, alignment)))


def _line(engine: str, drop: Drop) -> str:
    off = drop.found / drop.predicted - 1.0
    return f"{engine}: predicted {drop.predicted:.4f}, found {drop.found:.4f}, {off:+.2%}"


if __name__ == "__main__":
    main()
