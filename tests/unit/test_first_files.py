"""The first files of a study, a search and an identification: every kind of case gives ones that their readers take."""

from __future__ import annotations

import pytest

import valvetrain as vt
from unit.cli_parts import call, sentence
from valvetrain.explore.first_files import levers
from valvetrain.explore.requests import Identify, Optimise, Study

CASES = ("spring", "direct", "finger", "rocker", "pushrod")
READERS = {"study": Study, "lash": Study, "optimise": Optimise, "identify": Identify}


@pytest.mark.parametrize("kind", CASES)
def test_a_case_has_the_first_file_of_each_request_beside_it(kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call("new", "mine", "--kind", kind)
    (tmp_path / "asked").mkdir()
    for request, read in READERS.items():
        made = call("new", f"asked/{request}", "--kind", request, "--case", "mine.toml")
        if (kind, request) == ("spring", "lash"):  # a spring alone has no lash
            assert made.exit_code == 2 and sentence(made)
        else:
            assert read.read({"file": tmp_path / "asked" / f"{request}.toml"}).plan
    case = vt.load_case("mine.toml")
    assert len(levers(case)) >= 3 and ("train.valve.mass" in levers(case)) == (kind != "spring")
    for words in (("--kind", "study"), ("--kind", kind, "--case", "mine.toml")):
        assert call("new", "other", *words).exit_code == 2


def test_loads_of_the_case_give_its_own_wire_back(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call("new", "mine")
    call("new", "wire", "--kind", "identify", "--case", "mine.toml")
    found = vt.identify("wire.toml", workers=1)
    assert found.best["wire_diameter"] == pytest.approx(3.9e-3, rel=2e-3)
    assert found.best["total_coils"] == pytest.approx(6.8, rel=5e-3)


def test_the_speeds_of_a_rig_are_read_at_any_red_line(tmp_path, monkeypatch):
    """15 500 rpm are 1623.16 rad/s, which a bare number may not be."""
    monkeypatch.chdir(tmp_path)
    card = ("--seat-load", "165 N", "--height", "31.5 mm", "--rate", "28 N/mm")
    call("new", "mine", "--kind", "direct", *card, "--red-line", "15500 rpm")
    assert call("new", "rig", "--kind", "identify", "--case", "mine.toml").exit_code == 0
    assert "15500 rpm" in (tmp_path / "rig.toml").read_text(encoding="utf-8")
