"""The minimum weight against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import graspq as gq
from tests.support.field_contacts import field_contacts

E = np.eye(6)


def test_weights_on_a_line():
    # w and -2 w cancel with weights 2/3 and 1/3.
    assert gq.minimum_weight([E[:, :1], -2 * E[:, :1]]) == pytest.approx(1 / 3)
    # w and 2 w with 2 and -1 alone: no force closure.
    assert gq.minimum_weight([E[:, :1], 2 * E[:, :1]]) == pytest.approx(-1.0)
    # A single wrench, or twice the same, never cancels.
    assert gq.minimum_weight([E[:, :1]]) == -np.inf
    assert gq.minimum_weight([E[:, :1], E[:, :1]]) == -np.inf


def test_equal_weights_are_the_best():
    both = [np.column_stack([e, -e]) for e in E]
    assert gq.minimum_weight(both) == pytest.approx(1 / 12)
    positions, normals = field_contacts()["cube"]
    for edges in (4, 6, 12):
        sets = gq.unit_wrenches(positions, normals, 0.5, edges)
        assert gq.minimum_weight(sets) == pytest.approx(1 / (6 * edges))


@pytest.mark.parametrize("name", ["ellipsoid_3", "ellipsoid_4", "ellipsoid_6", "one_side"])
def test_the_frame_does_not_matter_and_the_sign_says_force_closure(name):
    sets = list(gq.unit_wrenches(*field_contacts()[name], 0.5, 4))
    value = gq.minimum_weight(sets)
    assert (value > 0) == gq.is_force_closure(sets)
    change = np.random.default_rng(3).normal(size=(6, 6))
    assert gq.minimum_weight([change @ w for w in sets]) == pytest.approx(value, rel=1e-8)
    assert gq.minimum_weight([1e-6 * w for w in sets[::-1]]) == pytest.approx(value, rel=1e-8)


def test_bad_input_is_named():
    with pytest.raises(gq.GraspError, match="empty"):
        gq.minimum_weight([])
    with pytest.raises(gq.GraspError, match="finite"):
        gq.minimum_weight([np.full((6, 2), np.nan)])
    round_cone = gq.contact_wrenches(gq.Contact([0, 0, 0], [0, 0, 1], 0.5), None)
    with pytest.raises(gq.GraspError, match="minimum_weight needs vertices"):
        gq.minimum_weight([round_cone])
