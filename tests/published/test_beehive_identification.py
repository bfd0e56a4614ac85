"""Published: the numbers of gu2021-beehive-blind come from examples/beehive, a package that the registry loads."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from beehive_study import refit
from beehive_study.identification import SPEC, library_values

import valvetrain as vt
from beehive_package import beehive_package  # noqa: F401
from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.explore.identification_file import IdentificationPlan
from valvetrain.explore.requests import Identify
from valvetrain.parameters.loading import LIBRARY


@pytest.fixture
def request_of_package(beehive_package: Path) -> IdentificationPlan:  # noqa: F811
    return Identify.read({"file": refit.FILE}).plan


def test_without_the_package_its_evaluator_is_unknown() -> None:
    if "beehive" not in registry.names("evaluators"):
        with pytest.raises(InputError, match="beehive"):
            assert Identify.read({"file": refit.FILE}).plan


def test_shipped_spread_is_that_of_this_identification(
    request_of_package: IdentificationPlan,
) -> None:
    """Fails when unknowns, priors or targets have changed since the spread was computed; run the
    identification again then.
    """
    content = tomllib.loads(
        (Path(str(LIBRARY)) / "gu2021-beehive-blind.spread").read_text(encoding="utf-8")
    )
    assert content["case"]["identification"] == refit.method_digest(request_of_package)


#: Measurement -> the published value behind it: what produced it and its quantity in the case,
#: whose role is therefore "calibration".
PUBLISHED = {
    "node_2_installed_gap": ("solid finite elements", "coil_1_2_installed_gap"),
    "free_swing_force_range": ("solid finite elements", "stage_1_force_range"),
    "modal_stage_2_peak_force": ("analytical modal", "stage_2_peak_force"),
    "node_2_stage_3_peak_acceleration": ("solid finite elements", "node_2_peak_acceleration"),
}


def test_targets_are_the_values_whose_role_is_calibration(
    request_of_package: IdentificationPlan,
) -> None:
    """The case says of each published value what it was used for, and the identification uses these
    and no other.
    """
    case = vt.load_case("gu2021-beehive-blind")
    used = {
        (value.model, value.quantity): value
        for value in case.published
        if value.role == "calibration"
    }
    targets = {datum.name: datum.value for datum in request_of_package.data}
    published = {name: PUBLISHED.get(name, ("solid finite elements", name)) for name in targets}
    assert set(used) == set(published.values()) and set(PUBLISHED) <= set(targets)
    for name, key in published.items():
        if name != "node_2_installed_gap":  # between no gap and the 0.07 mm of the 4200 rpm run
            assert targets[name] == pytest.approx(used[key].value)


def test_the_search_computes_every_target_of_the_shipped_case(
    request_of_package: IdentificationPlan,
) -> None:
    """On a coarse mesh, beside the numbers of docs/beehive.md, in a worker of its own."""
    names = tuple(one.title for one in request_of_package.unknowns)
    found = SPEC.points(names, {"elements_per_coil": 12})(SPEC.values(names))
    assert {datum.key for datum in request_of_package.data} <= set(found)
    assert found["preload"] == pytest.approx(288.9, rel=2e-3)
    assert found["stage_2_peak_force"] == pytest.approx(816.5, rel=2e-3)
    # the free swing to 120 degrees, not the study's Stage I, whose range is 18.9 N
    assert found["free_swing_force_range"] == pytest.approx(14.7, abs=0.3)


def test_a_draw_at_the_values_of_the_beehive_is_the_beehive() -> None:
    values = library_values()
    found = refit.predict(8, list(values), list(values.values()))
    case = vt.load_case(
        "gu2021-beehive-blind", {"spring.options.finite-element.elements_per_coil": 8}
    )
    (run,) = vt.simulate(case, "4200 rpm", models=["finite-element"]).solutions
    for name in ("stage_1_minimum_force", "stage_2_peak_force"):
        assert found[f"4200 {name}"] == pytest.approx(run.quantities[name], rel=1e-3)
