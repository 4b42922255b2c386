"""How far the object slips aside in MuJoCo's lift, by how fast the arm's joints turn.

    python -m experiments.two_engines.arm_speed [--object box] [--seed 7]

The same snapshot is lifted by the arm within 1.5, 3, 6 and 12 s, and along a straight line by a
base that slides. Motion in the hand that comes from gravity stays as it is; what comes from the
turning of the arm's joints fades as they turn more slowly.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from experiments.command_line import Parser, at_least, fail
from experiments.two_engines.start import start_of
from experiments.two_engines.straight import straight_lift
from sdh_sim.errors import SettingsError
from sdh_sim.robot.palm_motion import at, minimum_jerk
from sdh_sim.runs import Job
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Motion, Trial
from sdh_sim.trial.lift import HOLD_TIME, LIFT_TIME
from sdh_sim.trial.outcome import watch

FACTORS = (1.0, 2.0, 4.0, 8.0)  # on the duration of the lift


def slower_lift(trial: Trial, state: np.ndarray, factor: float) -> Motion:
    """Lift and hold from a saved state, in so many times the usual duration."""
    simulation = trial.simulation
    simulation.restore(state)
    duration = factor * simulation.scene.palm_motion.duration(trial.motion.lift, LIFT_TIME)

    def references() -> Iterator[np.ndarray]:
        for k in range(1, round((duration + HOLD_TIME) / simulation.tick_time) + 1):
            yield at(trial.motion.lift, minimum_jerk(k * simulation.tick_time / duration))

    return watch(simulation, simulation.object_in_hand(), references())


def main(argv: list[str] | None = None) -> None:
    """Print the motions."""
    parser = Parser(__doc__)
    parser.add_argument("--object", default="box")
    parser.add_argument("--seed", type=int, default=7)
    args = parser.parse_args(argv)
    at_least(parser, args, seed=0)
    try:
        settings = TrialSettings(args.object, arm="rigid")
        trial = Trial(settings, args.seed)
    except SettingsError as error:
        fail(str(error))
    trial.acquire()
    state, pose = trial.simulation.save(), trial.simulation.object_in_hand()
    for factor in FACTORS:
        moved = slower_lift(trial, state, factor)
        print(f"arm, {factor * LIFT_TIME:4.1f} s: {moved.displacement_mm:.2f} mm")
    job = Job(trial=0, index=0, seed=args.seed, settings=settings)
    moved = straight_lift(start_of(job, {"object_pose_hand": pose}))
    print(f"straight, {LIFT_TIME:.1f} s: {moved.displacement_mm:.2f} mm")


if __name__ == "__main__":
    main()
