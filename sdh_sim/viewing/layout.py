"""The layout in which the viewer shows a recording."""

from __future__ import annotations

import numpy as np
import rerun.blueprint as rrb

from sdh_sim.robot import Hand
from sdh_sim.trial import TrialLog
from sdh_sim.viewing.style import FULL_SCALE, TIMELINE, WRENCH_SPACE

EYE_DISTANCE = 0.44  # [m]


def blueprint(log: TrialLog) -> rrb.Blueprint:
    """The workcell on the left; tactile images, torques, height and texts on the right."""
    limit = max(log.scene.torque_limit)
    lowest = min(-0.05 * limit, float(log.motor_torque.min()) * 1.1)
    pads = [
        rrb.Spatial2DView(
            origin=f"tactile/{name}",
            name=f"{name.replace('_', ' ')}, 0-{FULL_SCALE:.0f} N",
            background=(58, 60, 66),
        )
        for name in reversed_by_kind(log.scene.hand)
    ]
    torques = rrb.TimeSeriesView(
        origin="torque", name="motor torque [N m]",
        axis_y=rrb.ScalarAxis(range=(lowest, 1.15 * limit)),
        plot_legend=rrb.Corner2D.LeftTop,
    )  # fmt: skip
    texts = rrb.Tabs(
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
            rrb.Spatial3DView(origin="world", name="workcell", eye_controls=_eye(log)),
            rrb.Vertical(
                rrb.Grid(*pads, grid_columns=3), torques, texts,
                row_shares=[10, 9, 9],
            ),
            column_shares=[3, 2],
        ),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE),
        rrb.SelectionPanel(state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
    )  # fmt: skip


def reversed_by_kind(hand: Hand) -> list[str]:
    """Names of the pads, the last kind of array first: fingertips stand above."""
    kinds = list(hand.arrays)
    return [pad.name for pad in sorted(hand.pads, key=lambda pad: -kinds.index(pad.array.kind))]


def _eye(log: TrialLog) -> rrb.EyeControls3D:
    """View from behind the object and beside the approach: fingers, pads and object show."""
    scene = log.scene
    target = log.body_position[0, scene.object_body] + (0.0, 0.0, 0.06)
    toward = target - log.body_position[-1, scene.palm]
    heading = np.arctan2(toward[1], toward[0]) - np.pi / 3
    offset = np.array([np.cos(heading), np.sin(heading), 0.35]) * EYE_DISTANCE
    return rrb.EyeControls3D(
        position=target + offset, look_target=target, eye_up=(0.0, 0.0, 1.0), speed=0.5
    )
