"""The solid in the slot of spring models: channels and numbers beside the rod's, stored runs, refusals."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.errors import InputError
from valvetrain.integrate import solid_store
from valvetrain.integrate.contract import Cycles, RunOptions
from valvetrain.integrate.run import run
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.quantities.signal import fine_filtered, fine_series
from valvetrain.runs.run import run_study
from valvetrain.system.build import build

RPM = np.pi / 30
SPRING = """
[spring]
name = "short"
wire_diameter = "4 mm"
mean_diameter = "24 mm"
total_coils = 5.5
free_length = "44 mm"
material = "OTEVA 90 SC"
precompression = "4 mm"
[spring.lower_end]
kind = "closed"
inactive_coils = 1
[spring.upper_end]
kind = "closed"
inactive_coils = 1
[spring.damping]
mass_damping = "60 1/s"
stiffness_damping = "4 us"
[spring.options.solid]
bricks_per_coil = 12
[spring.options.finite-element]
elements_per_coil = 12
[lift_law]
kind = "sine-power"
maximum_lift = "6 mm"
opening_start = "120 deg"
closing_end = "240 deg"
power = 4
[operation]
engine_speeds = "7000 rpm"
cycles = 1
output_step = "1 deg"
"""


@pytest.fixture
def apart(tmp_path, monkeypatch):
    """Stored runs in a folder of the test's own."""
    monkeypatch.setattr(solid_store, "_folder", lambda: tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def study():
    return run_study(
        parse_case(SPRING, "short"),
        spring_models=["finite-element", "solid"],
        workers=1,
        error_bars=True,
    )


def test_rod_and_solid_agree_in_motion(study):
    """Limit between models: end forces, motion of a coil and torsional moment of a coarse solid stay
    within 2 % of the largest from the rod's."""
    rod, solid = study.solutions
    assert rod.status.completed and solid.status.completed
    middle = int(np.argmin(np.abs(rod.arrays.coords["coil_number"].values - 2.5)))
    for name in ("seat_force", "retainer_force", "axial_displacement", "torsional_moment"):
        one, other = rod.channel(name), solid.channel(name)
        if one.ndim == 2:
            one, other = one[:, middle], other[:, middle]
        assert np.sqrt(np.mean((one - other) ** 2)) < 0.02 * np.abs(one).max(), name
    assert solid.statistics["energy_gap"] < 2e-3


@pytest.mark.long
def test_rod_and_solid_agree_where_coils_clash(apart):
    """Limit between models: the second cycle of job C, which lands on 30 clashes a revolution, below 10
    kHz: the solid's peak seat force within 2 % of the rod's with its curvature correction, the
    force within 1 % of its span, root mean square (13 % and 4 % where the first foot is held at
    half a station)."""
    case = load_case("job-c", {"spring.options.finite-element.curvature_correction": True})
    study = run_study(case, spring_models=["finite-element", "solid"], workers=1)
    rod, solid = (fine_filtered(run, 10e3) for run in study.solutions)
    times = [fine_series(run)[0] for run in study.solutions]
    there = np.interp(times[0], times[1], solid)
    assert solid.max() == pytest.approx(rod.max(), rel=0.02)
    assert np.sqrt(np.mean((there - rod) ** 2)) < 0.01 * np.ptp(rod)


def test_the_solid_has_every_channel_of_the_rod(study):
    """Contract: the same channels on the same wire points, and on the pairs of coils that have two
    stations of the mesh at either side."""
    rod, solid = study.solutions
    assert set(rod.arrays.variables) <= set(solid.arrays.variables)
    for name in ("coil_number", "time"):
        assert solid.arrays.coords[name].values == pytest.approx(rod.arrays.coords[name].values)
    pairs, others = (one.arrays.coords["upper_coil"].values for one in (solid, rod))
    assert set(pairs) <= set(others) and len(pairs) >= len(others) - 2
    assert set(np.unique(solid.channel("contact_status"))) <= {0, 1, 2, 3}


def test_the_error_bar_is_of_a_second_mesh(study):
    """Contract: numbers of the solid carry a bar from a mesh two thirds as fine; of the peak force
    less than 5 % here."""
    rows = {row.quantity: row for row in study.error_bars.rows if row.label == "solid"}
    peak = rows["peak_spring_force"]
    assert 0 < peak.numerical < 0.05 * peak.value


def test_energy_of_a_run_adds_up(study):
    """Property: the work of the retainer is energy stored and turned to heat, on the channels."""
    solid = study.solutions[1]
    stored = sum(solid.channel(f"{kind}_energy") for kind in ("kinetic", "elastic", "contact"))
    gap = solid.channel("work_done") - solid.channel("energy_dissipated") - stored
    assert np.ptp(gap) < 2e-3 * np.ptp(solid.channel("work_done"))


def _system():
    return build(parse_case(SPRING, "short"), spring_models=["solid"]).members[0].system()


def test_a_finished_run_is_read_again(apart):
    """Contract: a run that was finished is not computed again, and is the same to the last bit."""
    system, options = _system(), RunOptions(samples=60)
    first = run(system, 400.0, Cycles(1), options)
    assert first.status.completed and len(list(apart.glob("*.nc"))) == 1
    calls: list[float] = []
    watched = RunOptions(samples=60, watch=lambda share: bool(calls.append(share)) or True)
    again = run(system, 400.0, Cycles(1), watched)
    assert not calls and np.array_equal(first.channel("seat_force"), again.channel("seat_force"))
    assert first.events == again.events
    run(system, 401.0, Cycles(1), watched)
    assert calls and calls == sorted(calls) and len(list(apart.glob("*.nc"))) == 2


def test_a_stopped_run_is_interrupted_and_not_stored(apart):
    """Contract: a run that is stopped says so and leaves nothing that a later one would take."""
    found = run(
        _system(), 400.0, Cycles(1), RunOptions(samples=60, watch=lambda share: share < 0.3)
    )
    assert found.status.code == "interrupted" and not list(apart.glob("*.nc"))


def test_a_damaged_stored_run_is_computed_again(apart):
    """Contract: a file cut short is no run."""
    system, options = _system(), RunOptions(samples=60)
    first = run(system, 400.0, Cycles(1), options)
    (path,) = apart.glob("*.nc")
    path.write_bytes(path.read_bytes()[:1000])
    again = run(system, 400.0, Cycles(1), options)
    assert np.array_equal(first.channel("seat_force"), again.channel("seat_force"))


def test_a_train_of_cards_is_refused():
    """Contract: a spring known by its card only has no body; the sentence says what is missing."""
    with pytest.raises(InputError, match="need its wire"):
        run_study(load_case("tdi-pushrod"), spring_models=["solid"])


def test_springs_in_guides_are_refused():
    """Contract: a guide is no part of the solid."""
    case = load_case("job-c", {"spring.guide.bore": "40 mm"})
    with pytest.raises(InputError, match="is in a guide"):
        build(case, spring_models=["solid"]).members[0].system()


def test_ends_that_would_lift_are_told():
    """Contract: a solid is bonded; where its end pulls, a note says what else to take."""
    text = SPRING.replace('"4 mm"\n[spring.lower', '"0.01 mm"\n[spring.lower').replace(
        "7000 rpm", "9000 rpm"
    )
    study = run_study(parse_case(text, "loose"), spring_models=["solid"], workers=1)
    (run_of,) = study.solutions
    pulled = run_of.channel("seat_force").min() < 0 or run_of.channel("retainer_force").min() < 0
    assert pulled and any("bonded to seat and retainer" in note for note in study.notes)
