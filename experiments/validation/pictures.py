"""Pictures of the validation: prediction and simulation in one drawing per check."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from experiments.validation.carrying import SAMPLE
from experiments.validation.pads import bed
from experiments.validation.rigs import TAXEL_RADIUS
from experiments.validation.sensor import PUBLISHED

PREDICTED, SIMULATED, FAINT = "#222222", "#d1495b", "#9a9a9a"
PALETTE = ("#00798c", "#d1495b", "#edae49", "#66a182", "#2e4057", "#8d6a9f")
MARKERS = "osD^vP"
STYLE: dict[Any, Any] = {
    "font.size": 9.0, "axes.spines.top": False, "axes.spines.right": False,
    "axes.titlesize": 9.5, "axes.labelsize": 9.0, "legend.frameon": False,
    "legend.fontsize": 8.0, "xtick.labelsize": 8.0, "ytick.labelsize": 8.0,
}  # fmt: skip


def _figure(columns: int, width: float, height: float, **options: Any) -> tuple[Figure, Any]:
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(1, columns, **options)


def pad_onset(curves: dict[str, Any]) -> Figure:
    """Speed of a pulled plate over the load: creep below the limit, sliding beyond."""
    figure, ax = _figure(1, 4.6, 3.2)
    frictions = sorted({mu for _, mu in curves})
    for (way, mu), (shares, speeds, law) in sorted(curves.items()):
        ax.semilogy(
            shares, speeds / law, {"across": "o", "along": "+"}[way], mfc="none",
            ms={"across": 4.5, "along": 7.0}[way], color=PALETTE[frictions.index(mu)],
            label=f"μ {mu:g}, {way} the finger",
        )  # fmt: skip
    ax.axhline(1.0, color=PREDICTED, lw=0.8, zorder=0)
    ax.axvline(1.0, color=FAINT, lw=0.8, ls="--", zorder=0)
    ax.annotate("Coulomb's limit", (0.99, 10.0), rotation=90, ha="right", fontsize=8)
    ax.set(xlabel="pull over μ N", ylabel="speed over that of the creep law", xlim=(0, 1.15))
    ax.legend(loc="upper left")
    return figure


def clamp_drop(curves: dict[str, Any]) -> Figure:
    """Fall of a clamped box around the critical friction, and the thresholds found."""
    figure, (left, right) = _figure(2, 7.2, 3.2)
    torque = max(t for t, _ in curves["falls"])
    for index, ((at, share), fall) in enumerate(sorted(curves["falls"].items())):
        if at == torque:
            time = 0.01 * np.arange(len(fall))
            left.plot(time, fall, color=PALETTE[index % 4], label=f"{share:.2f}")
    left.set(xlabel="time with the weight on [s]", ylabel="sliding of the box [mm]",
             title=f"motors limited to {torque:.1f} N m")  # fmt: skip
    left.set_yscale("symlog", linthresh=0.01)
    left.legend(title="μ over m g / ΣN", title_fontsize=8)
    points = curves["points"]
    edge = np.array([0.9 * points.min(), 1.05 * points.max()])
    right.plot(edge, edge, color=PREDICTED, lw=0.8, label="μ = m g / ΣN")
    right.plot(*points.T, "o", color=SIMULATED, ms=5, mfc="none", label="found by bisection")
    right.set(xlabel="m g / ΣN from the taxels", ylabel="friction that drops the box")
    right.legend(loc="upper left")
    return figure


def torsion_onset(curves: dict[str, Any]) -> Figure:
    """Spin over the moment for several patches, and how far each is from equation 7."""
    figure, (left, right) = _figure(2, 8.4, 3.3, width_ratios=(1.15, 1))
    names = list(curves)
    for index, name in enumerate(names):
        shares, speeds, *_ = curves[name]
        left.semilogy(shares, speeds, f"-{MARKERS[index]}", ms=4, lw=0.9, mfc="none",
                      color=PALETTE[index])  # fmt: skip
    shares, _, law, *_ = curves[names[0]]
    left.semilogy(shares, law, color=PREDICTED, lw=0.8, ls=":")
    left.annotate("creep law, plate", (1.12, 0.45 * law[5]), fontsize=8)
    left.axvline(1.0, color=FAINT, lw=0.8, ls="--")
    left.set(xlabel="moment over τ* of equation 7", ylabel="spin after 0.2 s [rad/s]")
    where = np.arange(len(names))[::-1]
    right.barh(where, [curves[n][4] for n in names], 0.55, color=PALETTE[: len(names)])
    right.axvline(1.0, color=FAINT, lw=0.8, ls="--")
    for place, name in zip(where, names, strict=True):
        right.annotate(f"{curves[name][4]:.2f}", (0.03, place), va="center", color="white")
    right.set_yticks(where, names)
    right.set(xlim=(0, 1.15), xlabel="moment at which it spins over τ*")
    return figure


def single_finger(curves: dict[str, Any]) -> Figure:
    """Each pose of the thumb from the side with the predicted and the simulated force."""
    poses = curves["poses"]
    figure, axes = _figure(len(poses), 1.55 * len(poses) + 0.4, 3.3, sharey=True)
    for ax, (joints, bar, point, predicted, simulated) in zip(axes, poses, strict=True):
        line, centre, at = 1e3 * joints, 1e3 * bar, 1e3 * point
        ax.plot(*line.T, color=FAINT, lw=7, solid_capstyle="round", alpha=0.5)
        ax.plot(*line[:2].T, "o", color=PREDICTED, ms=4)
        ax.add_patch(Circle(tuple(centre), 20.0, fc="#e8edf0", ec=FAINT, lw=0.8))
        for force, colour, width in ((predicted, PREDICTED, 3.6), (simulated, SIMULATED, 1.4)):
            tip = at + 3.0 * force
            ax.plot(*np.array([at, tip]).T, color=colour, lw=width, solid_capstyle="butt")
        error = 100.0 * (np.linalg.norm(simulated) / np.linalg.norm(predicted) - 1.0)
        ax.set_title(f"{np.linalg.norm(simulated):.2f} N\n({error:+.2f} %)")
        ax.set_aspect("equal")
        middle = 0.5 * (
            min(line[:, 0].min(), centre[0] - 20) + max(line[:, 0].max(), centre[0] + 20)
        )
        ax.set(xlabel="x [mm]", xlim=(middle - 62, middle + 62))
    axes[0].set_ylabel("height over the palm frame [mm]")
    axes[0].plot([], [], color=PREDICTED, lw=3.6, label="J$^{-T}$τ̄")
    axes[0].plot([], [], color=SIMULATED, lw=1.4, label="contacts")
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def _diagonal(ax: Axes, predicted: np.ndarray, simulated: np.ndarray, unit: str) -> None:
    edge = np.array([0.0, 1.08 * max(predicted.max(), simulated.max())])
    ax.plot(edge, edge, color=PREDICTED, lw=0.8)
    ax.set(xlim=edge, ylim=edge, xlabel=f"predicted [{unit}]", ylabel=f"simulated [{unit}]")
    ax.set_aspect("equal")


def two_pads(curves: dict[str, Any]) -> Figure:
    """Force on each of two pads against what both torque limits allow."""
    points = curves["points"]
    figure, ax = _figure(1, 3.4, 3.3)
    _diagonal(ax, points[:, 0], points[:, 1], "N")
    ax.plot(*points[0::2].T, "o", color=PALETTE[0], mfc="none", label="proximal pad")
    ax.plot(*points[1::2].T, "s", color=PALETTE[1], mfc="none", label="distal pad")
    ax.legend(loc="upper left")
    return figure


def tactile_total(curves: dict[str, Any]) -> Figure:
    """Sum of all taxels over the motors' limit."""
    torque, predicted, total = curves["points"].T
    figure, ax = _figure(1, 3.8, 3.0)
    ax.plot(torque, predicted, color=PREDICTED, lw=0.8, label="2 τ̄ over the lever")
    ax.plot(torque, total, "o", color=SIMULATED, mfc="none", label="sum of all taxels")
    ax.set(xlabel="limit of the proximal motors [N m]", ylabel="force [N]")
    ax.set_xlim(left=0)
    ax.set_ylim(bottom=0)
    ax.legend(loc="upper left")
    return figure


