"""The grasp objects: facts of the paper, shape of what collides, files as the script makes them."""

import mujoco
import numpy as np
import pytest
import trimesh

from sdh_sim.model_files import models_dir
from sdh_sim.modelgen import lofts, objects
from sdh_sim.modelgen.surface_nets import union_surface
from tests.support.generated_files import assert_same_files, model_files

# Mass [kg], friction, centre of mass [mm], low and high corner [mm], axis that stands up.
PAPER = {
    "box": (0.831, 0.63, (-0.34, 11.62, -8.30), (-35.9, -85.0, -77.6), (35.2, 108.2, 61.0), 1),
    "oval_bottle": (
        0.785, 0.63, (0.52, 7.26, 12.68), (-30.3, -46.65, -136.4), (30.3, 46.65, 136.4), 2,
    ),
    "spray_bottle": (
        0.634, 0.68, (-0.82, 1.20, 7.44), (-29.4, -45.8, -122.15), (29.4, 45.8, 122.15), 2,
    ),
    "cylindrical_bottle": (
        0.556, 0.60, (-2.36, -19.93, 1.36), (-34.75, -105.1, -34.45), (34.75, 105.1, 34.45), 1,
    ),
}  # fmt: skip
FOLDER = models_dir() / "objects"
NAMES = tuple(PAPER)

# The corners are known to 0.1 mm; rounding of the table on either side.
CORNER_TOLERANCE = 0.1e-3 + 1e-9


@pytest.fixture(scope="module", params=NAMES)
def name(request):
    return request.param


@pytest.fixture(scope="module")
def model(name):
    return mujoco.MjModel.from_xml_path(str(FOLDER / name / f"{name}.xml"))


def outer_mesh(name):
    return trimesh.load_mesh(FOLDER / name / "assets" / f"{name}.obj", process=False)


def standing(name):
    """The object with a free joint on a table plane."""
    spec = mujoco.MjSpec.from_file(str(FOLDER / name / f"{name}.xml"))
    spec.body("object").add_freejoint()
    spec.worldbody.add_geom(
        name="table", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 0.1], conaffinity=15
    )
    spec.option.timestep = 0.002
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    return spec.compile()


def object_points(model, geoms):
    """Extreme points of geoms in the object's frame, (n, 3): mesh vertices or the geom's box."""
    points = []
    for g in geoms:
        rotation = np.empty(9)
        mujoco.mju_quat2Mat(rotation, model.geom_quat[g])
        if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_MESH:
            start = model.mesh_vertadr[model.geom_dataid[g]]
            local = model.mesh_vert[start : start + model.mesh_vertnum[model.geom_dataid[g]]]
        else:
            signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T
            local = signs * model.geom_aabb[g, 3:]
        points.append(local @ rotation.reshape(3, 3).T + model.geom_pos[g])
    return np.concatenate(points)


def test_mass_friction_and_centre_of_mass_are_the_papers(name, model):
    mass, friction, com, *_ = PAPER[name]
    body = model.body("object").id
    assert model.body_mass[body] == pytest.approx(mass, abs=1e-12)
    assert model.body_ipos[body] == pytest.approx(np.array(com) / 1e3, abs=1e-9)
    touching = model.geom_group == 3
    assert np.all(model.geom_friction[touching] == [friction, 0.005, 0.0001])
    assert np.all(model.geom_condim[touching] == 3)
    assert np.all(model.geom_contype[touching] == 1)
    assert np.all(model.geom_conaffinity[touching] == 15)


def test_what_is_drawn_does_not_touch(model):
    drawn = model.geom_group == 2
    assert drawn.any()
    assert np.all(model.geom_contype[drawn] == 0)
    assert np.all(model.geom_conaffinity[drawn] == 0)
    assert np.all(drawn | (model.geom_group == 3))


@pytest.mark.parametrize("group", [2, 3])
def test_extents_are_the_papers(name, model, group):
    *_, low, high, _ = PAPER[name]
    points = object_points(model, np.flatnonzero(model.geom_group == group))
    # Stickers stand up to 0.1 mm proud of what is touched.
    slack = CORNER_TOLERANCE + (1e-4 if group == 2 else 0.0)
    assert points.min(0) == pytest.approx(np.array(low) / 1e3, abs=slack)
    assert points.max(0) == pytest.approx(np.array(high) / 1e3, abs=slack)


