"""How a recording is shown: the viewer's layout, and the colours of its series and taxels."""

from __future__ import annotations

import numpy as np
import rerun.blueprint as rrb

from sdh_sim.robot.pads import PAD_NAMES
from sdh_sim.trial.trial_log import TrialLog
from sdh_sim.viewing.wrench_space import WRENCH_SPACE

TIMELINE = "sim_time"
FULL_SCALE = 2.0  # taxel force at the bright end of every colour map [N]
FORCE_SCALE = 0.006  # length of a contact force's arrow [m/N]
LIMIT_SCALE = 0.002  # length of the arrow of a predicted contact's g* [m/N]
EYE_DISTANCE = 0.44  # [m]

MOTOR_COLORS = [
    (120, 120, 120), (220, 60, 60), (250, 160, 120), (60, 90, 220), (120, 190, 250),
    (40, 150, 70), (160, 220, 110),
]  # fmt: skip
# Name, a motor that has this limit, colour.
SERIES_OF_LIMIT = (
    ("spread and proximal", "finger1_proximal", (255, 60, 200)),
    ("distal", "finger1_distal", (255, 150, 0)),
)

# Colours of a taxel from no force to full scale.
_HEAT = np.array([(45, 45, 55), (120, 30, 110), (220, 60, 60), (250, 160, 30), (255, 250, 150)])


def heat_colors(force: np.ndarray) -> np.ndarray:
    """Colours 0xRRGGBBAA uint32 of forces [N], same shape."""
    share = np.sqrt(np.clip(force / FULL_SCALE, 0.0, 1.0))  # light touches show too
    stops = np.linspace(0.0, 1.0, len(_HEAT))
    rgb = [np.interp(share, stops, _HEAT[:, k]).astype(np.uint32) for k in range(3)]
    return (rgb[0] << 24) | (rgb[1] << 16) | (rgb[2] << 8) | np.uint32(255)


def blueprint(log: TrialLog) -> rrb.Blueprint:
    """The cell on the left; tactile images, torques, height and words on the right."""
    limit = max(log.scene.settings.torque_limit)
    lowest = min(-0.05 * limit, float(log.motor_torque.min()) * 1.1)
    pads = [
        rrb.Spatial2DView(
            origin=f"tactile/{name}",
            name=f"{name.replace('_', ' ')}, 0-{FULL_SCALE:.0f} N",
            background=(58, 60, 66),
        )
        for name in sorted(PAD_NAMES, key=lambda name: "proximal" in name)
    ]
    torques = rrb.TimeSeriesView(
        origin="torque", name="motor torque [N m]",
        axis_y=rrb.ScalarAxis(range=(lowest, 1.15 * limit)),
        plot_legend=rrb.Corner2D.LeftTop,
    )  # fmt: skip
    words = rrb.Tabs(
        rrb.TextDocumentView(origin="verdict", name="verdict"),
        rrb.Spatial3DView(
            origin=WRENCH_SPACE, name="wrench space [N]", line_grid=rrb.LineGrid3D(visible=False)
        ),
        rrb.TextLogView(origin="phase", name="phases"),
        rrb.TimeSeriesView(origin="object_height", name="object height [mm]"),
        active_tab=0,
    )
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Spatial3DView(origin="world", name="cell", eye_controls=_eye(log)),
            rrb.Vertical(
                rrb.Grid(*pads, grid_columns=3), torques, words,
                row_shares=[10, 9, 9],
            ),
            column_shares=[3, 2],
        ),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE),
        rrb.SelectionPanel(state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
    )  # fmt: skip


def _eye(log: TrialLog) -> rrb.EyeControls3D:
    """From beyond the object, to the side of the hand's approach: fingers, pads and object show."""
    scene = log.scene
    target = log.body_position[0, scene.object_body] + (0.0, 0.0, 0.06)
    toward = target - log.body_position[-1, scene.palm]
    heading = np.arctan2(toward[1], toward[0]) - np.pi / 3
    offset = np.array([np.cos(heading), np.sin(heading), 0.35]) * EYE_DISTANCE
    return rrb.EyeControls3D(
        position=target + offset, look_target=target, eye_up=(0.0, 0.0, 1.0), speed=0.5
    )
