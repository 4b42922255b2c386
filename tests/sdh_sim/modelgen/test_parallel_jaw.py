"""The parallel jaw's files as generated, and the closed forms that the generator uses."""

from __future__ import annotations

import numpy as np
import pytest

from sdh_sim.model_files import models_dir
from sdh_sim.modelgen import jaw_numbers, parallel_jaw
from sdh_sim.modelgen.jaw_meshes import jaw_meshes
from tests.support.generated_files import assert_same_files, model_files

FOLDER = models_dir() / "parallel_jaw"


def test_committed_files_are_what_the_script_makes(tmp_path):
    parallel_jaw.write_jaw(tmp_path)
    assert_same_files(tmp_path, FOLDER, model_files(FOLDER), "sdh_sim.modelgen.parallel_jaw")


def test_two_halves_of_a_box_have_its_inertia():
    # 3 kg of 0.1 x 0.2 x 0.4 m, cut at a third of its length: 3/12 (0.2² + 0.4²) and so on.
    lower = (1.0, ((0.0, 0.0, 0.0), (0.1, 0.2, 0.4 / 3)))
    upper = (2.0, ((0.0, 0.0, 0.4 / 3), (0.1, 0.2, 0.4)))
    mass, com, inertia = jaw_numbers.inertia(lower, upper)
    assert mass == pytest.approx(3.0)
    assert com == pytest.approx((0.05, 0.1, 0.2))
    assert inertia == pytest.approx(0.25 * np.diag([0.20, 0.17, 0.05]), abs=1e-12)


def test_two_boxes_side_by_side_have_products_of_inertia():
    # Two cubes of 1 kg and side 0.1 m with centres at ±(0.1, 0.2, 0): Ixy = -Σ m x y.
    cubes = [
        (1.0, ((s * 0.1 - 0.05, s * 0.2 - 0.05, -0.05), (s * 0.1 + 0.05, s * 0.2 + 0.05, 0.05)))
        for s in (1, -1)
    ]
    _, com, inertia = jaw_numbers.inertia(*cubes)
    assert com == pytest.approx((0, 0, 0), abs=1e-15)
    assert inertia[0, 1] == pytest.approx(-2 * 0.1 * 0.2)
    assert inertia[2, 2] == pytest.approx(2 * (0.01 / 6 + 0.05))


def test_meshes_are_closed_and_within_the_table():
    meshes = jaw_meshes()
    for name in ("housing", "guide", "neck", "carriage", "finger", "finger_core", "pad"):
        assert meshes[name].is_watertight, name
        assert meshes[name].volume > 0, name
    drawn, touched = meshes["finger"].bounds, meshes["finger_core"].bounds
    assert drawn[1] == pytest.approx(touched[1], abs=1e-5)
    assert drawn[0, :2] == pytest.approx(touched[0, :2], abs=1e-5)
    assert meshes["finger_core"].bounds == pytest.approx(np.array(jaw_numbers.FINGER))
    # The rubber is drawn a tenth of a millimetre low, so that recordings show what touches it.
    assert meshes["pad"].bounds[1, 0] == pytest.approx(jaw_numbers.PAD_SURFACE - 1e-4)
