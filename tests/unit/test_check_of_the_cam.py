"""``valvetrain check`` of the cam: its numbers against closed forms, its table and its sentence."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest
from typer.testing import CliRunner

from valvetrain.cam.cam_card import CamCard
from valvetrain.cli.cam_facts import cam_facts, cam_rows, check_verdict
from valvetrain.cli.case_facts import case_quantities
from valvetrain.cli.main import app
from valvetrain.parameters.loading import parse_case
from valvetrain.parameters.templates import template_text
from valvetrain.quantities.cam_shape import cam_durations, cam_quantities
from valvetrain.system.build import build

INCH = 25.4e-3


def bucket(lift_law: str, follower: str = 'shape = "flat"', lash: str = "0 mm"):
    """A bucket tappet on a base circle of 18 mm with a lift law of one's own."""
    text = template_text("direct")
    law, train = text.index("[lift_law]"), text.index("# Speeds of the crank")
    text = text[:law] + lift_law + text[train:]
    text = text.replace('shape = "flat" # flat, domed, roller, knife', follower)
    text = text.replace('lash = "0.1 mm" #', f'lash = "{lash}" #')
    case = parse_case(text.replace('face_diameter = "28 mm" #', "#"), "bucket")
    return case, build(case)


ARCS = """[lift_law]
kind = "three-arc"
lift_of = "tappet"
base_radius = "18 mm"
nose_radius = "4 mm"
maximum_lift = "8 mm"
nose = "180 deg"
opening_start = "115 deg"
"""


def test_the_least_radius_of_a_cam_of_arcs_is_its_nose_radius():
    """Closed form: circles of 18 mm, a flank and 4 mm, the nose 22 mm from the centre: under a flat
    face the contact runs by the velocity per radian, which has a kink between nodes here."""
    case, problem = bucket(ARCS)
    cam, _ = cam_facts(case, problem)
    assert cam["cam_least_radius"] == pytest.approx(4e-3, rel=1e-3)
    assert "cam_hollow_radius" not in cam
    law = problem.members[0].gear.mechanism.kinematics.law
    angle = np.linspace(0, math.tau, 200_001)
    assert cam["cam_contact_offset"] == pytest.approx(np.max(law.lift(angle, 1)), rel=2e-3)
    assert cam["cam_contact_face_radius"] == cam["cam_contact_offset"]
    assert cam["cam_opening_velocity"] == pytest.approx(cam["cam_closing_velocity"], rel=1e-9)


def test_the_contact_of_an_offset_bucket_is_counted_from_its_own_axis():
    """Contract: the velocity per radian of a symmetric lobe either way, and the offset on top."""
    plain = cam_facts(*bucket(ARCS))[0]
    moved = cam_facts(*bucket(ARCS, 'shape = "flat"\noffset = "2 mm"'))[0]
    assert moved["cam_contact_offset"] == pytest.approx(plain["cam_contact_offset"], rel=1e-6)
    assert moved["cam_contact_face_radius"] == pytest.approx(
        plain["cam_contact_offset"] + 2e-3, rel=1e-6
    )


def test_a_roller_on_a_fast_flank_has_a_hollow_cam():
    """Closed form: the contour of a roller's centre path, computed from points (three neighbours'
    circle) of the path less the roller."""
    law = (
        '[lift_law]\nkind = "cycloidal"\nlift_of = "tappet"\nmaximum_lift = "9 mm"\nopening_start = "110 deg"\n'
        'opening_end = "180 deg"\nclosing_start = "180 deg"\nclosing_end = "250 deg"\n'
    )
    case, problem = bucket(law, 'shape = "roller"\nradius = "9 mm"')
    cam, _ = cam_facts(case, problem)
    motion = problem.members[0].gear.mechanism.kinematics.law
    angle = np.linspace(0, math.tau, 20_001)
    reach = 18e-3 + 9e-3 + motion.lift(angle)
    x, y = reach * np.cos(angle), reach * np.sin(angle)
    dx, dy = np.gradient(x, angle), np.gradient(y, angle)
    curvature = (dx * np.gradient(dy, angle) - dy * np.gradient(dx, angle)) / np.hypot(dx, dy) ** 3
    radius = 1 / curvature[5:-5] - 9e-3
    assert cam["cam_least_radius"] == pytest.approx(np.min(radius[radius > 0]), rel=5e-3)
    assert cam["cam_hollow_radius"] == pytest.approx(-np.max(radius[radius < 0]), rel=5e-3)
    assert "cam_contact_offset" not in cam


