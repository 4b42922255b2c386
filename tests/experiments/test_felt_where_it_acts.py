"""The arrays feel forces where they act: a wire pressed on a pad, on it and off it."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.validation.rig_readings import imprint, pressed, sphere_forces
from experiments.validation.rigs import Shape, bench, settings_for
from sdh_sim.cell.contacts import hand_force

PAD, FORCE = "finger1_proximal", 10.0
# Along the finger, thin beside the spheres of rubber: they all touch it within 4 % of their
# distance from it, wherever their apexes are.
WIRE = Shape("cylinder", (5e-4, 0.03), (5e-4, 0.0, 0.0))


@pytest.mark.parametrize("column", [2.0, 2.3, 2.5, 4.6])
def test_a_wire_is_felt_in_the_columns_beside_it(column):
    scene = bench(PAD, 6.5, column, [WIRE], ["press"], settings_for(), 0.0)
    data = pressed(scene, FORCE)
    columns = imprint(scene, data, PAD).forces.sum(axis=0)
    share = column - np.floor(column)
    low = int(column)
    expected = np.zeros(7)
    expected[low : low + 2] = 1.0 - share, share
    assert columns / columns.sum() == pytest.approx(expected[:6], abs=0.05)
    assert columns @ np.arange(6) / columns.sum() == pytest.approx(column, abs=0.03)
    # The springs that bear it need not lie there: at 2.3 those of column 2 bear nearly all of it.
    springs = sphere_forces(scene, data, PAD).sum(axis=0)
    assert springs.sum() == pytest.approx(columns.sum())
    assert column != 2.3 or springs @ np.arange(6) / springs.sum() < 2.1


@pytest.mark.parametrize(("column", "on_array"), [(-0.4, True), (-0.6, False), (5.6, False)])
def test_what_acts_beyond_the_border_is_unsensed(column, on_array):
    scene = bench(PAD, 6.5, column, [WIRE], ["press"], settings_for(), 0.0)
    data = pressed(scene, FORCE)
    sensed, unsensed = hand_force(scene, data)
    whole = sphere_forces(scene, data, PAD).sum()
    assert sensed + unsensed == pytest.approx(whole)
    assert imprint(scene, data, PAD).total == pytest.approx(sensed)
    assert (sensed, unsensed) == pytest.approx((whole, 0.0) if on_array else (0.0, whole))
