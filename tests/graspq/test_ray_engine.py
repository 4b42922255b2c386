"""Ray shooting against HiGHS, its own certificate, and what must not change q*."""

from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import graspq as gq
from graspq._engines import highs_engine as lp
from tests.support.random_grasps import KINDS, grasp, tasks

seeds = st.integers(0, 2**32 - 1)
kinds = st.sampled_from(KINDS)
bounds = st.sampled_from(["linf", "l1"])
quick = settings(max_examples=25, deadline=None)


def drawn(seed, kind):
    rng = np.random.default_rng(seed)
    wrenches = grasp(rng, kind)
    wanted = tasks(rng, wrenches)
    wanted = wanted[:, np.abs(wanted).max(axis=0) > 1e-6]
    return wrenches, wanted if wanted.shape[1] else np.eye(6)[:, :1]


@pytest.mark.parametrize("kind", KINDS)
def test_engines_agree_and_certificates_hold(kind):
    solved = 0
    for seed in range(40):
        rng = np.random.default_rng([seed, 77])
        wrenches, wanted = drawn([seed, 5], kind)
        bound, unloading = ["linf", "l1"][rng.integers(2)], bool(rng.integers(2))
        s = gq.task_scaling(wrenches, wanted, bound, unloading)
        other = gq.task_scaling(wrenches, wanted, bound, unloading, engine="highs")
        if s.value != other.value:
            assert s.value == pytest.approx(other.value, rel=1e-9)
        assert s.reason or not (s.value == -np.inf or (s.value == 0.0 and unloading))
        assert not s.reason or s.value <= 0.0
        if s.value > 0:
            solved += 1
            assert s.lower <= s.value <= s.upper <= s.value * (1 + 1e-9)
            aim = s.value * wanted[:, s.critical_task]
            np.testing.assert_allclose(s.forces.sum(0), aim, atol=1e-9 * np.abs(aim).max())
    assert solved > 3 or kind in ("frictionless", "single", "one_sided")


def nearest_plane(wrenches, task):
    """Normal y of a plane between the L1 space and the ray q t, q >= 0, by least squares."""
    from scipy.optimize import nnls

    columns = np.hstack(wrenches)
    size = np.abs(columns).max(axis=1)
    aim = task / size / np.linalg.norm(task / size)
    rows = np.vstack(
        [np.column_stack([columns / size[:, None], -aim]), [*np.ones(columns.shape[1]), 0.0]]
    )
    x, _ = nnls(rows, np.eye(7)[6])
    # The ray is parallel to the plane up to round-off; tilted by this much it leads away.
    y = (np.eye(7)[6] - rows @ x)[:6]
    return (y / np.linalg.norm(y) + 1e-9 * aim) / size


def test_no_scale_is_proven_where_highs_decides_nothing():
    # Three contacts within a fraction of a millimetre, one against the two others. HiGHS calls
    # task 4 neither feasible nor infeasible; on which processors, the last bits decide.
    wrenches, wanted = drawn([24, 5], "clustered")
    assert wanted.shape == (6, 8)
    for task in wanted.T:
        # In exact arithmetic y·w < 0 for every column w, and y·t >= 0: no Σ λ w is a q t.
        plane = [Fraction(v) for v in nearest_plane(wrenches, task)]
        along, *tops = (
            sum(p * Fraction(v) for p, v in zip(plane, w, strict=True))
            for w in [task, *np.hstack(wrenches).T]
        )
        assert max(tops) < 0 <= along
        for engine in ("ray", "highs"):
            assert gq.task_scaling(wrenches, task, "l1", False, engine).value == -np.inf
    for engine in ("ray", "highs"):
        s = gq.task_scaling(wrenches, wanted, "l1", False, engine)
        assert s.value == -np.inf
        assert "task 0" in s.reason


def test_highs_giving_up_is_an_error_or_a_proof(monkeypatch):
    cases = []
    for kind in KINDS:
        for seed in range(12):
            bound = ["linf", "l1"][seed % 2]
            wrenches, wanted = drawn([seed, 6], kind)
            value = gq.task_scaling(wrenches, wanted[:, :1], bound, False).value
            cases.append((wrenches, wanted[:, :1], bound, value))
    solve, proven = lp._solve, 0

    def only_the_distance(cost, limits, options):
        # Of the linear programs the least distance from balance alone has no negative cost and
        # a cost on 12 variables.
        if np.count_nonzero(cost > 0) == 12:
            return solve(cost, limits, options)
        return SimpleNamespace(status=4)

    monkeypatch.setattr(lp, "_solve", only_the_distance)
    for wrenches, wanted, bound, value in cases:
        if value == -np.inf:
            assert gq.task_scaling(wrenches, wanted, bound, False, "highs").value == -np.inf
            proven += 1
        else:
            with pytest.raises(gq.GraspError, match=r"could not decide \(status 4\); the grasp"):
                gq.task_scaling(wrenches, wanted, bound, False, "highs")
    assert 20 < proven < len(cases) - 20


