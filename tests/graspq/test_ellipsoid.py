"""The exact friction ellipsoid against its closed form and inscribed polytopes."""

import contextlib
import time

import numpy as np
import pytest

import graspq as gq
from tests.support.random_grasps import contacts, tasks


def sets(made, edges, augment="none"):
    return [gq.contact_wrenches(c, edges, augment) for c in made]


def test_support_is_the_closed_form():
    contact = gq.Contact([0.1, 0.2, 0.3], [0, 0, 1.0], 0.5, 4.0, 0.3)
    w = gq.contact_wrenches(contact, None, origin=contact.position)
    assert isinstance(w, gq.EllipsoidSet)
    rng = np.random.default_rng(1)
    for u in rng.normal(size=(20, 6)):
        push = 4.0 * u[2]
        side = np.sqrt((2.0 * u[0]) ** 2 + (2.0 * u[1]) ** 2 + (0.3 * u[5]) ** 2)
        # Round-off is relative to the terms: they cancel down to a fifteenth of their sizes.
        assert w.support(u) == pytest.approx(push + side, rel=0, abs=4e-15 * (abs(push) + side))


@pytest.mark.parametrize("augment", ["fl", "hf", "sf"])
def test_every_vertex_of_the_samples_lies_in_the_exact_set(augment):
    patch = np.array([[0.1, 0.2, 0.3], [0.11, 0.2, 0.3]])
    contact = gq.Contact([0.1, 0.2, 0.3], [0, 0, 1.0], 0.5, 4.0, 0.3, patch)
    exact = gq.contact_wrenches(contact, None, augment)
    sampled = gq.contact_wrenches(contact, 12, augment)
    for u in np.random.default_rng(2).normal(size=(200, 6)):
        assert exact.support(u) >= (u @ sampled).max() * (1 - 1e-12)


def test_round_friction_force_of_two_fingers():
    made = [gq.Contact([s * 0.03, 0, 0], [-s, 0, 0], 0.5, 2.0) for s in (1.0, -1.0)]
    for angle in np.linspace(0, 1, 7):
        pull = np.array([0, np.cos(angle), np.sin(angle), 0, 0, 0])
        s = gq.task_scaling(sets(made, None), pull)
        assert s.value == pytest.approx(2.0, rel=1e-9)
        assert s.lower <= s.value <= s.upper


@pytest.mark.parametrize("kind", ["random", "soft", "patch", "antipodal", "symmetric"])
def test_polytopes_converge_to_the_ellipsoid_from_below(kind):
    closest = []
    for seed in range(12):
        rng = np.random.default_rng([seed, 8])
        made = contacts(rng, kind)
        augment = "hf" if kind == "patch" else "none"
        coarse = sets(made, 12, augment)
        wanted = tasks(rng, coarse)[:, :1]
        if np.abs(wanted).max() < 1e-6:
            continue
        exact = gq.task_scaling(sets(made, None, augment), wanted)
        sampled = gq.task_scaling(coarse, wanted).value
        assert sampled <= exact.upper * (1 + 1e-9)
        if exact.value > 0:
            aim = exact.value * wanted[:, 0]
            np.testing.assert_allclose(exact.forces.sum(0), aim, atol=1e-6 * np.abs(aim).max())
            if not any(c.max_torsion for c in made):
                fine = gq.task_scaling(sets(made, 200, augment), wanted).value
                closest.append(1 - fine / exact.value)
    assert not closest or 0 <= max(0.0, np.median(closest)) < 2e-3


def test_epsilon_and_closure_of_exact_sets():
    closed = 0
    for seed in range(12):
        rng = np.random.default_rng([seed, 3])
        made = contacts(rng, "soft")
        exact, sampled = gq.epsilon(sets(made, None)), gq.epsilon(sets(made, 12))
        assert exact >= sampled * (1 - 1e-9)
        assert gq.is_force_closure(sets(made, None)) == (exact > 0)
        closed += exact > 0
        if exact > 0:
            unit = rng.normal(size=(6, 40))
            reach = gq.task_scaling(sets(made, None), unit / np.linalg.norm(unit, axis=0), tol=1e-6)
            assert reach.upper >= exact * (1 - 1e-4)
    assert closed > 1


def test_the_discretisation_error_shrinks():
    made = [gq.Contact([s * 0.03, 0, 0], [-s, 0, 0], 0.5, 2.0) for s in (1.0, -1.0)]
    pull = np.array([[0, np.cos(0.26), np.sin(0.26), 0, 0, 0]]).T
    errors = [gq.discretisation_error(made, pull, edges) for edges in (6, 12, 48)]
    assert errors[0] > errors[1] > errors[2] >= 0
    assert errors[0] == pytest.approx(1 - np.cos(np.pi / 6) / np.cos(np.pi / 6 - 0.26), abs=1e-6)


def test_what_needs_vertices_says_so():
    made = sets([gq.Contact([0, 0, 0], [0, 0, 1.0], 0.5)], None)
    with pytest.raises(gq.GraspError, match="edges"):
        gq.task_scaling(made, np.eye(6)[0], engine="highs")


@pytest.mark.parametrize("kind", ["antipodal", "symmetric", "patch"])
def test_epsilon_of_round_sets_ends_soon_and_never_below_the_sample(kind):
    # Sets of revolution touch their ball along whole arcs: an answer or an error, and soon.
    augment = "sf" if kind == "patch" else "none"
    spent = []
    for seed in (0, *range(4)):
        rng = np.random.default_rng([seed, 41])
        made = contacts(rng, kind)
        begin, exact = time.process_time(), np.inf
        with contextlib.suppress(gq.GraspError):
            exact = gq.epsilon(sets(made, None, augment), tol=1e-4)
        assert exact >= gq.epsilon(sets(made, 12, augment)) * (1 - 1e-6)
        spent.append(time.process_time() - begin)
    assert max(spent[1:]) < 30  # the first compiles


def test_a_task_on_the_edge_of_sets_that_only_just_hold_the_origin():
    # A contact without force puts the origin at a vertex of the hull: unloading or not is one.
    for seed in range(6):
        rng = np.random.default_rng([seed, 17])
        made = sets(contacts(rng, "idle"), None)
        wanted = sum(w.centres[:, 0] for w in made)
        free, bound = (gq.task_scaling(made, wanted, "l1", u) for u in (True, False))
        assert free.value > 0
        assert bound.value == pytest.approx(free.value, rel=1e-6)
