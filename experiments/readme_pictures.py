"""The README's pictures: one trial in three moments, and each object held by the hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from experiments.command_line import Parser
from sdh_sim.objects import PAPER_ORDER
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import TrialLog, run_trial
from sdh_sim.viewing.render import draw_frames, milestones

# First seed to try and approach of each object's picture, chosen for the view.
SHOWN = {
    "box": (3, "side"),
    "oval_bottle": (0, "top"),
    "spray_bottle": (1, "side"),
    "cylindrical_bottle": (1, "side"),
}


def held_trial(name: str, seed: int, approach: str) -> TrialLog:
    """The log of the first successful trial from a seed on."""
    for k in range(seed, seed + 50):
        row = run_trial(TrialSettings(object=name), k).row
        if row["success"] and row["approach"] == approach:
            log = run_trial(TrialSettings(object=name), k, log=True).log
            assert log is not None
            return log
    raise RuntimeError(f"no {approach} grasp of {name} holds in seeds {seed} to {seed + 49}")


def save(frames: list[np.ndarray], path: Path) -> None:
    """Write frames side by side as one PNG."""
    Image.fromarray(np.hstack(frames)).save(path, optimize=True)
    print(path)


def main(argv: list[str] | None = None) -> None:
    """Draw them all."""
    parser = Parser(__doc__)
    parser.add_argument("--out", type=Path, default=Path("docs/images"), help="folder")
    args = parser.parse_args(argv)
    args.out.mkdir(parents=True, exist_ok=True)
    logs = {name: held_trial(name, *SHOWN[name]) for name in PAPER_ORDER}
    ends = []
    for log in logs.values():
        ends += draw_frames(log, [milestones(log)[-1]], (420, 480), distance=0.72)
    save(ends, args.out / "objects.png")
    log = logs["spray_bottle"]
    save(list(draw_frames(log, milestones(log), (560, 520), distance=0.68)), args.out / "lift.png")


if __name__ == "__main__":
    main()
