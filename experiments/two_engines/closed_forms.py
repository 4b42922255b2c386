"""Closed forms of ``experiments.validation`` in both engines: which one is nearer to mechanics?

    python -m experiments.two_engines.closed_forms [--short] [--only NAME ...] [--picture STEM]

Each line is what mechanics predicts of a rig with the hand, its pads and its rubber, and how far
either engine is off. Rigs, readings and predictions are those of the validation and the same for
both. Where something starts to slip, it is what moves by 0.1 mm within 0.3 s, in all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from experiments.command_line import Parser
from experiments.two_engines.alignment import ALIGNED, ALIGNMENTS, NAMES
from experiments.two_engines.drake import need_drake
from experiments.two_engines.start import start_from
from experiments.validation import forces, friction, jaw, pads, torsion
from experiments.validation.motion import GRASPS
from experiments.validation.result_rows import Row, threshold
from experiments.validation.rig_engine import (
    GROWTH,
    MUJOCO,
    WATCHED,
    MuJoCoRig,
    RigAtRest,
    RigEngine,
)
from experiments.validation.rig_readings import torques_of
from experiments.validation.rigs import (
    GRAVITY,
    HONEST,
    TEST_BODY_MASS,
    bench,
    pad_frame,
    settings_for,
)
from sdh_sim.settings import TrialSettings
from sdh_sim.trial import Trial
from sdh_sim.trial.lift import HOLD_TIME, LIFT_TIME

Form = Callable[[bool, RigEngine], Sequence[Row]]
SOLVERS = {"lagged": ALIGNMENTS[NAMES[-2]], "sap": ALIGNED}
NOTHING, WEIGHT = np.zeros(3), np.array([TEST_BODY_MASS * GRAVITY, 0.0, 0.0])
PAD = "finger1_proximal"
LIFTED = LIFT_TIME + HOLD_TIME  # of a trial [s]
# Of τ*, in the picture; beyond, Coulomb's plate turns by more than half in the time.
SHARES = np.array([0.92, 0.94, 0.96, 0.98, 1.02, 1.04, 1.06, 1.08, 1.1, 1.12])
SETTLED_TICKS = 50  # of a grasp carried into the other engine


def clamp_drop(short: bool, engine: RigEngine) -> Sequence[Row]:
    """Friction at which two fingers drop a box, μ = m g / ΣN."""
    rows = []
    for torque in (1.6401,) if short else (0.8, 1.2, 1.6401, 2.1):
        rig = friction.clamp_rig((torque, 1.0934))
        rest = engine.squeezed(rig, friction.CLAMP_ANGLES, friction.CLAMP_PUSH)
        grip = rest.with_friction(1.0).loaded(WEIGHT, NOTHING).normal
        predicted = TEST_BODY_MASS * GRAVITY / grip

        def drops(inverse: float, rest: RigAtRest = rest) -> bool:
            moved = rest.with_friction(1.0 / inverse).loaded(WEIGHT, NOTHING).moved
            return float(moved[0]) > friction.DROP

        found = 1.0 / threshold(drops, 0.5 / predicted, 1.5 / predicted)
        rows.append(
            Row(f"friction that drops a box, motors at {torque:.2f} N m: m g / ΣN", "", predicted,
                found, 0.01, "0.1 mm in 0.3 s needs 0.5 % of excess load")
        )  # fmt: skip
    return rows


def hanging(short: bool, engine: RigEngine) -> Sequence[Row]:
    """A box that friction holds with room to spare does not move."""
    rig = friction.clamp_rig((1.6401, 1.0934))
    rest = engine.squeezed(rig, friction.CLAMP_ANGLES, friction.CLAMP_PUSH)
    rows = []
    for mu in (0.8,) if short else (0.25, 0.8):
        moved = rest.with_friction(mu).loaded(WEIGHT, NOTHING).moved
        speed = float(moved[0]) / WATCHED
        rows.append(
            Row(f"box that friction {mu:g} holds: it sinks at", "µm/s", 0.0, 1e6 * speed, 1.0,
                "0.1 mm within lift and hold", scale=1e6 * friction.DROP / LIFTED)
        )  # fmt: skip
    return rows


def pad_onset(short: bool, engine: RigEngine) -> Sequence[Row]:
    """Pull that starts a plate sliding on a pad, μ N."""
    rows = []
    for mu in (friction.FRICTION,) if short else (0.2, 0.4, friction.FRICTION, 0.9):
        scene = bench(PAD, *friction.MIDDLE, [friction.PLATE], ["press", "pull"],
                      settings_for(), mu)  # fmt: skip
        rest = engine.pressed(scene, friction.PRESS)
        across = pad_frame(PAD, *friction.MIDDLE).rotation[:, 1]

        def slides(load: float, rest: RigAtRest = rest, way: np.ndarray = across) -> bool:
            moved = rest.loaded(load * way, NOTHING).moved
            return float(np.linalg.norm(moved)) > friction.DROP

        limit = mu * friction.PRESS
        found = threshold(slides, 0.5 * limit, 1.5 * limit)
        rows.append(
            Row(f"pull that slides a plate on a pad, μ {mu:g}: μ N", "N", limit, found, 0.01,
                "Coulomb's law; bisection 0.15 %")
        )  # fmt: skip
    return rows


def torsion_onset(short: bool, engine: RigEngine) -> Sequence[Row]:
    """Moment that starts a flat patch spinning on a pad, equation 7's τ*."""
    rows = []
    names = [name for name, (*_, radius) in torsion.SPUN.items() if np.isinf(radius)]
    for name in names[:1] if short else names:
        pad, at, shape, _ = torsion.SPUN[name]
        scene = bench(pad, *at, [shape], ["press", "twist"], settings_for(), friction.FRICTION)
        rest = engine.pressed(scene, friction.PRESS)
        mark, about = rest.imprint(pad), pad_frame(pad, *at).rotation[:, 0]
        limit = friction.FRICTION * mark.total * mark.torsion_arm

        def spins(
            load: float, rest: RigAtRest = rest, about: np.ndarray = about,
            arm: float = mark.torsion_arm,
        ) -> bool:  # fmt: skip
            return rest.loaded(NOTHING, load * about).turned * arm > friction.DROP

        found = threshold(spins, 0.5 * limit, 1.5 * limit)
        rows.append(
            Row(f"moment that spins a {name}: μ ΣN l", "N m", limit, found, 0.02,
                "the last taxel has yielded 1 % beyond the limit")
        )  # fmt: skip
    return rows