def test_ramp_velocity_and_durations_are_those_of_the_card():
    """Closed form: a ramp of 0.0005 in/deg, durations as given."""
    card = CamCard(
        maximum_lift=0.33 * INCH, nose=math.pi, duration=math.radians(118), ramp_lift=0.0149 * INCH,
        advertised_duration=math.radians(141), advertised_lift=0.015 * INCH,
    )  # fmt: skip
    cam = cam_quantities(card, ramp=card.ramp_lift)
    for side in ("opening", "closing"):
        speed = cam[f"cam_{side}_ramp_velocity"] / INCH * math.radians(1)
        assert speed == pytest.approx(0.0005, rel=1e-9)
    found = cam_durations(card, (lift for _, lift, _ in card.checking_points))
    assert list(found) == sorted(found) and len(found) == 4  # 0.15, 0.381, 1 and 1.27 mm
    assert math.degrees(found[0.015 * INCH]) == pytest.approx(282)
    assert math.degrees(found[card.duration_lift]) == pytest.approx(236)


@pytest.mark.parametrize(
    ("face", "lash", "words"),
    [
        ("28 mm", "0.2 mm", "Ready to run: the lash opens on the ramp, at 0.0127 mm/deg; the contact stays 3.58 mm within the face;"),
        ("20 mm", "0.2 mm", "Ready to run, but the contact runs 0.417 mm off the face, which needs a diameter of 20.8 mm; the lash"),
        ("", "0.2 mm", "the follower's face needs a diameter of 20.8 mm"),
        ("28 mm", "0.4 mm", "Ready to run, but the lash takes 0.4 mm of the lobe, above its ramp, so that the valve strikes its seat"),
    ],
)  # fmt: skip
def test_the_sentence_says_where_lash_and_contact_are(face, lash, words):
    """Contract: doubts first; a bucket of 10.42 mm per radian on faces of 28 and 20 mm."""
    text = template_text("direct", cards=True).replace('lash = "0.2 mm"', f'lash = "{lash}"')
    text = text.replace('face_diameter = "28 mm"', f'face_diameter = "{face}"' if face else "")
    if lash != "0.2 mm":
        text = text.replace("[lift_law]", '[lift_law]\nramp_lift = "0.3 mm"', 1)
    case = parse_case(text, "bucket")
    problem = build(case)
    cam, _ = cam_facts(case, problem)
    sentence = check_verdict(case, problem, case_quantities(case, problem), cam)
    assert words in sentence
    assert sentence.endswith(" are left to coil bind.")


def test_a_coil_bind_that_no_card_lets_check_is_named():
    """Contract: a card without solid height leaves the coil bind unchecked, and the sentence says so."""
    text = re.sub(r"(?m)^solid_height = .*$", "", template_text("pushrod"))
    case = parse_case(text, "pushrod")
    problem = build(case)
    cam, _ = cam_facts(case, problem)
    sentence = check_verdict(case, problem, case_quantities(case, problem), cam)
    assert sentence.endswith("coil bind is not checked, for no spring states a solid height.")


def test_the_spring_of_a_pair_without_solid_height_is_named():
    """Contract: the room that is left is that of the spring whose card states it."""
    case = parse_case(template_text("pushrod"), "pushrod")
    found = {"rigid_maximum_valve_lift": 12e-3, "outer_coil_bind_lift": 15e-3}
    sentence = check_verdict(case, build(case), found, {})
    assert (
        "3 mm are left to coil bind of the outer spring; the inner one is not checked" in sentence
    )