def test_outer_mesh_is_one_closed_surface_of_the_papers_size(name):
    *_, low, high, _ = PAPER[name]
    mesh = outer_mesh(name)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.body_count == 1
    assert mesh.volume > 0
    assert 1000 < len(mesh.faces) < 8000
    assert mesh.bounds[0] == pytest.approx(np.array(low) / 1e3, abs=CORNER_TOLERANCE)
    assert mesh.bounds[1] == pytest.approx(np.array(high) / 1e3, abs=CORNER_TOLERANCE)
    # No folds: a vertex normal of a metric study would point nowhere there.
    assert np.degrees(mesh.face_adjacency_angles.max()) < 115


def test_inertia_is_that_of_the_homogeneous_solid(name, model):
    body = model.body("object").id
    mesh = outer_mesh(name)
    density = PAPER[name][0] / mesh.volume
    expected = np.sort(np.linalg.eigvalsh(mesh.moment_inertia)) * density
    moments = np.sort(model.body_inertia[body])
    assert moments == pytest.approx(expected, rel=1e-3)
    assert moments[0] + moments[1] > moments[2] > 0


def test_inertia_of_the_box_by_hand():
    model = mujoco.MjModel.from_xml_path(str(FOLDER / "box" / "box.xml"))
    x, y, z = 0.0712, 0.1933, 0.1386
    by_hand = 0.831 / 12 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, model.body_iquat[1])
    axes = rotation.reshape(3, 3)
    full = axes @ np.diag(model.body_inertia[1]) @ axes.T
    assert full == pytest.approx(np.diag(by_hand), rel=1e-5, abs=1e-9)


def test_it_stands_where_it_is_put(name):
    *_, up = PAPER[name]
    model = standing(name)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.site("base").xpos == pytest.approx(np.zeros(3), abs=1e-9)
    assert data.site("base").xmat.reshape(3, 3) == pytest.approx(np.eye(3), abs=1e-9)
    assert data.body("object").xmat.reshape(3, 3)[:, up] == pytest.approx([0, 0, 1], abs=1e-9)
    start = data.qpos.copy()
    while data.time < 1.0:
        mujoco.mj_step(model, data)
    assert np.linalg.norm(data.qpos[:3] - start[:3]) < 5e-4
    assert np.linalg.norm(data.qpos[3:] - start[3:]) < 5e-3
    assert not np.any(data.warning.number)


def test_it_survives_being_thrown_about(name):
    model = standing(name)
    data = mujoco.MjData(model)
    rng = np.random.default_rng(3)
    for _ in range(500):
        data.qfrc_applied[:3] = rng.normal(0, 8, 3)
        data.qfrc_applied[3:] = rng.normal(0, 0.3, 3)
        mujoco.mj_step(model, data)
    assert not np.any(data.warning.number)
    assert np.all(np.isfinite(data.qpos))
    assert data.qpos[2] > 0


