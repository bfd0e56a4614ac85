"""Limits against a known truth: springs found in clouds of points that were drawn from springs we
know (scripts/sample_scan.py).
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import valvetrain as vt
from valvetrain.errors import InputError

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
from measure_scans import rms
from sample_scan import Scanner, cloud, ply, springs

KNOWN = springs()
#: Spring -> how it is seen: each hand, closed and open ground ends, all and outside only, holes,
#: strays.
SEEN = {
    "beehive": Scanner(holes=5, seed=25), "cylindrical": Scanner(outside=True, seed=22), "conical": Scanner(outside=True, holes=5, seed=23),
    "progressive": Scanner(seed=24),
}  # fmt: skip
POINTS = 8_000
NAMES = [
    pytest.param(name, marks=[pytest.mark.long] if name in ("conical", "progressive") else [])
    for name in SEEN
]


def written(folder, points, name="scan.ply"):
    file = folder / name
    file.write_bytes(ply(points))
    return file


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Spring -> what was found, and the truth; each once, and when it is asked for."""
    folder = tmp_path_factory.mktemp("scans")

    class Answers(dict):
        def __missing__(self, name):
            points, truth = cloud(KNOWN[name], POINTS, SEEN[name])
            self[name] = vt.scan.spring_from_scan(written(folder, points, f"{name}.ply")), truth
            return self[name]

    return Answers()


@pytest.mark.parametrize("name", NAMES)
def test_the_wire_axis_is_found_to_a_fiftieth_of_a_millimetre(found, name):
    scan, truth = found[name]
    assert rms(scan, truth) < 0.02e-3
    assert scan.noise == pytest.approx(0.05e-3, rel=0.05)


@pytest.mark.parametrize("name", NAMES)
def test_sizes_hand_and_ends_are_those_of_the_spring(found, name):
    scan, spring = found[name][0], KNOWN[name]
    assert scan.hand == spring.hand
    assert scan.section.diameter[0] == pytest.approx(
        float(spring.wire_diameter.value(0.0)), abs=8e-6
    )
    assert scan.free_length[0] == pytest.approx(spring.free_length, abs=0.06e-3)
    assert scan.definition.free_length == pytest.approx(scan.free_length[0], abs=2e-6)
    assert scan.definition.lower_end.ground_coils == pytest.approx(
        spring.lower_end.ground_coils, abs=0.02
    )
    assert not scan.section.ovate


@pytest.mark.parametrize("name", NAMES[1:])
def test_turns_are_counted_from_tip_to_tip(found, name):
    assert found[name][0].total_coils[0] == pytest.approx(KNOWN[name].total_coils, abs=0.012)


def test_a_wire_that_is_ground_away_ends_where_the_last_of_it_stands(found):
    """The shipped beehive is ground over 0.757 turns at a pitch of more than its wire: its last
    quarter turn is gone.
    """
    scan, spring = found["beehive"][0], KNOWN["beehive"]
    coil = np.linspace(6.0, 7.0, 20001)
    gone = coil[
        np.argmax(
            spring.axial_position(coil)
            > spring.upper_seat_height + float(spring.wire_diameter.value(7.0)) / 2
        )
    ]
    assert scan.total_coils[0] == pytest.approx(gone, abs=0.03)
    assert scan.definition.upper_end.kind == "open-ground"


@pytest.mark.parametrize("name", NAMES)
def test_diameter_and_pitch_lie_within_their_bands(found, name):
    """Three standard deviations and what the laws of straight lines with kinks leave beside a
    smooth curve.
    """
    scan, spring = found[name][0], KNOWN[name]
    curves, inner = scan.curves, slice(8, -8)
    coil = curves.coil[inner]
    diameter = curves.mean_diameter[inner] - spring.mean_diameter.value(coil)
    pitch = curves.pitch[inner] - spring.pitch.value(coil)
    assert np.mean(np.abs(diameter) < 3 * curves.mean_diameter_spread[inner] + 0.02e-3) > 0.9
    assert np.mean(np.abs(pitch) < 3 * curves.pitch_spread[inner] + 0.1e-3) > 0.9
    assert np.sqrt(np.mean(diameter**2)) < 0.03e-3


def test_the_axis_is_that_of_the_spring(found):
    for scan, truth in found.values():
        assert abs(float(scan.axis_direction @ truth.axis_direction)) > np.cos(np.radians(0.1))
        away = truth.axis_point - scan.axis_point
        assert np.linalg.norm(away - (away @ scan.axis_direction) * scan.axis_direction) < 0.05e-3