def test_a_law_without_ramps_is_told_where_its_lash_opens():
    """Contract: 0.1 mm of lash on a polynomial flank."""
    case = parse_case(template_text("direct"), "bucket")
    problem = build(case)
    cam, _ = cam_facts(case, problem)
    sentence = check_verdict(case, problem, {}, cam)
    assert "cam_ramp_lift" not in cam and "for the lift law states no ramp" in sentence


def test_the_terminal_ends_with_table_and_sentence(tmp_path):
    """Contract: rows alike on both flanks are one, JSON holds the same numbers in SI."""
    path = tmp_path / "v8.toml"
    path.write_text(template_text("pushrod"), encoding="utf-8")
    lines = CliRunner().invoke(app, ["check", str(path)]).stdout.splitlines()
    assert "Lift law and cam" in "\n".join(lines) and lines[-1].endswith("to coil bind.")
    ramp = [line.split() for line in lines if line.startswith("Ramp velocity")]
    assert ramp == [["Ramp", "velocity", "0.0127", "mm/deg"]]
    assert any(line.split()[-3:] == ["288", "crank", "deg"] for line in lines)
    data = json.loads(CliRunner().invoke(app, ["check", str(path), "--json"]).stdout)
    assert data["quantities"]["cam_ramp_lift"] == {"value": pytest.approx(1e-4), "unit": "m"}
    assert data["durations"][0]["lift"]["value"] == pytest.approx(0.006 * INCH)
    assert math.degrees(data["durations"][0]["crank_angle"]["value"]) == pytest.approx(288)
    assert " ".join(" ".join(lines).split()).endswith(data["verdict"])


def test_a_lift_law_alone_and_a_spring_alone_are_said_so():
    """Contract: what there is; opening and closing apart where they differ."""
    law = parse_case(
        '[lift_law]\nkind = "harmonic"\nlift_of = "valve"\nmaximum_lift = "9 mm"\nopening_start = "100 deg"\n'
        'opening_end = "180 deg"\nclosing_start = "180 deg"\nclosing_end = "280 deg"\n'
    )
    cam, durations = cam_facts(law, None)
    rows = dict((label, (text, unit)) for label, text, unit in cam_rows(cam, durations))
    # harmonic: L pi / (2 beta) on each flank
    assert rows["Largest velocity of the lift law, opening"] == ("0.1767", "mm/deg")
    assert rows["Largest velocity of the lift law, closing"] == ("0.1414", "mm/deg")
    assert check_verdict(law, None, {}, cam) == "A lift law alone."
    spring = parse_case(template_text("spring"), "spring")
    assert cam_facts(parse_case(spring.text.split("[lift_law]")[0]), None) == ({}, {})


def check_text(path, *options: str) -> str:
    return " ".join(CliRunner().invoke(app, ["check", str(path), *options]).stdout.split())


OWN_TUBE = 'length = "7.63 in" # between its balls\nouter_diameter = "0.3125 in"\nwall_thickness = "0.080 in"'
TUBE = 'length = "7.63 in"\nouter_diameter = "0.375 in"\nwall_thickness = "0.080 in"'


