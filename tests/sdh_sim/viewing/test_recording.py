"""Recordings of a real trial, read back from the file."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from rerun.chunk import RrdReader
from scipy.spatial import ConvexHull

from sdh_sim.errors import RunError
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import TrialLog, run_trial
from sdh_sim.viewing.layout import blueprint
from sdh_sim.viewing.perceived_contacts import least_effort_forces
from sdh_sim.viewing.recording import recording_id, spawn_viewer, write_recording, write_recordings
from sdh_sim.viewing.style import FORCE_SCALE, LIMIT_SCALE, heat_colors
from tests.support.repository import ROOT
from tests.support.sdh2 import MOTOR_NAMES, PAD_NAMES, PAD_OFFSETS, live_mask, torque_limits

ARCHETYPES = {
    "Transform3D", "Mesh3D", "Boxes3D", "Points3D", "Arrows3D", "DepthImage", "Scalars",
    "TextLog", "TextDocument",
}  # fmt: skip
Columns = dict[tuple[str, str], list]
PREDICTED = "/world/object/object/predicted_contacts"


@pytest.fixture(scope="module")
def log() -> TrialLog:
    record = run_trial(TrialSettings("box"), 3, log=True).log
    assert record is not None
    return record


@pytest.fixture(scope="module")
def file(log: TrialLog, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recording") / "trial.rrd.tmp"
    write_recording(log, path)
    return path.rename(path.with_suffix(""))


@pytest.fixture(scope="module")
def columns(file: Path) -> Columns:
    return columns_of(file)


def columns_of(file: Path) -> Columns:
    """Every column of a file by entity and name, rows in the order they were sent."""
    found: Columns = {}
    for chunk in RrdReader(file).stream():
        batch = chunk.to_record_batch()
        for name in batch.schema.names:
            found.setdefault((str(chunk.entity_path), name), []).extend(batch[name].to_pylist())
    return found


def test_logged_bodies_are_where_the_logged_joints_put_them(log: TrialLog) -> None:
    # MuJoCo's own are a step behind: by 0.6 mm while the arm moves.
    model = log.scene.model
    data = mujoco.MjData(model)
    for joints, position, quat in zip(log.qpos, log.body_position, log.body_quat, strict=True):
        data.qpos[:] = joints
        mujoco.mj_kinematics(model, data)
        np.testing.assert_allclose(position, data.xpos, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(quat, data.xquat, rtol=0.0, atol=1e-12)
    rise = log.body_position[:, log.scene.object_body, 2]
    np.testing.assert_allclose(log.object_height, rise - rise[0], rtol=0.0, atol=1e-12)


def test_file_is_small_and_valid(file: Path) -> None:
    size = file.stat().st_size
    print(f"recording: {size / 1e6:.2f} MB")
    assert 0.2e6 < size < 5e6
    rerun = Path(sys.executable).with_name("rerun")
    checked = subprocess.run(
        [rerun, "rrd", "verify", file], capture_output=True, text=True, timeout=60
    )
    assert checked.returncode == 0, checked.stderr
    assert "without error" in checked.stdout + checked.stderr
    assert os.listdir(file.parent) == [file.name]  # nothing half-written stays


def test_the_layout_is_in_the_file(file: Path, log: TrialLog) -> None:
    reader = RrdReader(file)
    assert len(reader.blueprints()) == 1
    (recording,) = reader.recordings()
    assert recording.recording_id == recording_id(log)


def test_recordings_of_other_conditions_have_other_names(log: TrialLog) -> None:
    scene = replace(log.scene, settings=replace(log.scene.settings, sensor="ideal"))
    assert recording_id(replace(log, scene=scene)) != recording_id(log)


def test_tactile_images_are_the_logged_forces(columns: Columns, log: TrialLog) -> None:
    for index, name in enumerate(PAD_NAMES):
        images = columns[f"/tactile/{name}", "DepthImage:buffer"]
        got = np.array([np.frombuffer(bytes(row[0]), dtype=np.float32) for row in images])
        expected = log.tactile[:, PAD_OFFSETS[index] : PAD_OFFSETS[index + 1]]
        assert got.shape == expected.shape
        np.testing.assert_allclose(got, expected, rtol=1e-6)
        layout = columns[f"/tactile/{name}", "DepthImage:format"][0][0]
        rows, width = live_mask(name.rpartition("_")[2]).shape
        assert (layout["height"], layout["width"]) == (rows, width)
    assert log.tactile.max() > 1.0  # the hand did squeeze


def test_taxels_glow_where_the_force_is(columns: Columns, log: TrialLog) -> None:
    for index, name in enumerate(PAD_NAMES):
        live = live_mask(name.rpartition("_")[2])
        path = f"/world/hand/{name}/taxels"
        assert len(columns[path, "Points3D:positions"][0]) == live.sum()
        colors = np.array(columns[path, "Points3D:colors"])
        force = log.tactile[:, PAD_OFFSETS[index] : PAD_OFFSETS[index + 1]]
        np.testing.assert_array_equal(
            colors, heat_colors(force.astype(np.float32)[:, live.ravel()])
        )


def test_heat_rises_with_force() -> None:
    colors = heat_colors(np.array([0.0, 0.1, 0.5, 2.0, 20.0]))
    red = colors >> 24
    assert (np.diff(red.astype(int)) >= 0).all()
    assert red[0] < red[3]
    assert colors[3] == colors[4]
    assert (colors & 255 == 255).all()


def test_poses_of_every_body(columns: Columns, log: TrialLog) -> None:
    model = log.scene.model
    for body in range(1, model.nbody):
        path = f"/world/{model.body(body).name}"
        at = np.array(columns[path, "Transform3D:translation"])[:, 0]
        quat = np.array(columns[path, "Transform3D:quaternion"])[:, 0]
        frames = 1 if model.body_weldid[body] == 0 else len(log.time)
        np.testing.assert_allclose(at, log.body_position[:frames, body], atol=1e-6)
        np.testing.assert_allclose(
            quat, np.roll(log.body_quat[:frames, body], -1, axis=1), atol=1e-6
        )
    times = columns["/world/object/object", "sim_time"]
    seconds = [t.total_seconds() for t in times]
    np.testing.assert_allclose(seconds, log.time, atol=1e-6)


def test_every_visible_mesh_is_there_once(columns: Columns, log: TrialLog) -> None:
    model = log.scene.model
    shown = [g for g in range(model.ngeom) if model.geom_type[g] == 7 and model.geom_group[g] == 2]
    drawn = ("/wrench_space", "/world/object/object/friction_cones")
    meshes = [
        key for key in columns
        if key[1] == "Mesh3D:vertex_positions" and not key[0].startswith(drawn)
    ]  # fmt: skip
    assert len(meshes) == len(shown) > 30
    triangles = sum(len(columns[path, "Mesh3D:triangle_indices"][0]) for path, _ in meshes)
    assert triangles == sum(model.mesh_facenum[model.geom_dataid[g]] for g in shown)
    for path, _ in meshes:
        assert len(columns[path, "Mesh3D:vertex_normals"][0]) == len(
            columns[path, "Mesh3D:vertex_positions"][0]
        )
    assert ("/world/table/table", "Boxes3D:half_sizes") in columns


def test_contact_forces(columns: Columns, log: TrialLog) -> None:
    vectors = columns["/world/contact_forces", "Arrows3D:vectors"]
    assert len(vectors) == len(log.time)
    assert sum(len(frame) for frame in vectors) == sum(len(f) for f in log.contact_forces) > 100
    for frame, forces in zip(vectors, log.contact_forces, strict=True):
        np.testing.assert_allclose(
            np.reshape(frame, (-1, 3)) / FORCE_SCALE, forces, rtol=1e-4, atol=1e-4
        )


def test_predicted_contacts_point_into_the_object(columns: Columns, log: TrialLog) -> None:
    assert log.prediction is not None
    assert log.prediction.contacts
    (start,), (vector,) = (
        columns[PREDICTED, "Arrows3D:origins"],
        columns[PREDICTED, "Arrows3D:vectors"],
    )
    ends = np.array(start) + np.array(vector)
    assert len(ends) == len(log.prediction.contacts)
    assert (np.sum(np.array(vector) * -ends, axis=1) > 0.0).all()  # the frame is at the middle
    half = (0.0356, 0.09665, 0.0693)  # of the box [m]
    assert (np.abs(ends) < np.array(half) + 0.01).all()
    (time,) = columns[PREDICTED, "sim_time"]
    assert log.phase[int(np.argmin(np.abs(log.time - time.total_seconds())))] == "lift"


def test_forces_of_least_effort_bear_the_weight(columns: Columns, log: TrialLog) -> None:
    assert log.prediction is not None
    grasp = log.prediction.grasp
    path = "/world/object/object/least_effort_forces"
    (vector,), (start,) = columns[path, "Arrows3D:vectors"], columns[path, "Arrows3D:origins"]
    forces = np.array(vector) / LIMIT_SCALE
    assert len(forces) == len(grasp.contacts)
    np.testing.assert_allclose(forces.sum(axis=0), grasp.task[:3, 0], atol=1e-3)
    assert np.linalg.norm(forces.sum(axis=0)) == pytest.approx(log.row["mass_kg"] * 9.81, rel=1e-4)
    ends = np.array(start) + np.array(vector)
    at = np.array([pad.contact.position for pad in grasp.contacts]) + log.scene.obj.com_m
    np.testing.assert_allclose(ends, at, atol=1e-6)
    for force, pad in zip(forces, grasp.contacts, strict=True):
        normal = float(force @ pad.contact.normal)
        across = np.linalg.norm(force - normal * pad.contact.normal)
        assert 0.0 < normal <= pad.contact.max_normal_force
        assert across <= pad.contact.friction * normal * (1 + 1e-4)
    found = least_effort_forces(grasp)
    assert found is not None
    assert found.motor_torque is not None
    assert (np.abs(found.motor_torque) <= grasp.torque_limits * (1 + 1e-4)).all()
    labels = columns[path, "Arrows3D:labels"][0]
    assert labels == [
        f"{pad.pad} {np.linalg.norm(force):.1f} N"
        for pad, force in zip(grasp.contacts, forces, strict=True)
    ]
    assert columns[path, "sim_time"] == columns[PREDICTED, "sim_time"]
    ((text,),) = columns["/verdict", "TextDocument:text"]
    assert f"| forces of least effort for the weight | {', '.join(labels)} |" in text


def test_a_weight_that_no_forces_bear_has_no_such_entity(log: TrialLog, tmp_path: Path) -> None:
    assert log.prediction is not None
    grasp = log.prediction.grasp
    heavy = replace(grasp, task=100.0 * grasp.task)
    assert least_effort_forces(heavy) is None
    assert least_effort_forces(replace(grasp, contacts=())) is None
    file = tmp_path / "heavy.rrd"
    write_recording(replace(log, prediction=replace(log.prediction, grasp=heavy)), file)
    found = columns_of(file)
    paths = {path for path, _ in found}
    assert PREDICTED in paths
    assert "/world/object/object/least_effort_forces" not in paths
    ((text,),) = found["/verdict", "TextDocument:text"]
    assert "| none within friction and motor torques |" in text


def test_torques_beside_their_limits(columns: Columns, log: TrialLog) -> None:
    for index, name in enumerate(MOTOR_NAMES):
        values = np.array(columns[f"/torque/{name}", "Scalars:scalars"])[:, 0]
        np.testing.assert_allclose(values, log.motor_torque[:, index])
    proximal, distal = torque_limits(log.scene.settings.torque_limit)[1:3]
    assert columns["/torque/limit_proximal", "Scalars:scalars"] == [[proximal]] * 2
    assert columns["/torque/limit_distal", "Scalars:scalars"] == [[distal]] * 2
    height = np.array(columns["/object_height", "Scalars:scalars"])[:, 0]
    np.testing.assert_allclose(height, log.object_height * 1e3)


def test_words(columns: Columns, log: TrialLog) -> None:
    ((text,),) = columns["/verdict", "TextDocument:text"]
    row = log.row
    for expected in (row["object"], f"{row['q_linf']:.2f}", f"{row['q_l1']:.2f}",
                     f"{row['displacement_mm']:.2f} mm", row["preshape"], "1.640"):  # fmt: skip
        assert expected in text
    assert ("held" if row["success"] else row["failure"]) in text
    phases = [entry[0] for entry in columns["/phase", "TextLog:text"]]
    assert phases[:-1] == list(dict.fromkeys(log.phase))
    properties = {name: rows for (path, name), rows in columns.items() if "trial" in path}
    assert properties["object"] == [["box"]]
    assert properties["seed"] == [[3]]


def test_a_trial_that_never_predicted_is_recorded(log: TrialLog, tmp_path: Path) -> None:
    row = replace(
        log.row, q_linf=None, q_l1=None, q_reason=None, displacement_mm=float("nan"),
        rotation_deg=float("nan"), failure="unstable_simulation", success=False,
    )  # fmt: skip
    early = replace(
        log, row=row, prediction=None, time=log.time[:1], phase=log.phase[:1], qpos=log.qpos[:1],
        body_position=log.body_position[:1], body_quat=log.body_quat[:1], tactile=log.tactile[:1],
        motor_torque=log.motor_torque[:1], object_height=log.object_height[:1],
        contact_points=log.contact_points[:1], contact_forces=log.contact_forces[:1],
    )  # fmt: skip
    write_recording(early, tmp_path / "early.rrd")
    assert RrdReader(tmp_path / "early.rrd").recordings()


def test_a_refusing_disk_raises(log: TrialLog, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        write_recording(log, tmp_path / "missing" / "trial.rrd")
    (tmp_path / "folder").mkdir()
    with pytest.raises(OSError, match="folder"):
        write_recording(log, tmp_path / "folder")
    assert os.listdir(tmp_path) == ["folder"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_raises(log: TrialLog, tmp_path: Path) -> None:
    (tmp_path / "trial.rrd.tmp").symlink_to("/dev/full")
    with pytest.raises(OSError, match="space"):
        write_recording(log, tmp_path / "trial.rrd")


def test_blueprint_survives_a_limit_of_any_size(log: TrialLog) -> None:
    scene = replace(log.scene, settings=TrialSettings("box", torque_limit=(100.0, 0.01)))
    assert blueprint(replace(log, scene=scene))


@pytest.mark.skipif(sys.platform != "linux", reason="other systems always have a screen")
def test_no_screen_is_said(log: TrialLog, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(RunError, match="--save"):
        spawn_viewer(log)


def test_cones_open_into_the_object_by_the_friction_angle(columns: Columns, log: TrialLog) -> None:
    assert log.prediction is not None
    contacts = log.prediction.contacts
    (points,) = columns["/world/object/object/friction_cones", "Mesh3D:vertex_positions"]
    cones = np.array(points).reshape(len(contacts), -1, 3)
    for cone, pad in zip(cones, contacts, strict=True):
        edges = cone[1:] - cone[0]
        along = edges @ pad.contact.normal
        across = np.linalg.norm(edges - np.outer(along, pad.contact.normal), axis=1)
        assert (along > 0.0).all()
        assert across / along == pytest.approx(pad.contact.friction, rel=1e-4)


def test_l1_lies_inside_linf_and_the_weight_is_drawn(columns: Columns, log: TrialLog) -> None:
    assert log.prediction is not None
    corners = {
        bound: np.array(columns[f"/wrench_space/{bound}", "Mesh3D:vertex_positions"][0])
        for bound in ("linf", "l1")
    }
    planes = ConvexHull(corners["linf"]).equations
    beyond = corners["l1"] @ planes[:, :3].T + planes[:, 3]
    assert beyond.max() < 0.02 * np.ptp(corners["linf"])  # both are drawn to two per cent
    (weight,) = columns["/wrench_space/task", "Arrows3D:vectors"][0]
    assert np.linalg.norm(weight) == pytest.approx(log.row["mass_kg"] * 9.81, rel=1e-6)


def test_the_documented_schema_is_what_is_in_the_file(columns: Columns) -> None:
    page = (ROOT / "docs" / "recordings.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(/[^`]+)` \| `([^`]+)` \|", page, re.MULTILINE)
    assert len(rows) >= 15
    patterns = [
        (re.compile(re.sub(r"<\w+>", "[^/]+", re.escape(path))), archetype)
        for path, archetype in rows
    ]
    for path, name in columns:
        archetype = name.partition(":")[0]
        if archetype in ARCHETYPES:
            assert any(p.fullmatch(path) and a == archetype for p, a in patterns), (path, name)
    found = {(path, name.partition(":")[0]) for path, name in columns}
    for pattern, archetype in patterns:
        assert any(pattern.fullmatch(p) and a == archetype for p, a in found), pattern.pattern


def test_several_trials_share_a_file_with_a_timeline_each(log: TrialLog, tmp_path: Path) -> None:
    again = run_trial(TrialSettings("box"), 4, log=True).log
    assert again is not None
    file = tmp_path / "two.rrd"
    write_recordings(iter((log, again)), file)
    recordings = {entry.recording_id for entry in RrdReader(file).recordings()}
    assert recordings == {recording_id(log), recording_id(again)}
    assert [path.name for path in tmp_path.iterdir()] == ["two.rrd"]
