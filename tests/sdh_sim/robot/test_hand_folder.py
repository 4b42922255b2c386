"""A user's hand from a folder: what is read, made and refused."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from sdh_sim.errors import HandError, SettingsError
from sdh_sim.robot import HAND, hand_kinematics, hand_of, hand_spec, read_hand_folder
from sdh_sim.robot.carrier import carrier_spec
from sdh_sim.sensing.pad_forces import pad_forces
from sdh_sim.user_references import HandFolder, plain
from tests.support.hand_folders import GRIPPER, TETRAHEDRON, TOML, write_hand


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_hand(tmp_path_factory.mktemp("hands") / "gripper")


@pytest.fixture(scope="module")
def gripper(folder):
    return read_hand_folder(folder)


def test_what_is_in_the_folder_becomes_the_hand(gripper):
    assert gripper.name == "gripper"
    assert gripper.motor_names == ("grip",)
    # The tendon moves as far as the joints, which stop at 0.04; the servo's range goes further.
    assert gripper.motors[0].span == (0.0, 0.05)
    assert gripper.arrays["flat"].shape == (5, 4)
    assert gripper.pads[0].body == "left_frame"


def test_one_motor_on_a_tendon_of_two_tied_jaws(gripper):
    kinematics = hand_kinematics(gripper)
    # Length of the tendon 0.5 a + 0.5 b with a = b: each joint moves as the motor does.
    assert kinematics.selection == pytest.approx(np.array([[1.0], [1.0]]))
    assert kinematics.joint_positions(np.array([0.03])) == pytest.approx([0.03, 0.03])
    assert kinematics.transmission(np.array([0.03])) is None
    posture = kinematics.at(np.array([0.03]))
    assert posture.link("left")[0] == pytest.approx([-0.02, 0.0, 0.08])
    assert posture.jacobian("left_frame", np.zeros(3))[:, 0] == pytest.approx([1.0, 0.0, 0.0])
    assert posture.jacobian("right_frame", np.zeros(3))[:, 0] == pytest.approx([-1.0, 0.0, 0.0])


def test_forces_of_the_pads_by_virtual_work(gripper):
    # 60 N along the tendon move one jaw as far as the motor: 60 N alone, half for each of two.
    forces = pad_forces(hand_kinematics(gripper), "parallel")
    assert forces.alone == pytest.approx({"left": 60.0, "right": 60.0})
    assert forces.together == pytest.approx(30.0)


def test_pads_get_taxels_whose_apex_is_on_the_surface(gripper):
    model = hand_spec(gripper).compile()
    for pad, sign in zip(gripper.pads, (1.0, -1.0), strict=True):
        assert model.body(pad.body).name == f"{pad.name}_frame"
        for row in range(5):
            for column in range(4):
                geom = model.geom(f"{pad.name}_r{row:02d}_c{column}")
                apex = geom.pos + np.array([geom.size[0], 0.0, 0.0])
                # Flat, around the origin of the pad's frame, row 0 toward the tip.
                expected = [0.0, (column - 1.5) * 0.004, (2 - row) * 0.004]
                assert apex == pytest.approx(expected)
                assert 2 * 0.004 <= geom.size[0] <= 4 * 0.004
                assert (geom.contype, geom.conaffinity, geom.priority) == (2, 0, 2)
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        frame = data.body(pad.body)
        assert frame.xmat.reshape(3, 3)[:, 0] == pytest.approx([sign, 0.0, 0.0])
    # Taxels weigh nothing: a box of 500 kg/m^3 does, although a pad has taken its contacts over.
    assert model.body("left").mass == pytest.approx(500 * 0.02 * 0.024 * 0.08)
    assert model.body("left_frame").mass == 0.0


def test_geoms_get_the_contact_bits_of_the_workcell(gripper):
    model = hand_spec(gripper).compile()
    assert (model.geom("right_box").contype, model.geom("right_box").conaffinity) == (4, 12)
    # Structure is drawn where a body has no other shape.
    assert model.geom("right_box").group == 2
    base = next(g for g in range(model.ngeom) if model.geom_bodyid[g] == model.body("base").id)
    assert (model.geom_contype[base], model.geom_group[base]) == (4, 3)
    replaced = model.geom("left_box")
    assert (replaced.contype, replaced.conaffinity, replaced.group) == (0, 0, 2)
    shell = next(g for g in range(model.ngeom) if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_MESH)
    assert (model.geom_contype[shell], model.geom_group[shell]) == (0, 2)
    assert model.geom_friction[:, 0].max() == 1.0  # the file's 3 is the scene's to say
    assert model.nlight == 0


def test_attached_to_the_arm_it_is_the_same_hand(gripper, tmp_path):
    degrees = GRIPPER.replace('angle="radian"', 'angle="degree"').replace(
        'axis="1 0 0"', 'axis="0 1 0" type="hinge" range="-10 30"'
    ).replace("<equality>", "<!--").replace("</equality>", "-->")  # fmt: skip
    turned = TOML.replace("travel = [0.04]", "travel = [0.02]")
    hands = [gripper, read_hand_folder(write_hand(tmp_path / "degrees", degrees, turned))]
    for hand in hands:
        alone = hand_spec(hand).compile()
        spec = carrier_spec("none")
        spec.attach(hand_spec(hand), prefix=HAND, frame=spec.worldbody.add_frame())
        model = spec.compile()
        for name in ("left", "right"):
            joint = model.joint(HAND + name)
            assert joint.range == pytest.approx(alone.joint(name).range)
            assert joint.axis == pytest.approx(alone.joint(name).axis)
        assert model.body(HAND + "left").mass == pytest.approx(alone.body("left").mass)
    assert hand_spec(hands[1]).compile().joint("left").range == pytest.approx(
        np.radians([-10.0, 30.0])
    )


_SOLID = '<geom type="box" size="0.01 0.012 0.04"/>'


def test_taxels_of_the_model_are_taken(tmp_path, gripper):
    spheres = "".join(
        f'<geom name="left_r{row:02d}_c{column}" type="sphere" size="0.01" '
        f'pos="-0.01 {(column - 1.5) * 0.004} {(2 - row) * 0.004}"/>'
        for row in range(5)
        for column in range(4)
    )
    inside = f'<body name="mine" pos="0.01 0 0.02">{spheres}</body>'
    model = GRIPPER.replace(
        '<geom name="left_box" class="finger"/>', inside + "<geom size='.001'/>"
    )
    toml = TOML.replace('body = "left"\narray', 'body = "mine"\narray')
    toml = toml.replace('pos = [0.01, 0.0, 0.02]\nreplaces = ["left_box"]\n', "")
    hand = read_hand_folder(write_hand(tmp_path / "a", model, toml))
    compiled = hand_spec(hand).compile()
    assert compiled.geom("left_r00_c0").contype == 2
    assert compiled.geom("left_r00_c0").size[0] == 0.01
    assert compiled.body("mine").mass == 0.0
    some = model.replace('name="left_r03_c1"', "")
    with pytest.raises(
        HandError, match="the model has 19 of its 20 taxels; left_r03_c1 is missing"
    ):
        read_hand_folder(write_hand(tmp_path / "b", some, toml))


def reference_of(hand):
    assert hand.folder is not None
    return hand.folder


def test_the_reference_names_the_files(folder, gripper, tmp_path):
    reference = reference_of(gripper)
    assert HandFolder.from_dict(plain(reference)) == reference
    assert hand_of(reference).motor_names == gripper.motor_names
    copy = write_hand(tmp_path / "copy")
    assert (
        reference_of(read_hand_folder(copy)).sha256 == reference.sha256
    )  # the same wherever it lies
    (copy / "parts" / "shell.stl").write_bytes(TETRAHEDRON.replace(b"0.02", b"0.03"))
    other = reference_of(read_hand_folder(copy))
    assert other.sha256 != reference.sha256
    (copy / "hand.toml").write_text(TOML + "\n# changed\n")
    with pytest.raises(HandError, match="its files have changed since the run began"):
        hand_of(other)


def test_notes_say_what_was_done(gripper):
    notes = "; ".join(reference_of(gripper).notes)
    assert "ignored, as it is no shape or mechanics: friction, light, option" in notes
    assert "pads.left: 20 taxels made" in notes


def test_one_folder_may_hold_several_hands(folder):
    (folder / "second.toml").write_text(TOML.replace('name = "gripper"', 'name = "second"'))
    hand = read_hand_folder(folder / "second.toml")
    assert hand.name == "second"
    assert reference_of(hand).path.endswith("second.toml")


BAD_TOML = {
    'palm = "base"': ('palm = "hull"', "palm is 'hull'; the model has the bodies base, left"),
    "[motors.grip]": ("[motors.clamp]", "no actuator of that name with a ctrlrange; it has grip"),
    "pos = [0.01, 0.0, 0.02]": ("pos = [0.1, 0.0, 0.02]", "pads.left is not on its body left"),
    "travel = [0.04]": ("travel = [0.0]", "closings.parallel does not close: its pads are"),
    'replaces = ["left_box"]': ('replaces = ["box"]', "pads.left.replaces has 'box'"),
    'model = "gripper.xml"': ('model = "../gripper.xml"', "is not the name of a file in this"),
    "[fingers.right]": ("[fingers.left]", "hand.toml: is not TOML (Cannot declare"),
    "quat = [0.0, 0.0, 0.0, 1.0]": ("quat = [0, 0, 0, 2]", "a quaternion w, x, y, z of length 1"),
    "rate = 1.0": ("rate = 1.0\nsped = 2", "closings.parallel.'sped' is not known; known here are"),
    'groups = ["grip"]': ('groups = ["grip"]\n[couplings.left]\nfollows = "left"\nratio = 1.0',
                          "couplings.left: left is not the name of another joint"),
}  # fmt: skip


@pytest.mark.parametrize("good", BAD_TOML)
def test_what_hand_toml_cannot_say(good, tmp_path):
    bad, message = BAD_TOML[good]
    assert good in TOML
    write_hand(tmp_path / "hand", toml=TOML.replace(good, bad, 1))
    with pytest.raises(SettingsError) as caught:
        read_hand_folder(tmp_path / "hand")
    text = str(caught.value)
    assert message in text
    assert text.startswith(f"hand: {tmp_path / 'hand'}: ")
    assert "\n" not in text


_BASE = '<geom type="box" size="0.06 0.02 0.02" pos="0 0 0.02"/>'
BAD_MODELS = {
    "<light pos": ("<include file='/etc/hostname'/><light pos", "is not the name of a file in"),
    "</mujoco>": ("<extension><plugin plugin='x.y'/></extension></mujoco>",
                  "has <extension> in <mujoco>, which a hand may not have: it would run other"),
    '<body name="base">': ('<body name="base"><freejoint/>', "the arm carries the hand"),
    '<position name="grip"': ('<motor name="grip"', "motors are position servos here"),
    _BASE: (_BASE + '<geom type="hfield" hfield="h"/>', "has 'hfield' of <geom>"),
    'armature="0.5"': ('armature="nan"', "give finite numbers up to 1e+09"),
    'name="right_box"': ('name="left_box"', "repeated name 'left_box'"),
    "</worldbody>": ('<frame><geom size="1"/></frame></worldbody>', "has a geom in no body"),
    "parts": ("..", "is not the name of a file in this folder"),
    'file="shell.stl"': ('file="shell.png"', "its name must end in one of .stl, .obj, .msh"),
    'name="shell" file="shell.stl"': ('name="shell" vertex="0 0 0 1 0 0 0 1 0"',
                                      "of fewer than four vertices"),
    'kp="4000"': ('kp="0"', "the actuator grip is no position servo"),
    'tendon="pull"': ('tendon="pull" gear="0"', "the actuator grip has gear 0"),
    "<equality>": ("<equality><weld body1='left' body2='right'/>", "its 1 motors move only 0"),
}  # fmt: skip


@pytest.mark.parametrize("good", BAD_MODELS)
def test_what_a_model_cannot_have(good, tmp_path):
    bad, message = BAD_MODELS[good]
    assert good in GRIPPER
    write_hand(tmp_path / "hand", model=GRIPPER.replace(good, bad, 1))
    with pytest.raises(SettingsError) as caught:
        read_hand_folder(tmp_path / "hand")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_nothing_outside_the_folder_is_opened(tmp_path):
    hand = write_hand(tmp_path / "hand")
    (tmp_path / "outside.stl").write_bytes(TETRAHEDRON)
    (hand / "parts" / "shell.stl").unlink()
    (hand / "parts" / "shell.stl").symlink_to(tmp_path / "outside.stl")
    with pytest.raises(HandError, match="is a link that leads out of this folder"):
        read_hand_folder(hand)


def test_a_joint_that_nothing_moves_or_holds_is_named(tmp_path):
    loose = GRIPPER.replace(
        '<geom name="left_box" class="finger"/>',
        '<geom name="left_box" class="finger"/><body name="flap" pos="0 0.1 0">'
        '<joint name="flap" axis="0 0 1"/><geom size="0.01"/></body>',
    )
    with pytest.raises(HandError, match="no motor moves flap, and neither a spring nor a stop"):
        read_hand_folder(write_hand(tmp_path / "loose", loose))
    held = loose.replace('name="flap" axis="0 0 1"', 'name="flap" axis="0 0 1" stiffness="0.1"')
    hand = read_hand_folder(write_hand(tmp_path / "held", held))
    assert hand_kinematics(hand).passive == ("flap",)


def test_equalities_that_work_against_a_stop_are_refused(tmp_path):
    against = GRIPPER.replace('polycoef="0 1', 'polycoef="0 -1')
    against = against.replace('coef="0.5"/></fixed>', 'coef="-0.5"/></fixed>')
    with pytest.raises(HandError, match=r"the joint right is at -0.04, beyond its range of 0 to"):
        read_hand_folder(write_hand(tmp_path / "hand", against))


def test_there_must_be_a_folder(tmp_path):
    with pytest.raises(HandError, match=r"No such file or directory; give a folder with hand.toml"):
        read_hand_folder(tmp_path / "none")
    with pytest.raises(HandError, match=r"cannot read 'hand.toml'"):
        read_hand_folder(tmp_path)