def test_a_pushrod_by_its_tube_has_the_mass_and_stiffness_of_it(tmp_path):
    """Closed form: A = pi t (d - t), mass density A L, stiffness E A / L; a value given goes first."""
    bare = template_text("pushrod").replace(OWN_TUBE, TUBE, 1)
    area, length = math.pi * 0.08 * (0.375 - 0.08) * INCH**2, 7.63 * INCH
    rod = parse_case(bare).train.pushrod
    assert rod.mass == pytest.approx(7850 * area * length)
    assert rod.stiffness == pytest.approx(206e9 * area / length)
    titanium = TUBE + '\nyoungs_modulus = "114 GPa"\ndensity = "4430 kg/m^3"\nmass = "50 g"'
    other = parse_case(bare.replace(TUBE, titanium)).train.pushrod
    assert (other.mass, other.stiffness) == pytest.approx((0.05, 114e9 * area / length))
    path = tmp_path / "tube.toml"
    path.write_text(bare, encoding="utf-8")
    text = check_text(path)
    assert "193.8 mm between its balls, mass 72.77 g, stiffness 50.84 kN/mm" in text
    assert "Ready to run: the cam's" in text
    for wrong, said in (
        (TUBE.replace('"0.080 in"', '"0.200 in"'), "a wall of 5.08 mm does not fit"),
        (TUBE.split("\n")[0], "add outer_diameter, wall_thickness"),
        ("", "the pushrod needs its mass, or length"),
    ):
        path.write_text(bare.replace(TUBE, wrong), encoding="utf-8")
        assert said in " ".join(CliRunner().invoke(app, ["check", str(path)]).stderr.split())


@pytest.mark.parametrize(
    ("new", "said"),
    [
        (OWN_TUBE, ""),
        ('mass = "62 g"\nstiffness = "60 kN/mm"', "the pushrod's 60 kN/mm are more than the 43.3 kN/mm of a tube of 62 g and 193.8 mm"),
        ('mass = "62 g"\nstiffness = "43 kN/mm"', ""),
        ('mass = "62 g"\nstiffness = "20 kN/mm"', "the pushrod's 20 kN/mm are less than half of the 43.3 kN/mm"),
        (f'mass = "90 g"\n{TUBE.replace("7.63", "8.2")}', "the pushrod is 208.3 mm long and its balls are 193.8 mm apart ("),
    ],
)  # fmt: skip
def test_mass_stiffness_and_length_of_a_pushrod_are_those_of_one_tube(new, said, tmp_path):
    """Closed form: E m / (density L^2) is E A / L of a tube of any diameters: 43.3 kN/mm of 62 g
    and 193.8 mm of steel."""
    assert 206e9 * 0.062 / (7850 * 0.19376**2) == pytest.approx(43.3e6, rel=1e-3)
    path = tmp_path / "v8.toml"
    path.write_text(template_text("pushrod").replace(OWN_TUBE, new, 1), encoding="utf-8")
    end = check_text(path).partition("Ready to run")[2]
    assert end.startswith(f", but {said}" if said else ": the cam")


def test_check_prints_the_loads_of_a_wire_and_both_lifts(tmp_path):
    """Closed form: the load with the valve closed is G d^4 / (8 D^3 n) times 8.1 mm but for the tilt of
    the coils, the rate from there is between both; of a bucket the valve lifts less by the lash."""
    path = tmp_path / "spring.toml"
    path.write_text(template_text("spring"), encoding="utf-8")
    found = re.search(
        r"([\d.]+) N with the valve closed, ([\d.]+) N at the full lift of 9 mm, rate ([\d.]+) N/mm to ([\d.]+) N/mm",
        check_text(path),
    )
    closed, full, first, last = map(float, found.groups())
    assert closed == pytest.approx(43.236 * 8.1, rel=0.02) and first < (full - closed) / 9 < last
    assert "lbf with the valve closed" in check_text(path, "--units", "imperial")
    path.write_text(template_text("direct", cards=True), encoding="utf-8")
    text = check_text(path)
    assert "masses, forces and power are per valve" in text
    assert "the lobe lifts 9.2 mm, the valve 9 mm (less the lash of 0.2 mm)" in text
    assert "560 N at the full lift of 9 mm" in text  # as its card says
    path.write_text(template_text("pushrod"), encoding="utf-8")
    assert "N with the valve closed" in check_text(path)  # of the set 'wire'
    path.write_text(template_text("finger", cards=True), encoding="utf-8")
    assert "9.6 mm at zero lash, the valve lifts" in check_text(path)
