"""The tables of settings: what they refuse, and that options and page come from them."""

from __future__ import annotations

import dataclasses
import json
import math

import pytest
import typer.main

from sdh_sim.cli.app import app
from sdh_sim.cli.lift_request import LiftRequest
from sdh_sim.cli.settings_page import page
from sdh_sim.errors import SettingsError
from sdh_sim.run_options import RunOptions
from sdh_sim.setting_table import settings_of
from sdh_sim.settings import TrialSettings
from tests.support.repository import ROOT

TABLES = (LiftRequest, TrialSettings, RunOptions)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("sensor", "eye", "sensor: got 'eye'; choose one of dsa, ideal"),
        ("pads", None, "pads: got None; give all, or a kind"),
        ("arm", {}, "arm: got {}; choose one of servo, rigid"),
        ("timestep", 0.1, "timestep: got 0.1; allowed is 0.0001 to 0.005 s"),
        ("timestep", math.nan, "timestep: got nan; allowed is 0.0001 to 0.005 s"),
        ("pad_modulus", "soft", "pad_modulus: got 'soft'; allowed is 50000 to 5e+07 Pa"),
        ("friction_error", -0.1, "friction_error: got -0.1; allowed is 0 to 0.5"),
        ("repeats", 1001, "repeats: got 1001; allowed is 0 to 1000"),
        ("repeats", 1.5, "repeats: got 1.5; give a whole number, 0 to 1000"),
        ("repeats", True, "repeats: got True; give a whole number, 0 to 1000"),
        ("torque_limit", (0, 1), "torque_limit: got (0, 1); give two torques in N m, each above 0"),
        ("torque_limit", 3, "torque_limit: got 3; give two torques"),
        ("folder", "mug", "folder: got 'mug'; expected an ObjectFolder"),
        ("metrics", [1], "metrics: got [1]; expected a tuple of UserMetric"),
    ],
)
def test_trial_settings_refuse_by_name(name, value, words):
    with pytest.raises(SettingsError) as caught:
        TrialSettings("box", **{name: value})
    assert str(caught.value).startswith(words)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"workers": 0}, "workers: got 0; give a whole number of at least 1"),
        ({"workers": 1.5}, "workers: got 1.5; give a whole number of at least 1"),
        ({"workers": True}, "workers: got True; give a whole number of at least 1"),
        ({"workers": "2"}, "workers: got '2'; give a whole number of at least 1"),
        ({"rerun": "some"}, "rerun: got 'some'; choose one of all, failures, none"),
        ({"executor": "cloud"}, "executor: got 'cloud'; choose one of processes, dask"),
        ({"scheduler": "tcp://h:1"}, "scheduler: got 'tcp://h:1'; it needs --executor dask"),
        ({"resume": True, "overwrite": True}, "--resume and --overwrite exclude each other"),
        ({"retry_errors": True}, "--retry-errors continues a run; give --resume with it"),
    ],
)
def test_run_options_refuse_by_name(given, words):
    with pytest.raises(SettingsError) as caught:
        RunOptions(**given)
    assert str(caught.value).startswith(words)


def test_settings_survive_json():
    settings = TrialSettings("mug", torque_limit=(2.0, 1.5), sensor="ideal", repeats=3)
    assert TrialSettings.from_dict(json.loads(json.dumps(settings.to_dict()))) == settings
    assert hash(settings) == hash(dataclasses.replace(settings))
    with pytest.raises(SettingsError, match="unknown setting 'spin'; known are angle_error, arm"):
        TrialSettings.from_dict({"object": "box", "spin": 1})
    with pytest.raises(SettingsError, match="setting 'object' is missing"):
        TrialSettings.from_dict({})


@pytest.mark.parametrize("table", TABLES)
def test_every_default_is_allowed_and_every_line_is_a_sentence(table):
    for line in settings_of(table).values():
        if line.choices and line.default is not None:
            assert line.default in line.choices
        if line.span is not None:
            low, high = line.span
            assert low <= (line.default or 0.0) <= high
        assert line.meaning[-1] == "." or line.name == "object"  # which ends with a command


def test_the_command_has_an_option_for_every_setting_and_no_other():
    (lift,) = (c for n, c in typer.main.get_command(app).commands.items() if n == "lift")  # type: ignore[attr-defined]
    wanted = {
        line.flag: line for table in TABLES for line in settings_of(table).values() if line.option
    }
    found = {p.opts[0]: p for p in lift.params}
    assert sorted(found) == sorted(wanted)
    for flag, line in wanted.items():
        assert found[flag].name == line.name
        assert found[flag].required == line.required
        assert found[flag].help == line.help
        assert found[flag].show_default == (line.default_text or False)
        assert found[flag].opts + found[flag].secondary_opts == [flag]


def test_the_page_of_settings_is_what_the_tables_say():
    text = (ROOT / "docs" / "settings.md").read_text(encoding="utf-8")
    assert text == page(), "python -m sdh_sim.cli.settings_page > docs/settings.md"