@pytest.mark.parametrize("engine", ["ray", "highs"])
@pytest.mark.parametrize("unloading", [True, False])
def test_contacts_without_force_exert_nothing(unloading, engine):
    nothing = [np.zeros((6, 3))] * 2
    for bound in ("linf", "l1"):
        assert gq.task_scaling(nothing, np.eye(6)[0], bound, unloading, engine).value == 0.0


@quick
@given(seeds, kinds, bounds, st.floats(0.01, 100.0))
def test_scaling_the_forces_scales_q(seed, kind, bound, factor):
    wrenches, wanted = drawn(seed, kind)
    before = gq.task_scaling(wrenches, wanted, bound).value
    after = gq.task_scaling([factor * w for w in wrenches], wanted, bound).value
    assert after == pytest.approx(factor * before, rel=1e-8)


@quick
@given(seeds, st.sampled_from(["random", "soft", "patch", "tiny"]), bounds)
def test_turning_the_frame_changes_nothing(seed, kind, bound):
    from scipy.spatial.transform import Rotation

    wrenches, wanted = drawn(seed, kind)
    turn = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
    both = np.kron(np.eye(2), turn)
    before = gq.task_scaling(wrenches, wanted, bound).value
    after = gq.task_scaling([both @ w for w in wrenches], both @ wanted, bound).value
    assert after == pytest.approx(before, rel=1e-7)


@quick
@given(seeds, kinds)
def test_l1_is_never_above_linf_and_a_contact_never_hurts(seed, kind):
    wrenches, wanted = drawn(seed, kind)
    most = gq.task_scaling(wrenches, wanted).value
    assert gq.task_scaling(wrenches, wanted, "l1").value <= most * (1 + 1e-9)
    fewer = gq.task_scaling(wrenches[:-1] or wrenches, wanted).value
    assert fewer <= most * (1 + 1e-9)


def test_a_boundary_point_of_known_scale():
    # A convex combination of columns lies inside; the support plane stops its multiples.
    rng = np.random.default_rng(4)
    for _ in range(50):
        wrenches = grasp(rng, "soft", 12)
        u = rng.normal(size=6)
        corner = sum(w[:, np.argmax(u @ w)] for w in wrenches)
        if u @ corner <= 0 or any((u @ w).max() < 0 for w in wrenches):
            continue
        assert gq.task_scaling(wrenches, corner).value == pytest.approx(1.0, rel=1e-10)


def test_many_tasks_equal_the_worst_of_single_ones():
    rng = np.random.default_rng(9)
    for _ in range(30):
        wrenches = grasp(rng, "soft", 12)
        wanted = gq.gravity_tasks(0.4, 0.01 * rng.normal(size=3), rng.normal(size=3))
        alone = [gq.task_scaling(wrenches, t).value for t in wanted.T]
        together = gq.task_scaling(wrenches, wanted)
        assert together.value == pytest.approx(min(alone), rel=1e-10)


def test_rows_of_any_layout_give_the_same():
    rng = np.random.default_rng(2)
    wrenches, wanted = grasp(rng, "soft", 12), rng.normal(size=(6, 2))
    value = gq.task_scaling(wrenches, wanted).value
    frozen = [np.asfortranarray(w) for w in wrenches]
    for w in frozen:
        w.setflags(write=False)
    assert gq.task_scaling(frozen, np.asfortranarray(wanted)).value == value
    # Lists go through code compiled apart, which may round the last digits differently; the
    # search stops at 1e-12.
    listed = gq.task_scaling([w.tolist() for w in wrenches], wanted.tolist()).value
    assert listed == pytest.approx(value, rel=1e-12)


def test_wide_patches_are_solved_without_the_linear_program(monkeypatch):
    # Above 256 columns the likely ones are asked first; the way out must stay unused.
    from graspq.contact import tangent_basis

    rng = np.random.default_rng(1)
    grasps, wanted = [], []
    for _ in range(30):
        made = []
        for _ in range(6):
            n = rng.normal(size=3)
            n /= np.linalg.norm(n)
            a, b = tangent_basis(n)
            p = -0.05 * n + 0.01 * rng.normal(size=3)
            at = rng.uniform(-0.01, 0.01, (46, 2))
            contact = gq.Contact(p, n, 0.6, 1.0, 0.01, p + at[:, :1] * a + at[:, 1:] * b)
            made.append(gq.contact_wrenches(contact, 12, "hf"))
        grasps.append(made)
        wanted.append(gq.gravity_tasks(0.3, 0.005 * rng.normal(size=3), rng.normal(size=3)))
    for g in range(3):
        exact = gq.task_scaling(grasps[g], wanted[g][:, :2], engine="highs").value
        assert gq.task_scaling(grasps[g], wanted[g][:, :2]).value == pytest.approx(exact, rel=1e-9)

    def never(*_):
        raise AssertionError("fell back to the linear program")

    monkeypatch.setattr(lp, "scale_all_by_lp", never)
    batch = gq.task_scaling_batch(grasps, wanted)
    np.testing.assert_array_less(batch.upper, batch.value * (1 + 1e-9) + 1e-300)
