"""How fast the metrics are, as ratios to SciPy's linprog and qhull on the same grasps."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import graspq as gq
from experiments.command_line import Parser, at_least
from graspq.contact import tangent_basis

LINPROG_CALLS = 15
HULL_LIMIT = 4000
BATCH = 30_000


@dataclass(frozen=True)
class Case:
    """Grasps of one kind: contacts, torsion, edges of the cones, taxels per patch."""

    name: str
    contacts: int
    soft: bool
    edges: int = 12
    taxels: int = 0


CASES = (
    Case("3 hard", 3, False),
    Case("3 soft", 3, True),
    Case("4 hard, 6 edges", 4, False, 6),
    Case("4 soft", 4, True),
    Case("6 soft", 6, True),
    Case("6 patches of 560", 6, True, 12, 46),
)


def random_grasp(case: Case, rng: np.random.Generator) -> list[np.ndarray]:
    """Contacts spread over a 10 cm ball, pointing inwards within a tilt."""
    wrenches = []
    for _ in range(case.contacts):
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        p = -0.05 * n + 0.01 * rng.normal(size=3)
        patch = None
        if case.taxels:
            a, b = tangent_basis(n)
            at = rng.uniform(-0.01, 0.01, (case.taxels, 2))
            patch = p + at[:, :1] * a + at[:, 1:] * b
        contact = gq.Contact(p, n, 0.6, 1.0, 0.01 if case.soft else 0.0, patch)
        wrenches.append(gq.contact_wrenches(contact, case.edges, "hf" if case.taxels else "none"))
    return wrenches


def closed_grasps(case: Case, count: int, rng: np.random.Generator) -> list[list[np.ndarray]]:
    """Force closure grasps, for which no metric has a short way out."""
    grasps: list[list[np.ndarray]] = []
    while len(grasps) < count:
        grasp = random_grasp(case, rng)
        if gq.is_force_closure(grasp):
            grasps.append(grasp)
    return grasps


def per_call(run: Callable[[Any], Any], inputs: list[Any]) -> np.ndarray:
    """Seconds of every call, after one to warm up."""
    run(inputs[0])
    times = []
    for item in inputs:
        begin = time.perf_counter()
        run(item)
        times.append(time.perf_counter() - begin)
    return np.array(times)


def batched(run: Callable[[], Any], count: int) -> float:
    """Seconds per grasp, best of three."""
    run()
    best = np.inf
    for _ in range(3):
        begin = time.perf_counter()
        run()
        best = min(best, time.perf_counter() - begin)
    return best / count


def linprog_call(grasp: list[np.ndarray], task: np.ndarray) -> Any:
    """q* of one task by SciPy's linprog, as a user would write it; dense, the faster way."""
    from scipy.optimize import linprog

    columns, sums = stacked(grasp)
    cost = np.zeros(columns.shape[1] + 1)
    cost[-1] = -1.0
    return linprog(
        cost,
        A_eq=np.column_stack([columns, -task]),
        b_eq=np.zeros(6),
        method="highs",
        A_ub=np.column_stack([sums, np.zeros(len(grasp))]),
        b_ub=np.ones(len(grasp)),
    )


def linprog_joint(grasp: list[np.ndarray], tasks: np.ndarray) -> Any:
    """q* of a task set as one sparse linear program with a common scale."""
    from scipy import sparse
    from scipy.optimize import linprog

    columns, sums = stacked(grasp)
    count = tasks.shape[1]
    balance = sparse.hstack(
        [sparse.block_diag([columns] * count), -tasks.T.reshape(-1, 1)], format="csc"
    )
    limits = sparse.hstack(
        [sparse.block_diag([sums] * count), sparse.csc_array((len(grasp) * count, 1))], format="csc"
    )
    cost = np.zeros(columns.shape[1] * count + 1)
    cost[-1] = -1.0
    return linprog(
        cost,
        A_eq=balance,
        b_eq=np.zeros(6 * count),
        A_ub=limits,
        b_ub=np.ones(len(grasp) * count),
        method="highs",
    )


