"""Trials as rerun recordings: geometry once, then poses, forces and tactile images over time."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr

from sdh_sim.atomic_files import write_atomic
from sdh_sim.errors import RunError
from sdh_sim.metrics import Prediction
from sdh_sim.robot import HAND
from sdh_sim.trial import TrialLog
from sdh_sim.viewing.geometry import body_path, log_geometry
from sdh_sim.viewing.layout import blueprint
from sdh_sim.viewing.perceived_contacts import (
    CONTACT_ENTITIES,
    least_effort_forces,
    log_contacts,
)
from sdh_sim.viewing.style import (
    FORCE_SCALE,
    FULL_SCALE,
    LIMIT_COLORS,
    LIMIT_SCALE,
    MOTOR_COLORS,
    TIMELINE,
    WRENCH_SPACE,
    heat_colors,
)
from sdh_sim.viewing.verdict_text import verdict_markdown
from sdh_sim.viewing.wrench_space import log_wrench_space

APPLICATION = "sdh-sim"
SCREENS = ("DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET")
VIEWER_TIMEOUT = 30.0  # for a viewer to receive a trial's data [s]
FORCE_COLOR = (230, 40, 60)
RISING = ("lift-off", "lift")  # phases that begin at the first snapshot


def write_recording(log: TrialLog, path: Path) -> None:
    """Write the recording of a trial; the file is whole or not there.

    Args:
        log: the trial's log.
        path: file to write; its name may end in anything.

    Raises:
        OSError: the disk refused.
    """
    write_atomic(Path(path), recording_bytes(log))


def write_recordings(logs: Iterable[TrialLog], path: Path) -> None:
    """Write one file with a recording per trial, each with a timeline of its own.

    Args:
        logs: of the trials, taken one by one.
        path: file to write; it is whole or not there.

    Raises:
        OSError: the disk refused.
        RunError: rerun could not join them.
    """
    with tempfile.TemporaryDirectory(dir=Path(path).absolute().parent, prefix=".rrd-") as folder:
        parts = []
        for number, log in enumerate(logs):
            parts.append(Path(folder) / f"{number:06d}.rrd")
            write_recording(log, parts[-1])
        if len(parts) == 1:
            os.replace(parts[0], path)
            return
        joined = Path(folder) / "joined.rrd"
        merge = [sys.executable, "-m", "rerun_cli", "rrd", "merge"]
        done = subprocess.run(
            [*merge, *map(str, parts), "-o", str(joined)], capture_output=True, text=True
        )
        if done.returncode != 0:
            last = (done.stderr.strip().splitlines() or ["no message"])[-1]
            raise RunError(f"rerun could not join {len(parts)} recordings: {last}")
        os.replace(joined, path)


def recording_bytes(log: TrialLog) -> bytes:
    """The recording of a trial as the bytes of a file."""
    stream = rr.RecordingStream(APPLICATION, recording_id=recording_id(log))
    # The stream's own file sink reports a full disk on standard error only; bytes in memory can be
    # written in a way that raises.
    sink = stream.binary_stream()
    stream.send_blueprint(blueprint(log))
    log_trial(stream, log)
    content = sink.read()
    stream.disconnect()
    if not content:
        raise RuntimeError(f"rerun gave no bytes for {recording_id(log)}; expected a recording")
    return content


def spawn_viewer(log: TrialLog) -> None:
    """Open the rerun viewer on a trial and return; the viewer stays.

    Raises:
        RunError: no screen, or no viewer could be started.
    """
    # Without a screen the viewer ends at once, and the stream would wait for it for ever.
    if sys.platform == "linux" and not any(os.environ.get(name) for name in SCREENS):
        raise RunError(
            f"no screen for the viewer (none of {', '.join(SCREENS)} is set); "
            "write a file instead with --save FILE.rrd or --png FILE.png"
        )
    # The viewer's executable lies beside the interpreter, which need not be on the path.
    folder = str(Path(sys.executable).parent)
    os.environ["PATH"] = os.pathsep.join([folder, os.environ.get("PATH", "")])
    stream = rr.RecordingStream(APPLICATION, recording_id=recording_id(log))
    try:
        stream.spawn(default_blueprint=blueprint(log), hide_welcome_screen=True)
        log_trial(stream, log)
        stream.flush(timeout_sec=VIEWER_TIMEOUT)
    except (RuntimeError, ValueError) as error:
        raise RunError(
            f"the rerun viewer does not answer ({str(error).splitlines()[0]}); "
            "write a file instead with --save FILE.rrd or --png FILE.png"
        ) from error


def recording_id(log: TrialLog) -> str:
    """A name of this trial alone, the same each time; a viewer merges recordings of one name."""
    digest = hashlib.sha256(repr(log.scene.settings).encode()).hexdigest()[:8]
    return f"{log.row['object']}-seed{log.row['seed']}-{digest}"


def log_trial(stream: rr.RecordingStream, log: TrialLog) -> None:
    """Send everything of a trial into a recording stream."""
    row = log.row
    outcome = "held" if row["success"] else row["failure"]
    stream.send_recording_name(f"{row['object']}, seed {row['seed']}: {outcome}")
    stream.send_property("trial", rr.AnyValues(**_properties(log)))
    log_geometry(stream, log.scene)
    _log_poses(stream, log)
    _log_tactile(stream, log)
    _log_forces(stream, log)
    least = None if log.prediction is None else least_effort_forces(log.prediction.grasp)
    for prediction, phases in ((log.prediction, RISING), (log.lifted_off, ("lift",))):
        if prediction is not None:
            _log_prediction(stream, log, prediction, phases)
    _log_series(stream, log)
    _log_phases(stream, log)
    text = rr.TextDocument(verdict_markdown(log, least), media_type="text/markdown")
    stream.log("verdict", text, static=True)


def _properties(log: TrialLog) -> dict[str, Any]:
    """Values of the row and scales of the arrows, by name."""
    keys = (
        "object", "seed", "success", "failure", "displacement_mm", "rotation_deg", "q_linf",
        "q_l1", "q_reason", "contacts", "mass_kg", "friction", "approach", "preshape",
        "sim_seconds",
    )  # fmt: skip
    values = {key: log.row[key] for key in keys if log.row.get(key) is not None}
    values["torque_limit_nm"] = list(log.scene.torque_limit)
    values["force_arrow_m_per_n"] = FORCE_SCALE
    values["g_arrow_m_per_n"] = LIMIT_SCALE
    return values


def _times(log: TrialLog) -> rr.TimeColumn:
    """Times of the samples."""
    return rr.TimeColumn(TIMELINE, duration=log.time)


def _log_poses(stream: rr.RecordingStream, log: TrialLog) -> None:
    """Poses of all bodies in the world."""
    model = log.scene.model
    quat = log.body_quat[:, :, [1, 2, 3, 0]]  # MuJoCo has w first, rerun last
    for body in range(1, model.nbody):
        path = body_path(model, body)
        if model.body_weldid[body] == 0:  # fixed to the world
            pose = rr.Transform3D(translation=log.body_position[0, body], quaternion=quat[0, body])
            stream.log(path, pose, static=True)
        else:
            columns = rr.Transform3D.columns(
                translation=log.body_position[:, body], quaternion=quat[:, body]
            )
            stream.send_columns(path, [_times(log)], columns)


def _log_tactile(stream: rr.RecordingStream, log: TrialLog) -> None:
    """For each pad an image of forces [N], and its taxels as coloured points on the link."""
    hand = log.scene.hand
    for pad, start in zip(hand.pads, hand.pad_offsets[:-1], strict=True):
        live, name = pad.array.live, pad.name
        rows, columns = pad.array.shape
        forces = log.tactile[:, start : start + live.size].astype(np.float32)
        forces = forces.reshape(-1, rows, columns)
        layout = rr.components.ImageFormat(
            width=columns, height=rows, channel_datatype=rr.ChannelDatatype.F32
        )
        style = rr.DepthImage.from_fields(
            format=layout, meter=1.0, colormap="inferno", depth_range=[0.0, FULL_SCALE]
        )
        path = f"tactile/{name}"
        stream.log(path, style, static=True)
        buffers = forces.reshape(len(forces), -1).view(np.uint8)
        stream.send_columns(path, [_times(log)], rr.DepthImage.columns(buffer=buffers))

        points = f"{body_path(log.scene.model, log.scene.model.body(HAND + pad.body).id)}/taxels"
        stream.log(
            points,
            rr.Points3D(pad.array.centres[live], radii=0.4 * pad.array.pitch),
            static=True,
        )
        colors = heat_colors(forces[:, live])
        columns = rr.Points3D.columns(colors=colors.reshape(-1))
        stream.send_columns(points, [_times(log)], columns.partition([live.sum()] * len(forces)))


def _log_forces(stream: rr.RecordingStream, log: TrialLog) -> None:
    """Forces on the object: arrows from the contacts into the object, which is transparent."""
    lengths = [len(points) for points in log.contact_points]
    forces = np.concatenate(log.contact_forces) * FORCE_SCALE
    points = np.concatenate(log.contact_points)
    path = "world/contact_forces"
    stream.log(path, rr.Arrows3D.from_fields(colors=FORCE_COLOR, radii=0.0012), static=True)
    columns = rr.Arrows3D.columns(origins=points, vectors=forces)
    stream.send_columns(path, [_times(log)], columns.partition(lengths))


def _log_prediction(
    stream: rr.RecordingStream, log: TrialLog, prediction: Prediction, phases: Sequence[str]
) -> None:
    """Contacts and wrench space of a snapshot, where the first of the phases after it begins."""
    after = (k for k, name in enumerate(log.phase) if name in phases)
    stream.set_time(TIMELINE, duration=float(log.time[next(after, len(log.time) - 1)]))
    body = body_path(log.scene.model, log.scene.object_body)
    if prediction is log.lifted_off:  # what the first snapshot showed is over
        for path in (*(f"{body}/{name}" for name in CONTACT_ENTITIES), WRENCH_SPACE):
            stream.log(path, rr.Clear(recursive=True))
    if prediction.contacts:
        least = least_effort_forces(prediction.grasp)
        log_contacts(stream, body, prediction.contacts, least, log.scene.obj.com_m)
        log_wrench_space(stream, prediction)


def _log_series(stream: rr.RecordingStream, log: TrialLog) -> None:
    """Motor torques [N m] with their limits, and the object's height [mm]."""
    hand = log.scene.hand
    for index, name in enumerate(hand.motor_names):
        path = f"torque/{name}"
        style = rr.SeriesLines(
            colors=MOTOR_COLORS[index % len(MOTOR_COLORS)], names=name, widths=1.5
        )
        stream.log(path, style, static=True)
        values = rr.Scalars.columns(scalars=log.motor_torque[:, index])
        stream.send_columns(path, [_times(log)], values)
    ends = log.time[[0, -1]]
    limits = zip(hand.groups, log.scene.torque_limit, strict=True)
    for index, (group, limit) in enumerate(limits):
        path = f"torque/limit_{group}"
        color = LIMIT_COLORS[index % len(LIMIT_COLORS)]
        style = rr.SeriesLines(colors=color, names=f"limit, {group}", widths=3.0)
        stream.log(path, style, static=True)
        values = rr.Scalars.columns(scalars=[limit, limit])
        stream.send_columns(path, [rr.TimeColumn(TIMELINE, duration=ends)], values)
    style = rr.SeriesLines(colors=(40, 170, 90), names="object height [mm]", widths=2.0)
    stream.log("object_height", style, static=True)
    values = rr.Scalars.columns(scalars=log.object_height * 1e3)
    stream.send_columns("object_height", [_times(log)], values)


def _log_phases(stream: rr.RecordingStream, log: TrialLog) -> None:
    """Where phases begin, and the outcome at the end."""
    starts = [k for k in range(len(log.phase)) if k == 0 or log.phase[k] != log.phase[k - 1]]
    texts = [log.phase[k] for k in starts]
    outcome = "held" if log.row["success"] else f"failed: {log.row['failure']}"
    times = rr.TimeColumn(TIMELINE, duration=log.time[[*starts, len(log.time) - 1]])
    columns = rr.TextLog.columns(
        text=[*texts, outcome],
        level=["INFO"] * len(texts) + ["INFO" if log.row["success"] else "WARN"],
    )
    stream.send_columns("phase", [times], columns)