def whole_grasp(curves: dict[str, Any]) -> Figure:
    """Torque of every motor beside what all contact forces ask of it."""
    grasps = curves["sums"]
    figure, axes = _figure(len(grasps), 2.1 * len(grasps) + 0.6, 2.9, sharey=True, squeeze=False)
    names = ("spread", "2 prox.", "2 dist.", "thumb prox.", "thumb dist.", "1 prox.", "1 dist.")
    for ax, (name, contacts, motors, free) in zip(axes[0], grasps, strict=True):
        where = np.arange(7)
        ax.bar(where, motors, 0.75, color="#cfd8dc", label="motor torque")
        ax.plot(where, contacts, "_", color=SIMULATED, ms=13, mew=1.8, label="Σ J$^T$f")
        for joint in np.flatnonzero(~free):
            ax.annotate("joint at its stop", (joint, contacts[joint] + 0.08), rotation=90,
                        ha="center", fontsize=7)  # fmt: skip
        ax.axhline(0.0, color=PREDICTED, lw=0.6)
        ax.set_xticks(where, names, rotation=60, ha="right", rotation_mode="anchor")
        ax.set_title(name.replace("_", " "))
    axes[0, 0].set_ylabel("torque [N m]")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return figure


def ball(curves: dict[str, Any]) -> Figure:
    """Pressure under pressed balls over the distance from their axis, against elastic beds."""
    balls = curves["balls"]
    figure, axes = _figure(len(balls), 2.9 * len(balls) + 0.3, 3.1, squeeze=False)
    for ax, (radius, force, profile, _) in zip(axes[0], balls, strict=True):
        ax.plot(1e3 * profile[:, 0], 1e-3 * profile[:, 1], ".", color=SIMULATED, ms=3, alpha=0.6,
                label="taxels, all places")  # fmt: skip
        for curvature, style, name in (
            (radius + TAXEL_RADIUS, "-", "bed under a ball of r + R"),
            (radius, "--", "ideal bed"),
        ):
            _, area, peak = bed(force, curvature)
            r = np.linspace(0.0, np.sqrt(area / np.pi), 100)
            ax.plot(1e3 * r, 1e-3 * peak * (1.0 - r**2 / r[-1] ** 2), style, color=PREDICTED,
                    lw=0.9, label=name)  # fmt: skip
        ax.set_title(f"ball of {1e3 * radius:g} mm radius, {force:g} N")
        ax.set_xlabel("distance of the taxel from the axis [mm]")
        ax.set_xlim(left=0)
        ax.set_ylim(bottom=0)
    axes[0, 0].set_ylabel("pressure [kPa]")
    axes[0, 0].legend(loc="lower left", handlelength=1.6)
    return figure