def test_a_sphere_rolled_over_the_surface_meets_no_step(name):
    """Height of the surface along lines up its side: continuous, and where the drawing has it."""
    model = mujoco.MjModel.from_xml_path(str(FOLDER / name / f"{name}.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    touched = np.array([0, 0, 0, 1, 0, 0], np.uint8)
    top = object_points(model, np.flatnonzero(model.geom_group == 3))
    height = np.ptp(top[:, PAPER[name][5]])
    # The grip region: above the heel, below the spray head and the bottles' caps.
    heights = np.linspace(0.05, 0.68 if name != "cylindrical_bottle" else 0.78, 400) * height
    hit = np.zeros(1, np.int32)
    for angle in np.linspace(0.1, 2 * np.pi, 9):
        towards = -np.array([np.cos(angle), np.sin(angle), 0.0])
        radius = np.array(
            [
                0.3 - mujoco.mj_ray(
                    model, data, z * np.array([0, 0, 1.0]) - 0.3 * towards, towards,
                    touched, 1, -1, hit,
                )
                for z in heights
            ]
        )  # fmt: skip
        step = heights[1] - heights[0]
        assert radius.min() > 0.01
        assert np.abs(np.diff(radius)).max() < 1.6 * step, f"a step at {angle:.2f} rad"


def test_the_spray_bottle_has_a_waist_and_a_trigger():
    mesh = outer_mesh("spray_bottle")

    def widths(z):
        """Extents along y of the pieces of the section at height z [m], from back to front."""
        lines = np.asarray(trimesh.intersections.mesh_plane(mesh, [0, 0, 1], [0, 0, z]))
        y = np.sort(lines[:, :, 1], axis=1)
        y = y[np.argsort(y[:, 0])]
        reach = np.maximum.accumulate(y[:, 1])
        starts = np.flatnonzero(y[1:, 0] > reach[:-1] + 1e-4) + 1
        return [np.ptp(piece) for piece in np.split(y, starts)]

    (body,), (waist,) = widths(-0.06), widths(0.036)
    assert waist < 0.45 * body
    assert waist < 0.9 * widths(0.060)[0]
    # Below the head the lever hangs in front of the collar, with air between.
    assert len(widths(0.07)) == 2


def test_collision_meshes_are_convex(name):
    _, shape = objects.build(name)
    for solid in shape.solids:
        volume = solid.mesh.convex_hull.volume
        assert solid.mesh.volume == pytest.approx(volume, rel=1e-3), solid.name


def test_committed_files_are_what_the_script_makes(tmp_path):
    objects.write(tmp_path)
    kept = [path for path in model_files(FOLDER) if path.parts[0] in NAMES]
    assert_same_files(tmp_path, FOLDER, kept, "sdh_sim.modelgen.objects")


def test_no_file_is_large():
    sizes = {p: p.stat().st_size for p in FOLDER.rglob("*") if p.is_file()}
    assert max(sizes.values()) < 300_000


def test_lofts_have_the_volume_of_the_solids_they_stand_for():
    for axis in "xyz":
        rod = lofts.cylinder(0.03, 0.1, 0.2, axis, (0.01, 0.02), n=400)
        assert rod.volume == pytest.approx(np.pi * 0.03**2 * 0.1, rel=1e-3)
        centre = {"z": (0.01, 0.02, 0.15), "x": (0.15, 0.01, 0.02), "y": (0.02, 0.15, 0.01)}[axis]
        assert rod.center_mass == pytest.approx(centre, abs=1e-9)
        block = lofts.rounded_box((0, 0, 0), (0.1, 0.2, 0.3), 0.01, 0.004, axis, n=64)
        assert block.bounds == pytest.approx(np.array([[0, 0, 0], [0.1, 0.2, 0.3]]), abs=1e-9)
        assert 0.985 * 6e-3 < block.volume < 6e-3
    section = lofts.superellipse(0.03, 0.05, 64, 2.5, (0.01, 0.0))
    assert np.abs((section[:, 0] - 0.01) / 0.03) ** 2.5 + np.abs(section[:, 1] / 0.05) ** 2.5 == (
        pytest.approx(np.ones(64), abs=1e-3)
    )
    steps = np.linalg.norm(np.diff(section, axis=0, append=section[:1]), axis=1)
    assert steps.std() < 0.01 * steps.mean()


def test_lofts_refuse_what_has_no_volume():
    disc = lofts.superellipse(0.03, 0.03, 16)
    with pytest.raises(ValueError, match="inside out"):
        lofts.loft_sections([disc, disc], [0.1, 0.0])
    with pytest.raises(ValueError, match="one shape"):
        lofts.loft_sections([disc, lofts.superellipse(0.03, 0.03, 20)], [0.0, 0.1])
    with pytest.raises(ValueError, match="multiple of 4"):
        lofts.superellipse(0.03, 0.03, 30)
    with pytest.raises(ValueError, match="axis"):
        lofts.place(disc, 0.0, "w")
    open_mesh = trimesh.Trimesh(np.eye(3), [[0, 1, 2]], process=False)
    with pytest.raises(ValueError, match="closed"):
        lofts.solid_inertia(open_mesh, 1.0)


def test_union_surface_of_two_overlapping_balls():
    """Closed, of the volume of two caps cut at the common plane, vertices on the spheres."""
    balls = [trimesh.creation.icosphere(3, 0.03) for _ in range(2)]
    balls[1].apply_translation([0.04, 0, 0])
    mesh = union_surface(balls, 0.003)
    r, cap = 0.03, 0.03 - 0.02
    exact = 2 * (4 / 3 * np.pi * r**3 - np.pi * cap**2 * (3 * r - cap) / 3)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(exact, rel=0.03)
    distance = np.minimum(
        np.linalg.norm(mesh.vertices, axis=1), np.linalg.norm(mesh.vertices - [0.04, 0, 0], axis=1)
    )
    assert np.abs(distance - r).max() < 3e-4