def test_ovate_wire_is_an_ellipse_and_the_round_wire_for_it_twists_alike(tmp_path):
    """Half axes 1.8 mm (1 +- 0.05); torsion of the ellipse pi a^3 b^3 / (a^2 + b^2) by quadrature
    of its stress function.
    """
    points, truth = cloud(KNOWN["cylindrical"], 5000, Scanner(seed=5), ovality=0.05)
    scan = vt.scan.spring_from_scan(written(tmp_path, points))
    a, b = 1.89e-3, 1.71e-3
    assert scan.section.ovate
    assert scan.section.long_axis[0] == pytest.approx(2 * a, abs=8e-6) and scan.section.short_axis[
        0
    ] == pytest.approx(2 * b, abs=8e-6)
    assert abs(scan.section.inclination) < 0.06
    x, y = np.meshgrid(np.linspace(-a, a, 801), np.linspace(-b, b, 801))
    stress = 2 * a**2 * b**2 / (a**2 + b**2) * np.maximum(1 - (x / a) ** 2 - (y / b) ** 2, 0.0)
    torsion = float(np.sum(stress)) * (x[0, 1] - x[0, 0]) * (y[1, 0] - y[0, 0])
    assert np.pi * scan.section.diameter[0] ** 4 / 32 == pytest.approx(torsion, rel=0.01)
    assert rms(scan, truth) < 0.02e-3


@pytest.mark.long
def test_order_position_and_unit_of_the_points_do_not_matter(tmp_path):
    points, _ = cloud(KNOWN["progressive"], 3000, SEEN["progressive"])
    scan = vt.scan.spring_from_scan(written(tmp_path, points))
    shuffled = vt.scan.spring_from_scan(
        written(tmp_path, np.random.default_rng(9).permutation(points))
    )
    assert np.array_equal(shuffled.curves.centre_line, scan.curves.centre_line)
    assert shuffled.free_length == scan.free_length
    inches = tmp_path / "scan.xyz"
    np.savetxt(inches, points / 25.4e-3, fmt="%.7f")
    other = vt.scan.spring_from_scan(inches, unit="inch")
    assert abs(other.free_length[0] - scan.free_length[0]) < 0.2 * scan.free_length[1]
    assert other.section.diameter[0] == pytest.approx(scan.section.diameter[0], abs=2e-6)
    assert other.total_coils[0] == pytest.approx(scan.total_coils[0], abs=5e-3)
    diameters = np.interp(scan.curves.coil, other.curves.coil, other.curves.mean_diameter)[8:-8]
    assert np.max(np.abs(diameters - scan.curves.mean_diameter[8:-8])) < 0.01e-3


def test_the_wider_end_or_the_closer_coils_stand_below_unless_turned(found):
    beehive, progressive = found["beehive"][0], found["progressive"][0]
    assert beehive.curves.mean_diameter[0] > beehive.curves.mean_diameter[-1] + 3e-3
    assert progressive.curves.pitch[30] < progressive.curves.pitch[-30]


def test_the_design_and_its_scan_have_the_same_force_and_frequencies(found):
    """The scan is of the design itself, so all differences are errors of the scan and of what they
    do.
    """
    scan = found["beehive"][0]
    design = vt.load_case(
        "gu2021-beehive-blind", {"spring.options": {"finite-element": {"elements_per_coil": 8}}}
    )
    compared = vt.scan.compare_scan(scan, design)
    assert compared.failures == ()
    assert compared.number("preload").scanned == pytest.approx(
        compared.number("preload").design, rel=0.02
    )
    assert compared.number("installed_height").scanned == pytest.approx(
        compared.number("installed_height").design, abs=0.06e-3
    )
    for mode in ("mode_1_frequency", "mode_2_frequency"):
        assert compared.number(mode).scanned == pytest.approx(
            compared.number(mode).design, rel=0.03
        )
    wire = compared.cases[1].springs[0].wire
    assert wire.material == compared.cases[0].springs[0].wire.material
    with pytest.raises(InputError, match="is compared"):
        compared.number("peak_spring_force")


def test_a_design_that_is_too_high_for_the_scan_is_refused(found):
    case = vt.load_case("job-t", {"spring.precompression": "1 mm"})
    with pytest.raises(InputError, match=r"shorter than the .* between the seats"):
        vt.scan.compare_scan(found["cylindrical"][0], case)
