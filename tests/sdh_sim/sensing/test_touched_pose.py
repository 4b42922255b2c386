"""A tracked pose corrected by touch: what a grip tells, and what it cannot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sdh_sim import poses
from sdh_sim.errors import SettingsError
from sdh_sim.objects import object_info, object_spec
from sdh_sim.objects.collision_shape import collision_vertices
from sdh_sim.robot import built_in_hand, hand_kinematics
from sdh_sim.sensing import TactileSnapshot, touched_pose
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial
from sdh_sim.trial.outcome import moved_between

BOX = object_info("box")
WIDTH = 0.071  # of the box along its x [m]
ERRORS = 0.003, np.radians(2.0)
KINEMATICS = hand_kinematics(built_in_hand("parallel_jaw"))
LEVEL = np.array([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0])  # a hand far above the table


def pad_centres(angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Middle of both pads' surfaces in the palm frame (3,) [m]."""
    posture = KINEMATICS.at(np.array([angle]))
    found = []
    for pad in KINEMATICS.hand.pads:
        rows, columns = pad.array.shape
        point, _ = pad.array.surface(0.5 * (rows - 1), 0.5 * (columns - 1))
        position, rotation = posture.link(pad.body)
        found.append(position + rotation @ point)
    return found[0], found[1]


def grip() -> tuple[TactileSnapshot, np.ndarray]:
    """The jaw closed on the box, all taxels loaded; and the closing axis (3,)."""
    low, high = KINEMATICS.hand.motors[0].span
    gaps = np.array([np.linalg.norm(np.subtract(*pad_centres(a))) for a in (low, high)])
    angle = float(np.interp(WIDTH, np.sort(gaps), np.array([low, high])[np.argsort(gaps)]))
    assert low < angle < high
    first, second = pad_centres(angle)
    assert np.linalg.norm(first - second) == pytest.approx(WIDTH, abs=1e-6)
    axis = (second - first) / WIDTH
    # The box's x along the closing axis, its middle between the pads.
    side = np.cross([0.0, 0.0, 1.0], axis)
    rotation = np.column_stack((axis, side / np.linalg.norm(side), np.cross(axis, side)))
    pose = np.concatenate((0.5 * (first + second), poses.quaternion_of(rotation)))
    arrays = {p.array.kind: p.array for p in KINEMATICS.hand.pads}
    tactile = {k: np.full((2, *a.shape), 50.0) * a.live for k, a in arrays.items()}
    middle = poses.transform(pose, box_middle())
    pose[:3] += 0.5 * (first + second) - middle
    return TactileSnapshot(tactile, np.array([angle]), np.array([0.0]), pose, LEVEL), axis


def box_points() -> np.ndarray:
    """Corners of the box in its own frame (8, 3) [m]."""
    return collision_vertices(object_spec("box").compile())


def box_middle() -> np.ndarray:
    """Middle of the box in its own frame (3,) [m]."""
    return 0.5 * (box_points().min(axis=0) + box_points().max(axis=0))


def corrected(seen: TactileSnapshot) -> np.ndarray:
    return touched_pose(seen, BOX, *ERRORS, KINEMATICS, on_table=False)


def shifted(snapshot: TactileSnapshot, by: np.ndarray) -> TactileSnapshot:
    pose = snapshot.object_pose_hand.copy()
    pose[:3] += by
    return replace(snapshot, object_pose_hand=pose)


def test_a_pose_that_fits_stays():
    snapshot, _ = grip()
    moved, turned = moved_between(snapshot.object_pose_hand, corrected(snapshot), BOX.com_m)
    assert moved < 0.05
    assert turned < 0.1


def test_an_error_along_the_grip_is_found_and_one_along_the_pads_is_not():
    snapshot, axis = grip()
    along = np.cross(axis, [0.0, 0.0, 1.0])
    seen = shifted(snapshot, 0.003 * axis + 0.002 * along)
    left = corrected(seen)[:3] - snapshot.object_pose_hand[:3]
    # Two pads of 1 mm each against 3 mm of the tracker: 3 · (1/9) / (1/9 + 2) = 0.16 mm are left.
    assert left @ axis == pytest.approx(0.003 / (1.0 + 2.0 * 9.0), abs=0.1e-3)
    assert left @ along == pytest.approx(0.002, abs=0.05e-3)


def test_a_light_lit_taxel_is_not_believed():
    # A tenth of the largest reading, as crosstalk gives, on a pad that is otherwise right.
    snapshot, axis = grip()
    (kind,) = snapshot.tactile
    reading = 0.1 * snapshot.tactile[kind]
    reading[:, 3:6, 2:4] = 50.0
    seen = shifted(replace(snapshot, tactile={kind: reading}), 0.003 * axis)
    left = corrected(seen)[:3] - snapshot.object_pose_hand[:3]
    assert abs(left @ axis) < 0.3e-3


def test_the_table_corrects_the_height():
    # A hand whose z points along the world's, the box standing 2 mm too high.
    snapshot, _ = grip()
    turned = poses.rotation_of(snapshot.object_pose_hand[3:]) @ box_points().T
    stands = LEVEL.copy()
    stands[2] = -(snapshot.object_pose_hand[2] + turned[2].min())  # its foot at the table's height
    seen = shifted(replace(snapshot, hand_pose_world=stands), np.array([0.0, 0.0, 0.002]))
    left = touched_pose(seen, BOX, *ERRORS, KINEMATICS, on_table=True)
    assert abs(left[2] - snapshot.object_pose_hand[2]) < 0.3e-3
    assert abs(corrected(seen)[2] - snapshot.object_pose_hand[2]) > 1.5e-3


def test_errors_of_real_grasps_are_halved():
    settings = TrialSettings(
        "oval_bottle", grasps="precision", position_error=0.003, angle_error=ERRORS[1]
    )
    com = object_info("oval_bottle").com_m
    errors = []
    for touch in (False, True):
        trials = [Trial(replace(settings, touch=touch), seed) for seed in range(100, 104)]
        for trial in trials:
            trial.acquire()
            trial.snapshot()  # what is perceived is known before the lift
        rows = [trial.row for trial in trials]
        errors.append(
            [
                moved_between(row["object_pose_hand"], row["perceived_pose_hand"], com)[0]
                for row in rows
            ]
        )
    assert np.median(errors[1]) < 0.6 * np.median(errors[0])


def test_touch_needs_errors_that_are_declared():
    with pytest.raises(SettingsError, match="touch: got True with position_error 0"):
        TrialSettings("box", touch=True)
