"""Buckling and guides on the command line, in JSON and on the page."""

from __future__ import annotations

import json

import pytest

from spring_parts import GUIDED, SLENDER
from unit.cli_parts import call

LIFT = """
[lift_law]
kind = "sine-power"
maximum_lift = "4 mm"
opening_start = "100 deg"
closing_end = "260 deg"
power = 4
"""


@pytest.fixture
def slender(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "slender.toml").write_text(SLENDER + LIFT)
    (tmp_path / "guided.toml").write_text(GUIDED + LIFT)


def test_a_curve_beyond_buckling_fails_with_the_place_and_what_to_do(slender):
    result = call("static", "slender.toml", "--to", "18 mm", "--steps", "6", "--json")
    found = json.loads(result.stdout)
    assert (
        result.exit_code == 1
        and "buckles at 15.7" in result.stderr
        and "guide it in a bore" in result.stderr
    )
    assert found["springs_at_rest"][0]["static_curve"]["status"]["code"] == "buckled"
    place, height, formula = (
        found["quantities"][name]["value"]
        for name in ("buckling_compression", "buckling_height", "formula_buckling_compression")
    )
    assert place == pytest.approx(formula, rel=0.01) and height == pytest.approx(
        81e-3 - place, abs=1e-9
    )


def test_a_bore_too_narrow_is_refused_with_its_place(slender):
    result = call("check", "guided.toml", "--set", "spring.guide.bore=10.5 mm")
    assert (
        result.exit_code == 2
        and "spring.guide" in result.stderr
        and "outer diameter is 11 mm; widen the bore" in result.stderr
    )