def torsion_overload(short: bool, engine: RigEngine) -> Sequence[Row]:
    """How fast a plate spins beyond τ* where slip presses contacts together, as convex solvers do.

    Of a solver in which it does not, Coulomb's law holds: nothing but inertia holds the plate back.
    """
    rows = []
    for force, mu, share in torsion.OVERLOADS[:1] if short else torsion.OVERLOADS:
        scene = bench(PAD, *friction.MIDDLE, [friction.PLATE], ["press", "twist"],
                      settings_for(), mu)  # fmt: skip
        rest, frame = engine.pressed(scene, force), pad_frame(PAD, *friction.MIDDLE)
        limit, resisted = torsion.spin_law(scene, rest.touches(), frame, mu)
        load = share * limit * frame.rotation[:, 0]
        spin = rest.loaded(NOTHING, load, torsion.STEADY).turned / WATCHED
        rows.append(
            Row(f"plate under {share:g} τ*, {force:g} N, μ {mu:g}: spins at", "mrad/s",
                1e3 * (share - 1.0) * limit / resisted, 1e3 * spin, 0.02, "an even spin")
        )  # fmt: skip
    return rows


def whole_grasp(short: bool, engine: RigEngine) -> Sequence[Row]:
    """Motor torques of whole grasps against all contact forces, Σ Jᵀ f."""
    rows = []
    for name, seed in GRASPS[:1] if short else GRASPS:
        settings = TrialSettings(name, arm="rigid")
        trial = Trial(settings, seed)
        trial.acquire()
        rest = _carried(trial, engine)
        scene, angles = rest.scene, rest.angles
        reach = scene.model.jnt_range[scene.model.dof_jntid[scene.motor_dof]]
        free = (angles > reach[:, 0] + 1e-3) & (angles < reach[:, 1] - 1e-3)
        off = torques_of(scene, angles, rest.touches()) - rest.torques
        rows.append(
            Row(f"{name}, seed {seed}: Σ Jᵀf less τ, worst motor", "N m", 0.0,
                float(np.abs(off)[free].max()), 2e-3, "statics are exact", scale=1.6401)
        )  # fmt: skip
    return rows


def _carried(trial: Trial, engine: RigEngine) -> RigAtRest:
    """A trial at its snapshot, in an engine."""
    from experiments.two_engines.rigs_in_drake import Drake, DrakeRig
    from experiments.two_engines.trials import set_off

    if not isinstance(engine, Drake):
        return MuJoCoRig(trial.scene, trial.simulation.data)
    simulation = set_off(start_from(trial), engine.alignment)
    for _ in range(SETTLED_TICKS):
        simulation.tick()
    return DrakeRig(simulation, NOTHING)