def modulus(curves: dict[str, Any]) -> Figure:
    """Patch area and held force over Young's modulus of the rubber."""
    young, area, predicted, held = curves["points"].T
    figure, (left, right) = _figure(2, 6.6, 3.0)
    law = [bed(curves["force"], curves["radius"] + TAXEL_RADIUS, e)[1] for e in young]
    left.loglog(1e-6 * young, 1e6 * np.array(law), color=PREDICTED, lw=0.8,
                label="elastic bed, E$^{-1/2}$")  # fmt: skip
    left.loglog(1e-6 * young, 1e6 * area, "o", color=SIMULATED, mfc="none", label="taxels touched")
    left.set(xlabel="Young's modulus [MPa]", ylabel="patch area [mm²]",
             title=f"ball of {1e3 * curves['radius']:g} mm, {curves['force']:g} N")  # fmt: skip
    left.legend()
    right.semilogx(1e-6 * young, predicted, color=PREDICTED, lw=0.8, label="2 τ̄ over the lever")
    right.semilogx(1e-6 * young, held, "o", color=SIMULATED, mfc="none", label="sum of all taxels")
    right.set(xlabel="Young's modulus [MPa]", ylabel="force on a clamped box [N]",
              ylim=(0, 1.15 * held.max()))  # fmt: skip
    right.legend(loc="lower right")
    for ax in (left, right):
        ax.set_xticks(1e-6 * young, [f"{1e-6 * e:g}" for e in young])
        ax.minorticks_off()
    left.set_ylim(0.8e6 * min(law), 1.25e6 * max(law))
    low, high = left.get_ylim()
    ticks = [t for t in (40, 60, 80, 100, 150, 200, 300, 400) if low < t < high]
    left.set_yticks(ticks, [str(t) for t in ticks])
    return figure