def stacked(grasp: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """All columns side by side, and the rows that add up every contact's weights."""
    owner = np.repeat(np.arange(len(grasp)), [w.shape[1] for w in grasp])
    return np.hstack(grasp), (owner[None] == np.arange(len(grasp))[:, None]).astype(float)


def set_seconds(grasp: list[np.ndarray], tasks: np.ndarray) -> float:
    """Seconds of linprog for q* of a task set: one program per task or one for all."""

    def separate() -> None:
        for task in tasks.T:
            linprog_call(grasp, task[:, None])

    return min(batched(separate, 1), batched(lambda: linprog_joint(grasp, tasks), 1))


def warm_highs(grasp: list[np.ndarray], tasks: np.ndarray) -> float | None:
    """Seconds per task of one HiGHS model kept and re-solved; None without highspy."""
    try:
        import highspy  # type: ignore[import-not-found]
    except ImportError:
        return None
    columns, sums = stacked(grasp)
    owner = np.argmax(sums, axis=0)
    model = highspy.Highs()
    model.setOptionValue("output_flag", False)
    infinity = highspy.kHighsInf
    for _ in range(6):
        model.addRow(0.0, 0.0, 0, np.array([], dtype=np.int32), np.array([]))
    for _ in grasp:
        model.addRow(-infinity, 1.0, 0, np.array([], dtype=np.int32), np.array([]))
    for j in range(columns.shape[1]):
        model.addCol(
            0.0,
            0.0,
            infinity,
            7,
            np.array([0, 1, 2, 3, 4, 5, 6 + owner[j]], np.int32),
            np.append(columns[:, j], 1.0),
        )
    model.addCol(-1.0, 0.0, infinity, 6, np.arange(6, dtype=np.int32), -tasks[:, 0])
    last = columns.shape[1]
    model.run()
    begin = time.perf_counter()
    for task in tasks.T:
        for r in range(6):
            model.changeCoeff(r, last, -task[r])
        model.run()
    return (time.perf_counter() - begin) / tasks.shape[1]


def hull_seconds(grasp: list[np.ndarray]) -> float | None:
    """Seconds of qhull on every sum of vertices and zero; None when out of reach."""
    from graspq._engines.qhull_check import product_hull

    if np.prod([w.shape[1] + 1 for w in grasp], dtype=float) > HULL_LIMIT:
        return None
    begin = time.perf_counter()
    product_hull(grasp, "linf", True)
    return time.perf_counter() - begin


def measure(case: Case, count: int, hulls: int, rng: np.random.Generator) -> list[str]:
    """One row of the table."""
    count = max(2, count // 10) if case.taxels else count
    grasps = closed_grasps(case, count, rng)
    tasks = [
        rng.normal(size=(6, 1)) * np.array([[1], [1], [1], [0.05], [0.05], [0.05]]) for _ in grasps
    ]
    pairs = list(zip(grasps, tasks, strict=True))
    single = float(np.median(per_call(lambda p: gq.task_scaling(*p), pairs)))
    again = max(1, BATCH // (count * (20 if case.taxels else 1)))
    many, wanted = np.array(again * grasps), np.array(again * tasks)
    one, two = (
        batched(lambda w=w: gq.task_scaling_batch(many, wanted, workers=w), len(many))
        for w in (1, 2)
    )
    linprog = float(np.median(per_call(lambda p: linprog_call(*p), pairs[:LINPROG_CALLS])))
    gravity = [
        gq.gravity_tasks(0.3, 0.005 * rng.normal(size=3), rng.normal(size=3)) for _ in grasps
    ]
    again = max(10, again // 10)
    grip, held = np.array(again * grasps), np.array(again * gravity)
    sets, sets_on_two = (
        batched(lambda w=w: gq.task_scaling_batch(grip, held, workers=w), len(grip)) for w in (1, 2)
    )
    linprog_set = set_seconds(grasps[0], gravity[0])
    warm = warm_highs(grasps[0], np.hstack(tasks[:50]))
    ball = per_call(gq.epsilon, grasps)
    some = np.array(10 * grasps)
    balls, balls_on_two = (
        batched(lambda w=w: gq.epsilon_batch(some, workers=w), len(some)) for w in (1, 2)
    )
    measured = [t for t in (hull_seconds(g) for g in grasps[:hulls]) if t is not None]
    qhull = float(np.mean(measured)) if measured else None
    try:
        volume = float(np.median(per_call(gq.volume, grasps[: max(2, count // 10)])))
    except gq.GraspError:
        volume = None

    def versus(own: float | None) -> str:
        return "-" if qhull is None or own is None else f"{qhull / own:,.0f}"

    return [
        case.name,
        f"{1e6 * single:.1f}",
        f"{linprog / single:,.0f}",
        f"{1e6 * one:.1f}",
        f"{linprog / one:,.0f}",
        f"{one / two:.2f}",
        f"{1e6 * sets:.0f}",
        f"{linprog_set / sets:,.0f}",
        f"{sets / sets_on_two:.2f}",
        "-" if warm is None else f"{warm / one:,.0f}",
        f"{1e3 * np.median(ball):.2f} / {1e3 * ball.max():.2f}",
        versus(float(np.median(ball))),
        f"{balls / balls_on_two:.2f}",
        "-" if volume is None else f"{1e3 * volume:.2f}",
        versus(volume),
    ]


def main(arguments: list[str] | None = None) -> None:
    """Run the benchmark from the command line."""
    parser = Parser(__doc__)
    parser.add_argument("--grasps", type=int, default=300, help="grasps per case")
    parser.add_argument("--hulls", type=int, default=1, help="grasps per case that qhull gets")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    at_least(parser, options, grasps=1, hulls=1, seed=0)
    from rich.console import Console
    from rich.table import Table

    # Wide enough for every column, also where the output goes to a file.
    console = Console(width=max(Console().width, 210))
    table = Table(title="graspq, independent bounds with unloading; × is how many times faster")
    heads = (
        "case",
        "q* call [µs]",
        "× linprog",
        "q* batch [µs]",
        "× linprog",
        "2 threads ×",
        "q* 20 tasks [µs]",
        "× linprog",
        "2 threads ×",
        "× warm HiGHS",
        "ε median / worst [ms]",
        "× qhull",
        "2 threads ×",
        "V [ms]",
        "× qhull",
    )
    for head in heads:
        table.add_column(head, justify="left" if head == "case" else "right")
    rng = np.random.default_rng(options.seed)
    with console.status("measuring") as status:
        for case in CASES:
            status.update(f"measuring: {case.name}")
            table.add_row(*measure(case, options.grasps, options.hulls, rng))
    console.print(table)


if __name__ == "__main__":
    main()
