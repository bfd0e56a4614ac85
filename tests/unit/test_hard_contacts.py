"""A contact of 1e30: no step of time follows it, so it is refused in a sentence from a file, by
--set and from a program.
"""

from __future__ import annotations

from dataclasses import replace

import pytest

import valvetrain as vt
from unit.cli_parts import SMALL, call, sentence
from valvetrain.errors import InputError

HARD = "1e30 N/mm/mm"
WORDS = "needs steps of "


def ended(result) -> str:
    """The one failure of a command that ended with code 1, without a traceback."""
    assert result.exit_code == 1 and "Traceback" not in result.stderr
    (line,) = [line for line in result.stderr.splitlines() if line.startswith("failed: ")]
    return line


@pytest.mark.parametrize("model", ["multi-mass", "finite-element"])
def test_contact_of_coils_in_a_case_file_or_set(model, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "soft.toml").write_text(SMALL)
    (tmp_path / "hard.toml").write_text(
        SMALL.replace(
            "[spring.damping]", f'[spring.contact]\nstiffness = "{HARD}"\n\n[spring.damping]'
        )
    )
    words = ("--model", model, "--workers", "1", "--output", "out", "--no-report")
    for asked in (("hard.toml",), ("soft.toml", "--set", f"spring.contact.stiffness={HARD}")):
        told = ended(call("run", *asked, *words))
        assert WORDS in told and "give a softer coil contact" in told and "--limit" in told


@pytest.mark.parametrize("model", ["multi-mass", "finite-element"])
def test_contact_of_coils_from_a_program(model):
    case = vt.load_case("job-t")
    hard = replace(case.springs[0], contact=replace(case.springs[0].contact, stiffness=1e36))
    (run,) = vt.simulate(case.replace(springs=(hard,)), "3000 rpm", models=[model]).solutions
    assert run.status.code == "refused" and WORDS in run.status.message


def test_contact_of_parts():
    """It would be 5e-28 mm deep under the load of a spring, less than a number of that size can
    tell.
    """
    words = "would be 5e-28 mm deep at 500 N; check contact_stiffness and its unit"
    with pytest.raises(InputError, match=words):
        vt.contact.build_contact_law("linear", contact_stiffness="1e30 N/mm")
    key = "train.contacts.cam.contact_stiffness"
    with pytest.raises(InputError, match=words):
        vt.simulate(
            vt.load_case("tdi-pushrod", {key: "1e30 N/mm"}),
            "3000 rpm",
            models=["massless"],
            spring_sets=["stock"],
        )
    assert words in sentence(call("run", "tdi-pushrod", "--set", f"{key}=1e30 N/mm"))
    assert words in sentence(call("check", "tdi-pushrod", "--set", f"{key}=1e30 N/mm"))


def test_a_curve_of_hard_coils_ends_with_a_status():
    curve = vt.static_curve(
        vt.load_case("gu2021-beehive-blind", {"spring.contact.stiffness": HARD}), steps=12
    )
    assert curve.status.code == "not-converged" and 0 < len(curve.force) < 13
    assert (
        "no equilibrium beyond" in curve.status.message
        and ", at time" not in curve.status.sentence()
    )
