"""The tactile arrays as a device: published slopes, the law of creep, conservation, dead taxels."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from sdh_sim.sensing import SensorModel, TactileSensor
from sdh_sim.sensing.tactile_sensor import FRAME_RATE, PRESETS, spread_pressure
from tests.support.sdh2 import PAD_OFFSETS, SDH2, arrays, live_mask

DSA = SensorModel()  # the preset
STATIC = SensorModel(crosstalk=0.0, creep_share=0.0, noise=0.0, gain_spread=0.0)
DISTAL = int(PAD_OFFSETS[3])  # first cell of a distal pad


def stamp(force: float) -> np.ndarray:
    """A force [N] on 3 x 3 cells in the middle of the first distal pad."""
    forces = np.zeros(486)
    rows, columns = np.mgrid[6:9, 1:4]
    forces[(DISTAL + rows * 6 + columns).ravel()] = force / 9
    return forces


def reading(model: SensorModel | None, forces: np.ndarray, seconds: float = 1 / 30) -> np.ndarray:
    sensor = TactileSensor(model, np.random.default_rng(0))
    for _ in range(round(seconds * FRAME_RATE)):
        sensor.frame(forces)
    return sensor.read()


def test_the_ideal_array_reads_the_pressure():
    force = stamp(5.0)
    assert reading(PRESETS["ideal"], force) == pytest.approx(force / 3.4e-3**2 * 1e-3)


def test_dead_zone_gain_and_clip_of_the_static_part():
    model = replace(STATIC, dead_zone=8.0)
    kpa = np.array([0.0, 8.0, 8.0 + 0.99 / 52, 8.0 + 1.01 / 52, 20.0001, 8 + 3500.5 / 52, np.inf])
    counts = model.counts(kpa)
    assert counts == pytest.approx([0, 0, 0, 1, 624, 3500, 3500])


def test_readings_are_whole_counts_of_12_bit_that_rise_with_pressure():
    pressure = np.sort(np.random.default_rng(0).uniform(0, 200, 2000))
    counts = STATIC.counts(pressure)
    assert counts == pytest.approx(np.round(counts), abs=1e-9)
    assert (np.diff(counts) >= -1e-9).all()
    assert 0 == counts.min() < counts.max() <= 3500 < 2**12


def test_sum_under_a_stamp_follows_the_published_line():
    # 4513 F - 3953 counts at 3 s under a stamp of 10.5 mm side, which covers 9.54 cells; here it
    # covers 9. No noise, no spread: those have no published value.
    model = replace(DSA, noise=0.0, gain_spread=0.0)
    for force in (4.0, 6.0, 8.0):
        counts = reading(model, stamp(force), 3.0).sum() * 52
        assert counts == pytest.approx(4513 * force - 3953, rel=0.03)


@pytest.mark.parametrize(("seconds", "slope"), [(0.5, 2810), (3.0, 4513), (10.0, 5074)])
def test_slope_creeps_as_published(seconds, slope):
    model = replace(DSA, noise=0.0, gain_spread=0.0, dead_zone=0.0)
    counts = reading(model, stamp(2.0), seconds).sum() * 52
    assert counts / 2.0 == pytest.approx(slope, rel=0.03)


def test_creep_is_a_standard_linear_solid():
    # Step of pressure p at t = 0: reading = p (1 - a exp(-t/T)) / (1 - a exp(-3/T)), exactly, at
    # every frame (the clip is far, one count is 0.02 kPa). Release: the late share decays alike.
    a, late = 0.587, 1.85
    model = replace(STATIC, creep_share=a, creep_time=late, dead_zone=0.0)
    sensor = TactileSensor(model, np.random.default_rng(0))
    force = np.zeros(486)
    force[0] = 20e3 * 3.4e-3**2  # 20 kPa
    scale = 20.0 / (1 - a * np.exp(-3.0 / late))
    for k in range(1, 200):
        sensor.frame(force)
        expected = scale * (1 - a * np.exp(-k / 30 / late))
        assert sensor.read()[0] == pytest.approx(expected, abs=0.021)
    stored = 1 - np.exp(-199 / 30 / late)
    for k in range(1, 60):
        sensor.frame(np.zeros(486))
        expected = scale * a * stored * np.exp(-k / 30 / late)
        assert sensor.read()[0] == pytest.approx(expected, abs=0.021)


def test_a_stamp_lights_as_many_cells_as_published():
    lit = np.flatnonzero(reading(DSA, stamp(5.0), 3.0))
    assert 16 <= len(lit) <= 28
    alone = replace(DSA, crosstalk=0.0)
    assert np.count_nonzero(reading(alone, stamp(5.0), 3.0)) == 9


def test_crosstalk_keeps_the_sum_and_stays_on_the_pad():
    pressure = np.random.default_rng(1).uniform(0, 100, 486)
    live = np.concatenate(
        [live_mask("proximal").ravel()] * 3 + [live_mask("distal").ravel()] * 3
    )  # fmt: skip
    pressure[~live] = 0.0
    spread = spread_pressure(pressure, 0.1, SDH2)
    assert spread.sum() == pytest.approx(pressure.sum(), rel=1e-12)
    for first, last in itertools.pairwise(PAD_OFFSETS):
        assert spread[first:last].sum() == pytest.approx(pressure[first:last].sum(), rel=1e-12)
    assert not spread[~live].any()
    assert spread_pressure(np.where(live, 7.0, 0.0), 0.1, SDH2) == pytest.approx(
        np.where(live, 7.0, 0.0)
    )


def test_crosstalk_of_one_cell_worked_by_hand():
    pressure = np.zeros(486)
    pressure[DISTAL + 7 * 6 + 2] = 100.0
    _, distal = arrays(spread_pressure(pressure, 0.1, SDH2))
    expected = np.zeros((13, 6))
    expected[7, 2] = 60.0
    expected[[6, 8], 2] = expected[7, [1, 3]] = 10.0
    assert distal[0] == pytest.approx(expected)


def test_unloaded_cells_read_nothing_however_noisy():
    noisy = replace(STATIC, noise=500.0)
    values = reading(noisy, stamp(5.0))
    assert np.flatnonzero(values).size <= 9
    assert (values >= 0).all()


def test_noise_has_its_standard_deviation_and_comes_from_the_generator():
    model = replace(STATIC, noise=20.0)
    force = np.full(486, 30e3 * 3.4e-3**2)
    values = reading(model, force) * 52
    assert np.std(values) == pytest.approx(20.0, rel=0.15)
    assert np.array_equal(values, reading(model, force) * 52)


def test_gains_spread_but_belong_to_the_hand():
    model = replace(STATIC, gain_spread=0.05, dead_zone=0.0)
    force = np.full(486, 30e3 * 3.4e-3**2)
    first = reading(model, force)
    other = TactileSensor(model, np.random.default_rng(99))
    other.frame(force)
    assert np.array_equal(first, other.read())
    assert np.std(first) / np.mean(first) == pytest.approx(0.05, rel=0.15)


def test_dead_taxels_read_nothing():
    model = replace(STATIC, dead_share=0.2)
    values = reading(model, np.full(486, 30e3 * 3.4e-3**2))
    assert np.mean(values == 0) == pytest.approx(0.2, abs=0.06)


def test_presets_are_the_real_arrays_and_ideal_ones():
    assert PRESETS == {"dsa": DSA, "ideal": None}


def test_crosstalk_shows_what_acts_beside_the_outermost_taxels():
    # 5 N beside a taxel of 3.4 mm: a tenth of the pressure, as from a taxel to its neighbour.
    beside = np.zeros(486)
    beside[DISTAL + 7 * 6] = 5.0
    model = SensorModel(noise=0.0, gain_spread=0.0, dead_zone=0.0, clip=1e9)
    sensor = TactileSensor(model, np.random.default_rng(0))
    for _ in range(90):  # 3 s, to which the gain belongs
        sensor.frame(np.zeros(486), beside)
    reading = sensor.read()
    assert np.flatnonzero(reading).tolist() == [DISTAL + 7 * 6]
    assert reading.max() == pytest.approx(0.1 * 5.0 / 0.0034**2 * 1e-3, rel=1e-2)
    ideal = TactileSensor(None, np.random.default_rng(0))
    ideal.frame(np.zeros(486), beside)
    assert not ideal.read().any()
