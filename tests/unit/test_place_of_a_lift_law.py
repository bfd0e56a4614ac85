"""What a lift law refuses when it is built is told with its place in the case file, by every
command that builds it.
"""

from __future__ import annotations

from dataclasses import replace

import pytest
from typer.testing import CliRunner

import valvetrain as vt
from valvetrain.cli.main import app

LAW = """
[lift_law]
kind = "shaped"
maximum_lift = "9 mm"
ramp_lift = "0.3 mm"
ramp_start = "80 deg"
event_start = "110 deg"
nose = "180 deg"
flank_shape = [1, 1, -1]
"""
SPRING = """
[spring]
name = "card"
rate = "30 N/mm"
preload = "250 N"
mass = "50 g"
"""
ROOM = "flank_shape needs four values or more"


@pytest.mark.parametrize("command", [("check",), ("run", "--rpm", "3000 rpm")])
def test_the_key_and_its_line_are_told(tmp_path, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.toml").write_text(LAW + SPRING)
    told = CliRunner().invoke(app, [command[0], "own.toml", *command[1:]])
    assert (
        told.exit_code == 2 and f"case 'own', line 9, lift_law.flank_shape: {ROOM}" in told.stderr
    )


def test_a_case_of_a_lift_law_alone_is_checked_too(tmp_path):
    """It was called valid, and refused by the first command that built it."""
    path = tmp_path / "own.toml"
    path.write_text(LAW)
    told = CliRunner().invoke(app, ["check", str(path)])
    assert (
        told.exit_code == 2 and f"case 'own', line 9, lift_law.flank_shape: {ROOM}" in told.stderr
    )
    path.write_text(LAW.replace("[1, 1, -1]", "[1, 1, -1, -1]"))
    assert CliRunner().invoke(app, ["check", str(path)]).exit_code == 0


def test_values_changed_from_outside_have_no_line(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(LAW.replace("[1, 1, -1]", "[1, 1, -1, -1]") + SPRING)
    case = vt.load_case(path, {"lift_law.event_end": "350 deg"})
    with pytest.raises(
        vt.InputError,
        match=r"^case 'own', lift_law: event_end and the ramp after it must follow the nose",
    ):
        vt.system.build.build(case)


def test_a_law_exchanged_in_a_program_has_no_line(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(LAW.replace("[1, 1, -1]", "[1, 1, -1, -1]") + SPRING)
    case = vt.load_case(path)
    law = replace(
        case.lift_law, values=dict(case.lift_law.values) | {"flank_shape": (1.0, 1.0, -1.0)}
    )
    with pytest.raises(vt.InputError, match=rf"^case 'own', lift_law.flank_shape: {ROOM}"):
        vt.system.build.build(replace(case, lift_law=law))