def release(curves: dict[str, Any]) -> Figure:
    """Energy and angular momentum of a released box over time, for each time step."""
    figure, (left, right) = _figure(2, 6.8, 3.0)
    for index, (timestep, (time, drift, turned)) in enumerate(sorted(curves["falls"].items())):
        law = -0.5 * 0.5 * 9.81**2 * time * timestep
        label = f"{1e3 * timestep:g} ms"
        thin = slice(None, None, max(1, round(0.02 / timestep)))
        left.plot(time, 1e3 * law, color=PREDICTED, lw=0.8)
        left.plot(time[thin], 1e3 * drift[thin], MARKERS[index], color=PALETTE[index], ms=4,
                  mfc="none", label=label)  # fmt: skip
        right.plot(time, 100 * turned, color=PALETTE[index], label=label)
    left.plot([], [], color=PREDICTED, lw=0.8, label="−½ m g² t Δt")
    left.set(xlabel="time of the fall [s]", ylabel="drift of the energy [mJ]")
    right.set(xlabel="time of the fall [s]", ylabel="change of angular momentum [%]")
    left.legend(loc="lower left")
    right.legend(loc="upper left")
    return figure


def numerics(curves: dict[str, Any]) -> Figure:
    """Force and pose of grasps under other numerics, against the default."""
    points = curves["points"]
    labels = list(dict.fromkeys(p[1] for p in points))
    names = list(dict.fromkeys(p[0] for p in points))
    figure, axes = _figure(3, 7.6, 2.6, sharey=True)
    heads = ("force over the default's", "object displaced [mm]", "object turned [°]")
    for part, (ax, head) in enumerate(zip(axes, heads, strict=True)):
        for index, name in enumerate(names):
            mine = [p for p in points if p[0] == name]
            ax.plot([p[2 + part] for p in mine], [-labels.index(p[1]) for p in mine],
                    MARKERS[index], color=PALETTE[index], mfc="none", ms=5,
                    label=name.replace("_", " "))  # fmt: skip
        ax.set_xlabel(head)
        ax.set_yticks([-k for k in range(len(labels))], labels)
        ax.grid(axis="y", lw=0.3)
    axes[0].axvspan(0.95, 1.05, color="#e8edf0", zorder=0)
    axes[0].set_xlim(0.92, 1.08)
    for ax in axes[1:]:
        ax.axvspan(0.0, 1.0, color="#e8edf0", zorder=0)
        ax.set_xlim(0.0, 1.08)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def carry(curves: dict[str, Any]) -> Figure:
    """Where a held object is in the hand through the lift, less where the finest step has it."""
    ways = curves["ways"]
    figure, axes = _figure(len(ways), 1.0 + 2.2 * len(ways), 2.6, sharey=True, squeeze=False)
    for ax, (name, (finest, steps, implicit)) in zip(axes[0], ways.items(), strict=True):
        time = SAMPLE * np.arange(len(finest))
        for index, (step, way) in enumerate(steps.items()):
            ax.semilogy(time, 1e6 * np.linalg.norm(way - finest, axis=1), color=PALETTE[index],
                        label=f"{1e3 * step:g} ms")  # fmt: skip
        ax.semilogy(time, 1e6 * np.linalg.norm(implicit - finest, axis=1), color=FAINT, ls="--",
                    label=f"{1e3 * curves['implicit']:g} ms, implicit damping")  # fmt: skip
        ax.set(xlabel="time in the lift [s]", title=name.replace("_", " "))
        ax.set_ylim(0.1, 1e4)
    axes[0][0].set_ylabel("off the place at 0.5 ms [µm]")
    figure.legend(*axes[0][0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def sensor_creep(curves: dict[str, Any]) -> Figure:
    """Reading under a constant pressure over time, with the published slopes."""
    figure, ax = _figure(1, 4.6, 3.0)
    force = 5.0
    ax.plot(curves["time"], curves["counts"] / force, color=SIMULATED, label="simulated array")
    ax.plot(list(PUBLISHED), list(PUBLISHED.values()), "o", color=PREDICTED, label="published")
    ax.set_xlabel("time since contact [s]")
    ax.set_ylabel("sum of counts per newton")
    ax.set_ylim(bottom=0.0)
    ax.legend(loc="lower right")
    return figure


PICTURES: dict[str, Callable[[dict[str, Any]], Figure]] = {
    draw.__name__: draw
    for draw in (
        pad_onset, clamp_drop, torsion_onset, single_finger, two_pads, tactile_total, whole_grasp,
        ball, modulus, release, numerics, carry, sensor_creep,
    )
}  # fmt: skip


def save(name: str, curves: dict[str, Any], folder: Path) -> Path | None:
    """Draw a check's picture into ``folder``; None where a picture would say no more."""
    import matplotlib as mpl

    if name not in PICTURES:
        return None
    path = folder / f"{name}.png"
    with mpl.rc_context(STYLE):
        PICTURES[name](curves).savefig(path, dpi=200)
    return path
