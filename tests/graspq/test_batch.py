"""Batches equal single calls, with any number of workers."""

import numpy as np
import pytest

import graspq as gq
from tests.support.random_grasps import KINDS, contacts, grasp, tasks

# Batches and single calls are compiled apart, with sums in any order: a processor may round them
# differently, and a grasp close to degenerate makes more of that. Both promise this accuracy.
ACCURACY = 1e-9


def many(count=120):
    rng = np.random.default_rng(5)
    grasps = [grasp(rng, KINDS[g % len(KINDS)]) for g in range(count)]
    wanted = [tasks(rng, g) for g in grasps]
    wanted = [w[:, np.abs(w).max(axis=0) > 1e-6] for w in wanted]
    return grasps, [w if w.shape[1] else np.eye(6)[:, :1] for w in wanted]


@pytest.mark.parametrize("unloading", [True, False])
@pytest.mark.parametrize("bound", ["linf", "l1"])
def test_task_scaling_batch(bound, unloading):
    grasps, wanted = many()
    one = gq.task_scaling_batch(grasps, wanted, bound, unloading, workers=1)
    two = gq.task_scaling_batch(grasps, wanted, bound, unloading, workers=2)
    for a, b in zip(one, two, strict=True):
        np.testing.assert_array_equal(a, b)
    single = [gq.task_scaling(g, t, bound, unloading) for g, t in zip(grasps, wanted, strict=True)]
    np.testing.assert_allclose(one.value, [s.value for s in single], rtol=ACCURACY)
    # No two tasks of these grasps come within ACCURACY of each other.
    np.testing.assert_array_equal(one.critical_task, [s.critical_task for s in single])


def test_one_task_set_for_all():
    grasps, _ = many(30)
    wanted = gq.gravity_tasks(0.3, [0, 0, 0], [0, 0, -9.81])
    batch = gq.task_scaling_batch(grasps, wanted)
    np.testing.assert_allclose(
        batch.value, [gq.task_scaling(g, wanted).value for g in grasps], rtol=ACCURACY
    )


def test_epsilon_and_volume_batch():
    grasps, _ = many(40)
    one = gq.epsilon_batch(grasps, "l1", workers=1)
    np.testing.assert_array_equal(one, gq.epsilon_batch(grasps, "l1", workers=2))
    # Compiled apart, the two may round the last digit differently.
    np.testing.assert_allclose(one, [gq.epsilon(g, "l1") for g in grasps], rtol=1e-13)
    small = [g[:2] for g in grasps if max(w.shape[1] for w in g[:2]) < 16]
    np.testing.assert_array_equal(gq.volume_batch(small, workers=2), [gq.volume(g) for g in small])


@pytest.mark.parametrize("bound", ["linf", "l1"])
def test_an_array_is_as_good_as_lists(bound):
    rng = np.random.default_rng(9)
    grasps = [[gq.contact_wrenches(c, 6) for c in contacts(rng, "soft")[:3]] for _ in range(40)]
    wanted = [rng.normal(size=(6, 2)) for _ in grasps]
    array, tasks_array = np.array(grasps), np.array(wanted)
    assert array.shape == (40, 3, 6, 8)
    for workers in (1, 2):
        listed = gq.task_scaling_batch(grasps, wanted, bound, workers=workers)
        for a, b in zip(listed, gq.task_scaling_batch(array, tasks_array, bound, workers=workers),
                        strict=True):  # fmt: skip
            np.testing.assert_array_equal(a, b)
    # Any layout in memory, and no unloading, which goes grasp by grasp.
    turned = np.asfortranarray(array)
    np.testing.assert_array_equal(
        gq.task_scaling_batch(turned, wanted, bound, False).value,
        gq.task_scaling_batch(grasps, wanted, bound, False).value,
    )
    np.testing.assert_array_equal(gq.epsilon_batch(turned, bound), gq.epsilon_batch(grasps, bound))
    np.testing.assert_array_equal(
        gq.volume_batch(array[:4, :2], bound), gq.volume_batch([g[:2] for g in grasps[:4]], bound)
    )


@pytest.mark.parametrize("shape", [(4, 6, 8), (4, 3, 5, 8), (4, 0, 6, 8), (4, 3, 6, 0), (4,)])
def test_an_array_of_another_shape_is_refused(shape):
    with pytest.raises(gq.GraspError, match=r"grasps\[0\]"):
        gq.task_scaling_batch(np.ones(shape), np.eye(6)[:, :1])


def test_an_array_with_no_number_in_it_is_refused():
    array = np.ones((3, 2, 6, 5))
    array[1, 1, 2, 3] = np.nan
    with pytest.raises(gq.GraspError, match="finite"):
        gq.task_scaling_batch(array, np.eye(6)[:, :1])


def test_ellipsoids_in_a_batch():
    rng = np.random.default_rng(1)
    grasps = [[gq.contact_wrenches(c, None) for c in contacts(rng, "soft")] for _ in range(6)]
    pull = np.eye(6)[:, :1]
    np.testing.assert_array_equal(
        gq.task_scaling_batch(grasps, pull).value, [gq.task_scaling(g, pull).value for g in grasps]
    )


def test_bad_input_names_the_grasp():
    grasps, wanted = many(4)
    with pytest.raises(gq.GraspError, match=r"grasps\[2\].*finite"):
        gq.task_scaling_batch([*grasps[:2], [np.full((6, 3), np.nan)], grasps[3]], wanted[0])
    with pytest.raises(gq.GraspError, match="one per grasp"):
        gq.task_scaling_batch(grasps, wanted[:3])
    with pytest.raises(gq.GraspError, match=r"tasks\[1\]"):
        gq.task_scaling_batch(grasps, [wanted[0], np.zeros((6, 1)), *wanted[2:]])
    for shape in [(4, 5, 1), (4, 6, 0)]:
        with pytest.raises(gq.GraspError, match=r"tasks\[0\]"):
            gq.task_scaling_batch(grasps, np.ones(shape))
    with pytest.raises(gq.GraspError, match="workers"):
        gq.epsilon_batch(grasps, workers=0)
    with pytest.raises(gq.GraspError, match="grasps"):
        gq.volume_batch([])
