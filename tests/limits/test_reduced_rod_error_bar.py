"""The error bar of a reduced rod holds its difference from the rod that it is reduced from, which runs in its place
(limit between models); where that is too far, the answer names the rod.
"""

from __future__ import annotations

from importlib import resources

import pytest

import valvetrain as vt


def pushrod() -> vt.Case:
    """The template's wire, whose coils are nearly solid at full lift."""
    path = resources.files("valvetrain").joinpath("templates/pushrod.toml")
    return vt.Case(path.read_text(encoding="utf-8"))


CASES = [("job-c", "3000 rpm", ""), (pushrod().parameters, "6000 rpm", "wire")]


@pytest.mark.parametrize(("case", "speed", "spring_set"), CASES, ids=["job-c", "pushrod"])
@pytest.mark.slow
def test_the_bar_holds_what_rods_on_two_grids_have(case, speed, spring_set):
    """Near coil bind the bar was 67 N and the rod 166 N away."""
    sets = {"spring_sets": spring_set} if spring_set else {}
    study = vt.simulate(case, speed, "reduced-rod", compute="error_bars", workers=1, **sets)
    bars = {row.quantity: row for row in study.error_bars.rows}
    problem = {"workers": 1, **sets}
    for elements in (24, 36):
        changed = vt.Case(case) if not isinstance(case, str) else vt.Case(vt.load_case(case))
        key = f"train.springs.{spring_set}.0" if spring_set else "springs.0"
        finer = changed.set({f"{key}.options.finite-element.elements_per_coil": elements})
        rod = vt.simulate(finer.parameters, speed, "finite-element", **problem).solutions[0]
        for name in ("peak_spring_force", "minimum_spring_force", "peak_retainer_force"):
            row = bars[name]
            assert abs(row.value - rod.quantities[name]) <= row.numerical + 1e-3 * row.value, name


@pytest.mark.slow
def test_a_sweep_of_a_spring_alone_is_judged_by_its_rod_too():
    swept = vt.sweep("job-c", "3000 rpm", "reduced-rod", compute="error_bars", workers=1)
    assert not len(swept.solutions[0].time)
    assert {"peak_spring_force"} <= {row.quantity for row in swept.error_bars.rows}
