"""The solid in the slot of spring models: channels and numbers beside the rod's, stored runs, refusals."""

from __future__ import annotations

from base64 import b64decode

import numpy as np
import pytest

from fact_parts import with_code
from valvetrain.errors import InputError
from valvetrain.integrate import solid_store
from valvetrain.integrate.contract import Cycles, RunOptions
from valvetrain.integrate.run import run
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.quantities.signal import fine_filtered, fine_series
from valvetrain.runs.api import simulate
from valvetrain.solution.study import Study
from valvetrain.system.build import build
from valvetrain.views.motion.project import motion_data
from valvetrain.views.motion.scene import moving_picture

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

#: Coils 1 to 2.5 that lie close, so that they strike; a cone whose free wire lies on its seat.
PROGRESSIVE = SPRING.replace('free_length = "44 mm"\n', "").replace(
    "[spring.lower_end]",
    '[spring.pitch]\ncoils = [0, 1, 1.5, 2.5, 4.5, 5.5]\nclearances = "0, 0, 0.4, 5, 5, 0 mm"\n[spring.lower_end]',
)
CONE = (
    SPRING.replace('wire_diameter = "4 mm"', 'wire_diameter = "3 mm"')
    .replace("total_coils = 5.5", "total_coils = 4")
    .replace('mean_diameter = "24 mm"\n', "")
    .replace("44 mm", "22 mm")
    .replace('precompression = "4 mm"', 'precompression = "10 mm"')
    .replace('"6 mm"', '"4 mm"')
    .replace("7000 rpm", "4000 rpm")
    .replace(
        "[spring.lower_end]",
        '[spring.mean_diameter]\ncoils = [0, 4]\nvalues = "50, 18 mm"\n[spring.lower_end]',
    )
)


#: Cam speed (rad/s) of runs of which only the storing is looked at.
QUICK = 1600.0