FORMS: Mapping[str, Form] = {
    "clamp_drop": clamp_drop,
    "hanging": hanging,
    "pad_onset": pad_onset,
    "torsion_onset": torsion_onset,
    "torsion_overload": torsion_overload,
    "single_finger": lambda short, engine: forces.single_finger(short, HONEST, engine).rows,
    "two_pads": lambda short, engine: forces.two_pads(short, HONEST, engine).rows,
    "tactile_total": lambda short, engine: forces.tactile_total(short, HONEST, engine).rows,
    "whole_grasp": whole_grasp,
    "plate": lambda short, engine: pads.plate(short, HONEST, engine).rows,
    "ball": lambda short, engine: pads.ball(short, HONEST, engine).rows,
    "jaw_force": lambda short, engine: jaw.jaw_force(short, HONEST, engine).rows,
}


def compared(name: str, short: bool, engines: Mapping[str, RigEngine]) -> list[tuple[Row, ...]]:
    """Judged lines of a form, each with a row of every engine, in their order."""
    rows = [FORMS[name](short, engine) for engine in engines.values()]
    return [line for line in zip(*rows, strict=True) if line[0].judged]


def main(argv: Sequence[str] | None = None) -> None:
    """Print the comparison."""
    parser = Parser(__doc__)
    parser.add_argument("--short", action="store_true", help="the first line or two of each form")
    parser.add_argument("--only", nargs="+", choices=list(FORMS), metavar="NAME",
                        help=f"of: {', '.join(FORMS)}")  # fmt: skip
    parser.add_argument("--picture", type=Path,
                        help="draw how an overloaded patch spins, under this name")  # fmt: skip
    args = parser.parse_args(argv)
    need_drake()
    from experiments.two_engines.rigs_in_drake import Drake

    engines: dict[str, RigEngine] = {"MuJoCo": MUJOCO}
    engines |= {f"Drake, {name}": Drake(SOLVERS[name]) for name in ("sap", "lagged")}
    table = Table(title="Off what mechanics says", title_justify="left")
    for head in ("form", "predicted", *engines, "allowed"):
        table.add_column(head, justify="left" if head == "form" else "right")
    within = np.zeros(len(engines), dtype=int)
    count = 0
    for name in args.only or FORMS:
        lines = compared(name, args.short, engines)
        for line in lines:
            first = line[0]
            cells = [f"{row.simulated:.4g} ({100 * row.deviation:+.2f} %)" for row in line]
            table.add_row(
                first.quantity, f"{first.predicted:.4g} {first.unit}".strip(), *cells,
                f"{100 * first.tolerance:g} %",
            )  # fmt: skip
            within += [row.passed for row in line]
            count += 1
        table.add_section()
    console = Console(width=160)
    console.print(table)
    for engine, passed in zip(engines, within, strict=True):
        console.print(f"{engine}: {passed} of {count} within what is allowed")
    if args.picture is not None:
        print(f"figure: {draw_spin(engines, args.picture)}")


def draw_spin(engines: Mapping[str, RigEngine], stem: Path) -> Path:
    """Draw the spin of a plate by the moment on it in every engine; the PNG is returned."""
    import matplotlib.pyplot as plt

    from sdh_sim.report.figure_style import save, style

    scene = bench(PAD, *friction.MIDDLE, [friction.PLATE], ["press", "twist"],
                  settings_for(), friction.FRICTION)  # fmt: skip
    frame = pad_frame(PAD, *friction.MIDDLE)
    with style():
        figure, axes = plt.subplots(figsize=(4.4, 3.0), layout="constrained")
        limit = resisted = 0.0
        for k, (name, engine) in enumerate(engines.items()):
            rest = engine.pressed(scene, friction.PRESS)
            limit, resisted = torsion.spin_law(scene, rest.touches(), frame, friction.FRICTION)
            spins = [
                rest.loaded(NOTHING, x * limit * frame.rotation[:, 0], torsion.STEADY).turned
                for x in SHARES
            ]
            axes.semilogy(
                SHARES, 1e3 * np.array(spins) / WATCHED, "osD"[k], ms=(7, 3, 4)[k], label=name
            )
        over = np.linspace(1.002, SHARES[-1], 200)
        law = 1e3 * (over - 1.0) * limit / resisted
        axes.semilogy(over, law, color="0.5", lw=0.9, label="law of convex solvers")
        inertia = float(scene.model.body_inertia[scene.object_body, 0])
        time = GROWTH / 2 + torsion.STEADY + WATCHED / 2
        coulomb = 1e3 * (over - 1.0) * limit / inertia * time
        axes.semilogy(over, coulomb, color="0.5", lw=0.9, ls="--", label="Coulomb's law, inertia")
        axes.set_xlabel("moment over τ*")
        axes.set_ylabel(f"spin after {time:.1f} s [mrad/s]")
        axes.legend(frameon=False, loc="lower right")
        _, png = save(figure, stem)
        plt.close(figure)
    return png


if __name__ == "__main__":
    main()
