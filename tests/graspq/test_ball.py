"""ε and force closure against qhull, closed forms and q*."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import graspq as gq
from graspq._engines.qhull_check import product_epsilon
from graspq.contact import tangent_basis
from tests.support.random_grasps import KINDS, grasp

quick = settings(max_examples=15, deadline=None)
seeds = st.integers(0, 2**32 - 1)


@pytest.mark.parametrize("kind", KINDS)
def test_epsilon_equals_that_of_the_whole_hull(kind):
    for seed in range(30):
        rng = np.random.default_rng([seed, 31])
        wrenches = grasp(rng, kind)
        size = np.prod([w.shape[1] + 1 for w in wrenches], dtype=float)
        bound = "linf" if size < 300 else "l1"
        unloading = bool(rng.integers(2))
        value = gq.epsilon(wrenches, bound, unloading)
        scale = np.abs(np.hstack(wrenches)).max()
        assert value == pytest.approx(
            product_epsilon(wrenches, bound, unloading), abs=1e-11 * scale
        )
        if unloading:
            assert gq.is_force_closure(wrenches) == (value > 0)


@quick
@given(seeds, st.floats(0.01, 100.0))
def test_scaling_and_turning(seed, factor):
    from scipy.spatial.transform import Rotation

    rng = np.random.default_rng(seed)
    wrenches = grasp(rng, "soft", 6)
    value = gq.epsilon(wrenches)
    assert gq.epsilon([factor * w for w in wrenches]) == pytest.approx(factor * value, rel=1e-9)
    both = np.kron(np.eye(2), Rotation.random(rng=rng).as_matrix())
    assert gq.epsilon([both @ w for w in wrenches]) == pytest.approx(value, rel=1e-9)
    assert gq.epsilon(wrenches, "l1") <= value * (1 + 1e-9)


@quick
@given(seeds)
def test_epsilon_is_the_smallest_q_of_unit_tasks(seed):
    rng = np.random.default_rng(seed)
    wrenches = grasp(rng, "soft", 6)
    value = gq.epsilon(wrenches)
    unit = rng.normal(size=(6, 30))
    unit /= np.linalg.norm(unit, axis=0)
    reach = gq.task_scaling(wrenches, unit).value
    assert reach >= value * (1 - 1e-9)
    if value > 0:
        from scipy.optimize import minimize

        support = gq.WrenchSpace(wrenches).support
        # The nearest facet's normal: the unit direction of smallest support.
        starts = rng.normal(size=(300, 6))
        starts /= np.linalg.norm(starts, axis=1)[:, None]
        best = starts[np.argmin(support(starts))]
        found = minimize(
            lambda u: support(u) / np.linalg.norm(u),
            best,
            method="Nelder-Mead",
            options={"maxiter": 1500},
        )
        assert found.fun >= value * (1 - 1e-9)


def test_the_worst_direction_reaches_exactly_epsilon():
    grasp_ = [
        np.column_stack([e, -e]) * s for e, s in zip(np.eye(6), [3, 1, 2, 4, 5, 6], strict=True)
    ]
    assert gq.epsilon(grasp_, unloading=False) == pytest.approx(1.0, rel=1e-12)
    assert gq.task_scaling(grasp_, np.eye(6)[1], unloading=False).value == pytest.approx(1.0)


def test_six_contacts_and_patches_are_within_reach():
    rng = np.random.default_rng(0)
    made = []
    for _ in range(6):
        n = rng.normal(size=3)
        n /= np.linalg.norm(n)
        a, b = tangent_basis(n)
        p = -0.05 * n + 0.01 * rng.normal(size=3)
        patch = p + 0.005 * (rng.normal(size=(84, 1)) * a + rng.normal(size=(84, 1)) * b)
        made.append(gq.Contact(p, n, 0.6, 1.0, 0.01, patch))
    bare = gq.epsilon([gq.contact_wrenches(c) for c in made])
    padded = gq.epsilon([gq.contact_wrenches(c, 12, "hf") for c in made])
    assert padded >= bare > 0