@pytest.fixture
def apart(tmp_path, monkeypatch):
    """Stored runs in a folder of the test's own."""
    monkeypatch.setattr(solid_store, "_folder", lambda: tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def study():
    return simulate(
        parse_case(SPRING, "short"),
        models=["finite-element", "solid"],
        workers=1,
        compute="error_bars",
    )


@pytest.mark.slow
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
    study = simulate(case, models=["finite-element", "solid"], workers=1)
    rod, solid = (fine_filtered(run, 10e3) for run in study.solutions)
    times = [fine_series(run)[0] for run in study.solutions]
    there = np.interp(times[0], times[1], solid)
    assert solid.max() == pytest.approx(rod.max(), rel=0.02)
    assert np.sqrt(np.mean((there - rod) ** 2)) < 0.01 * np.ptp(rod)


def test_the_solid_has_every_channel_of_the_rod(study):
    """Contract: the same channels on the same wire points, and on the pairs of coils that have two
    stations of the mesh at either side."""
    rod, solid = study.solutions
    # the rod alone stores its force between the fine samples, for phases of a published sampling
    assert set(rod.arrays.variables) - {"seat_force_finest"} <= set(solid.arrays.variables)
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
    """Contract: a run that was finished is not computed again, and is the same to the last bit; a file
    cut short is no run.
    """
    system, options = _system(), RunOptions(samples=60)
    first = run(system, QUICK, Cycles(1), options)
    assert first.status.completed and len(list(apart.glob("*.nc"))) == 1
    calls: list[float] = []
    watched = RunOptions(samples=60, watch=lambda share: bool(calls.append(share)) or True)
    again = run(system, QUICK, Cycles(1), watched)
    assert not calls and np.array_equal(first.channel("seat_force"), again.channel("seat_force"))
    assert first.events == again.events
    (path,) = apart.glob("*.nc")
    path.write_bytes(path.read_bytes()[:1000])
    again = run(system, QUICK, Cycles(1), watched)
    assert calls and calls == sorted(calls)
    assert np.array_equal(first.channel("seat_force"), again.channel("seat_force"))
    run(system, QUICK + 1, Cycles(1), options)
    assert len(list(apart.glob("*.nc"))) == 2


def test_a_stopped_run_is_interrupted_and_not_stored(apart):
    """Contract: a run that is stopped says so and leaves nothing that a later one would take."""
    found = run(
        _system(), QUICK, Cycles(1), RunOptions(samples=60, watch=lambda share: share < 0.3)
    )
    assert found.status.code == "interrupted" and not list(apart.glob("*.nc"))


def test_a_train_of_cards_is_refused():
    """Contract: a spring known by its card only has no body; the sentence says what is missing."""
    with pytest.raises(InputError, match="need its wire"):
        simulate(load_case("tdi-pushrod"), models=["solid"])


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
    study = simulate(parse_case(text, "loose"), models=["solid"], workers=1)
    (run_of,) = study.solutions
    pulled = run_of.channel("seat_force").min() < 0 or run_of.channel("retainer_force").min() < 0
    assert pulled and with_code(study.facts, "ends-bonded")


@pytest.fixture(scope="module")
def coils() -> Study:
    return simulate(parse_case(PROGRESSIVE, "progressive"), models=["solid"], workers=1)


@pytest.fixture(scope="module")
def cone() -> Study:
    return simulate(parse_case(CONE, "cone"), models=["solid"], workers=1)


@pytest.mark.slow
def test_forces_per_length_add_up_to_those_of_pairs(coils):
    """Property: over the wire of a pair of coils, the peaks of its points reach the peak of the pair,
    and no more than their number times it; where a pair is pressed at no instant, no point is."""
    (run,) = coils.solutions
    line, pair = (run.channel(name) for name in ("coil_line_force", "coil_contact_peak_force"))
    points, pairs = (run.arrays.along(n) for n in ("coil_line_force", "coil_contact_peak_force"))
    wire = coils.record and parse_case(PROGRESSIVE, "progressive").springs[0].wire
    mean = (wire.line_speed(points) + wire.line_speed(points - 1)) / 2
    force = line * mean * np.gradient(points)
    own = np.searchsorted(pairs, np.round(points * 8) / 8)
    added = np.stack([force[:, own == place].sum(axis=1) for place in range(len(pairs))], axis=1)
    assert pair.max() > 100
    inner = slice(1, -1)  # the first and the last pair have points whose wire ends
    assert np.all(added[1:, inner] >= pair[1:, inner] * (1 - 1e-6))
    assert np.all(added[1:, inner] <= 3 * pair[1:, inner] + 1e-9)


def test_the_moving_picture_shows_stress_over_the_section(coils):
    """Contract: its first colours are the stress around the wire, one byte for each fibre of each node and
    frame; the largest around the section is that of the channel, and near the inner fibre's by its loads."""
    (run,) = coils.solutions
    moving = moving_picture(coils)
    (spring,) = moving.variants[0].springs
    surface = spring.colourings[0]
    stress = run.channel("surface_equivalent_stress")
    assert surface.key == "surface" and surface.around.shape == (*surface.values.shape, 8)
    assert surface.values.max() == pytest.approx(1e-6 * stress.max(), rel=0.05)
    inner = run.channel("inner_fibre_equivalent_stress")
    assert stress.max() == pytest.approx(inner.max(), rel=0.1)
    packed = motion_data(moving)["variants"][0]["springs"][0]["colours"][0]
    assert packed["fibres"] == 8 and len(b64decode(packed["d"])) == surface.around.size


def test_a_cone_lies_on_its_seat(cone):
    """Property: the free wire of a cone meets the seat where and while its axis has come down to the
    wire's radius, and its force is part of that on the seat."""
    (run,) = cone.solutions
    wire = parse_case(CONE, "cone").springs[0].wire
    coil, line = run.arrays.along("seat_line_force"), run.channel("seat_line_force")
    touching = np.degrees(run.cam_angle)[(line > 0).any(axis=1)]
    assert len(touching) and 120 < touching.min() < 240
    force = line * wire.line_speed(coil) * np.gradient(coil)
    assert 0 < force.max() <= 1.001 * run.channel("seat_force_highest").max()
    places, height = run.arrays.along("axial_position"), run.channel("axial_position")
    above = np.array([np.interp(coil, places, one) for one in height]) - 1.5e-3
    assert above[line > 0].max() < 5e-5 and above[line == 0].min() > -1e-6
