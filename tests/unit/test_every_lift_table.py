"""Every kind of lift law as a table of a case file: what the file says in its units is what the law
is made of, in SI, by hand.
"""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomlkit

from valvetrain import registry
from valvetrain.cam.arcs import ThreeArc
from valvetrain.cam.flanks import FlankModel
from valvetrain.cam.spline import Spline
from valvetrain.errors import InputError
from valvetrain.parameters.lift_law import read_lift_model
from valvetrain.parameters.loading import parse_case

DEG, INCH = math.pi / 180, 0.0254
FLANKS = 'maximum_lift = "8 mm"\nopening_start = "50 deg"\nopening_end = "100 deg"\nclosing_start = "120 deg"\nclosing_end = "175 deg"\n'
IN_SI = {
    "maximum_lift": 8e-3,
    "opening_start": 50 * DEG,
    "opening_end": 100 * DEG,
    "closing_start": 120 * DEG,
    "closing_end": 175 * DEG,
}
EVENT = 'maximum_lift = "8 mm"\nopening_start = "50 deg"\nclosing_end = "170 deg"\n'
EVENT_SI = {"maximum_lift": 8e-3, "opening_start": 50 * DEG, "closing_end": 170 * DEG}
RAMP = (
    'maximum_lift = "9 mm"\nramp_lift = "0.2 mm"\nramp_start = "30 deg"\nevent_start = "50 deg"\n'
)
RAMP_SI = {
    "maximum_lift": 9e-3,
    "ramp_lift": 2e-4,
    "ramp_start": 30 * DEG,
    "event_start": 50 * DEG,
    "ramp_blend": 0.3,
}
ARCS = 'base_radius = "15 mm"\nnose_radius = "6 mm"\nmaximum_lift = "9 mm"\nnose = "110 deg"\n'
ARCS_SI = {"base_radius": 0.015, "nose_radius": 0.006, "maximum_lift": 0.009, "nose": 110 * DEG}
CARD = 'angle_of = "crank"\nlobe_lift = "0.353 in"\nduration = "224 deg"\n'
CARD_SI = {
    "maximum_lift": 0.353 * INCH,
    "nose": math.pi,
    "duration": 112 * DEG,
    "duration_lift": 0.05 * INCH,
    "ramp_lift": 1e-4,
    "ramp_velocity": None,
    "ramp_blend": 0.3,
}
STATIONS = {
    "cam_angles": tuple(a * DEG for a in (50, 80, 110, 140, 170)),
    "lifts": (0.0, 3e-3, 8e-3, 3e-3, 0.0),
}
POINTS = 'cam_angles = "50, 80, 110, 140, 170 deg"\nlifts = "0, 3, 8, 3, 0 mm"\n'
POLYDYNE_SI = EVENT_SI | {"exponents": (2, 10, 18, 26, 34), "dynamic_deflection": 0.0}
#: Kind, its table, the law's arguments.
TABLES: list[tuple[str, str, dict[str, Any]]] = [
    ("zero", "", {}),
    *((word, FLANKS, IN_SI) for word in registry.names("lifts") if registry.find("lifts", word).table is FlankModel),
    ("polynomial", FLANKS, IN_SI | {"exponents": (3, 4, 5)}),
    ("polynomial", FLANKS + 'exponents = "4-5-6-7"\n', IN_SI | {"exponents": (4, 5, 6, 7)}),
    ("sine-power", EVENT, EVENT_SI | {"power": 4}), ("sine-power", EVENT + "power = 6\n", EVENT_SI | {"power": 6}),
    ("polydyne", EVENT, POLYDYNE_SI),
    ("polydyne", EVENT + 'exponents = [2, 8, 14, 20, 26]\n', POLYDYNE_SI | {"exponents": (2, 8, 14, 20, 26)}),
    ("polydyne", EVENT + 'ramp_lift = "0.1 mm"\nramp_length = "20 deg"\nramp_blend = 0.5\n',
     POLYDYNE_SI | {"ramp_lift": 1e-4, "ramp_length": 20 * DEG, "ramp_blend": 0.5}),
    ("polydyne", EVENT + 'effective_mass = "200 g"\neffective_stiffness = "5 kN/mm"\ndesign_engine_speed = "6000 rpm"\n',
     POLYDYNE_SI | {"dynamic_deflection": 0.2 / 5e6 * (3000 * math.pi / 30) ** 2}),
    ("ramped", RAMP + 'event_end = "170 deg"\nramp_end = "200 deg"\n',
     RAMP_SI | {"event_end": 170 * DEG, "ramp_end": 200 * DEG, "nose_acceleration": None, "flank": "quintic"}),
    ("ramped", RAMP + 'event_end = "170 deg"\nramp_end = "200 deg"\nnose_acceleration = "-40 mm/rad^2"\nflank = "pulses"\n',
     RAMP_SI | {"event_end": 170 * DEG, "ramp_end": 200 * DEG, "nose_acceleration": -0.04, "flank": "pulses"}),
    ("shaped", RAMP + 'nose = "110 deg"\nflank_shape = [1, 1, -1, -1, -1]\n',
     RAMP_SI | {"nose": 110 * DEG, "flank_shape": (1, 1, -1, -1, -1)}),
    ("shaped", RAMP + 'nose = "110 deg"\nevent_end = "172 deg"\nflank_shape = [1, 1, -1, -1, -1]\n',
     RAMP_SI | {"nose": 110 * DEG, "event_end": 172 * DEG, "flank_shape": (1, 1, -1, -1, -1)}),
    ("shaped", RAMP + 'nose = "110 deg"\nflank_shape = [1, 1, -1, -1, -1]\nclosing_flank_shape = [2, 1, -1, -1]\n',
     RAMP_SI | {"nose": 110 * DEG, "flank_shape": (1, 1, -1, -1, -1), "closing_flank_shape": (2, 1, -1, -1)}),
    ("three-arc", ARCS + 'opening_start = "45 deg"\n', ARCS_SI | {"opening_start": 45 * DEG, "follower_radius": 0.0}),
    ("three-arc", ARCS + 'opening_start = "45 deg"\nfollower_radius = "12 mm"\n',
     ARCS_SI | {"opening_start": 45 * DEG, "follower_radius": 0.012}),
    # (R_f - R_n)^2 = d^2 + e^2 + 2 d e cos a of a flank of 60 mm: d = 18, e = 45, a = 77.9 deg
    ("three-arc", ARCS + 'flank_radius = "60 mm"\n',
     ARCS_SI | {"follower_radius": 0.0, "opening_start": 110 * DEG - math.acos((54**2 - 18**2 - 45**2) / (2 * 18 * 45))}),
    ("tangent", ARCS + 'follower_radius = "12 mm"\n', ARCS_SI | {"follower_radius": 0.012}),
    ("stations", POINTS + 'velocities = "0, 5, 0, -5, 0 mm/rad"\naccelerations = "0, 0, -20, 0, 0 mm/rad^2"\n',
     STATIONS | {"velocities": (0.0, 5e-3, 0.0, -5e-3, 0.0), "accelerations": (0.0, 0.0, -0.02, 0.0, 0.0)}),
    ("spline", POINTS, STATIONS | {"degree": 5, "smoothing": 0.0}),
    ("table", POINTS + 'degree = 7\nsmoothing = "2 um"\n', STATIONS | {"degree": 7, "smoothing": 2e-6}),
    ("table", 'cam_angles = "50, 65, 80, 95, 110 deg"\nlifts = "0, 1, 3, 6, 8 mm"\nmirror_angle = "110 deg"\n',
     {"cam_angles": tuple(a * DEG for a in (50, 65, 80, 95, 110, 125, 140, 155, 170)), "degree": 5, "smoothing": 0.0,
      "lifts": (0.0, 1e-3, 3e-3, 6e-3, 8e-3, 6e-3, 3e-3, 1e-3, 0.0)}),
    ("cam-card", CARD, CARD_SI),
    ("cam-card", CARD.replace("crank", "cam").replace("224", "112"), CARD_SI),
    ("cam-card", CARD + 'lobe_centre = "108 deg"\n', CARD_SI | {"nose": math.pi + 54 * DEG}),
    ("cam-card", CARD + 'lobe_centre = "108 deg"\nvalve = "exhaust"\ntop_dead_centre = "90 deg"\n', CARD_SI | {"nose": 36 * DEG}),
    ("cam-card", CARD + 'rocker_ratio = 1.6\nlash = "0.32 mm"\n', CARD_SI | {"ramp_lift": 3e-4}),
    ("cam-card", CARD + 'rocker_ratio = 1.6\nlash = "0.32 mm"\nlift_of = "valve"\n', CARD_SI | {"ramp_lift": 4.2e-4}),
    ("cam-card", CARD + 'ramp_lift = "0.15 mm"\nramp_velocity = "0.02 mm/deg"\nramp_blend = 0.4\n',
     CARD_SI | {"ramp_lift": 1.5e-4, "ramp_velocity": 2e-5 / DEG, "ramp_blend": 0.4}),
    ("cam-card", CARD + 'advertised_duration = "280 deg"\n',
     CARD_SI | {"advertised_duration": 140 * DEG, "advertised_lift": 0.006 * INCH}),
    ("cam-card", CARD + 'upper_duration = "140 deg"\nupper_lift = "5 mm"\n', CARD_SI | {"upper_duration": 70 * DEG, "upper_lift": 5e-3}),
    ("cam-card", CARD.replace('lobe_lift = "0.353 in"', 'valve_lift = "16 mm"\nrocker_ratio = 1.6'), CARD_SI | {"maximum_lift": 0.01}),
    ("cam-card", CARD + 'valve_lift = "0.5648 in"\nrocker_ratio = 1.6\n', CARD_SI),
]  # fmt: skip
#: Kind, table, key that is named, words.
REFUSED = [
    ("polydyne", EVENT + 'ramp_lift = "0.1 mm"\n', "", "together"), ("polydyne", EVENT + 'ramp_length = "20 deg"\n', "", "together"),
    ("polydyne", EVENT + 'ramp_lift = "8 mm"\nramp_length = "20 deg"\n', "ramp_lift", "not below maximum_lift"),
    *(("polydyne", EVENT + one, "", "together, or none") for one in
      ('effective_mass = "200 g"\n', 'effective_stiffness = "5 kN/mm"\n', 'design_engine_speed = "6000 rpm"\n')),
    ("polynomial", FLANKS + "exponents = [3, 4.5]\n", "exponents", "whole numbers"),
    ("polynomial", FLANKS + "exponents = [0, 4]\n", "exponents", "whole numbers"),
    ("polynomial", FLANKS + "exponents = [3, 201]\n", "exponents", "whole numbers"),
    ("polynomial", FLANKS + "exponents = [3, true]\n", "exponents", "whole numbers"),
    ("polynomial", FLANKS + "exponents = [4, 3]\n", "exponents", "rising order"),
    ("polynomial", FLANKS + "exponents = [3]\n", "exponents", "2 to 12"),
    ("polynomial", FLANKS + f"exponents = {list(range(3, 16))}\n", "exponents", "2 to 12"),
    ("cycloidal", FLANKS.replace('"120 deg"', '"99 deg"'), "closing_start", "must come after opening_end"),
    ("cycloidal", FLANKS.replace('"175 deg"', '"120 deg"'), "closing_end", "must come after closing_start"),
    ("ramped", RAMP.replace("0.2 mm", "9 mm") + 'event_end = "170 deg"\nramp_end = "200 deg"\n', "ramp_lift", "not below maximum_lift"),
    ("ramped", RAMP + 'event_end = "40 deg"\nramp_end = "200 deg"\n', "event_end", "must come after event_start"),
    ("shaped", RAMP + 'nose = "40 deg"\nflank_shape = [1, 1, -1, -1, -1]\n', "nose", "must come after event_start"),
    ("shaped", RAMP + 'nose = "110 deg"\nevent_end = "100 deg"\nflank_shape = [1, 1, -1, -1, -1]\n', "event_end", "must come after nose"),
    ("three-arc", ARCS, "", "give one of them"),
    ("three-arc", ARCS + 'opening_start = "45 deg"\nflank_radius = "60 mm"\n', "", "give one of them"),
    ("three-arc", ARCS + 'flank_radius = "15 mm"\n', "flank_radius", "cannot touch both"),
    ("tangent", ARCS.replace('"6 mm"', '"16 mm"') + 'follower_radius = "12 mm"\n', "", "smaller than base_radius"),
    ("stations", POINTS + 'velocities = "0, 5, -5, 0 mm/rad"\naccelerations = "0, 0, -20, 0, 0 mm/rad^2"\n', "velocities", "4 entries"),
    ("table", POINTS + 'mirror_angle = "180 deg"\n', "mirror_angle", "ends at 170 deg, not 180 deg"),
    ("table", POINTS.replace("0, 3, 8", "0, -3, 8"), "lifts", "must not be negative"),
    ("table", 'file = "lift.csv"\n', "", "angle_unit is missing"),
    ("table", 'file = "lift.csv"\nangle_unit = "deg"\n', "", "angle_of is missing"),
    ("table", 'file = "lift.csv"\nangle_unit = "deg"\nangle_of = "cam"\n', "", "lift_unit is missing"),
    ("cam-card", CARD.replace('lobe_lift = "0.353 in"\n', ""), "", "needs lobe_lift, or valve_lift and rocker_ratio"),
    ("cam-card", CARD.replace("lobe_lift", "valve_lift"), "", "needs lobe_lift, or valve_lift and rocker_ratio"),
    ("cam-card", CARD.replace('lobe_lift = "0.353 in"\n', "rocker_ratio = 1.6\n"), "", "needs lobe_lift, or valve_lift and rocker_ratio"),
    ("cam-card", CARD + 'valve_lift = "0.58 in"\nrocker_ratio = 1.6\n', "valve_lift", "correct one"),
    ("cam-card", CARD + 'lash = "0.3 mm"\n', "lash", "add it, 1 where the cam moves the valve itself, or"),
]  # fmt: skip


def law(kind: str, text: str) -> Any:
    found = parse_case(f'[lift_law]\nkind = "{kind}"\n{text}')
    assert found.lift_law is not None
    return found.lift_law


def test_every_kind_has_a_table_here():
    assert {kind for kind, _, _ in TABLES} | {"measured"} == set(registry.names("lifts"))


@pytest.mark.parametrize(
    ("kind", "text", "wanted"),
    TABLES,
    ids=[f"{kind} {place}" for place, (kind, _, _) in enumerate(TABLES)],
)
def test_a_table_is_the_law_that_it_says(kind, text, wanted):
    found = dict(law(kind, text).values)
    assert set(found) == set(wanted)
    for name, value in wanted.items():
        assert found[name] == (
            value
            if isinstance(value, str) or value is None
            else pytest.approx(value, rel=1e-9, abs=1e-12)
        ), name
    registry.find("lifts", kind).make(**found)


@pytest.mark.parametrize(
    ("kind", "text", "key", "words"),
    REFUSED,
    ids=[f"{one[0]} {n}" for n, one in enumerate(REFUSED)],
)
def test_a_table_that_contradicts_itself_is_refused_at_its_key(kind, text, key, words):
    with pytest.raises(InputError, match=words) as refusal:
        law(kind, text)
    assert refusal.value.where.endswith(f"lift_law.{key}" if key else "lift_law")


@pytest.mark.parametrize(
    ("unit", "of", "length", "factor"), [("deg", "cam", "mm", 1.0), ("rad", "crank", "in", 2.0)]
)
def test_a_table_in_a_file_is_that_of_its_units(tmp_path, unit, of, length, factor):
    at, heights = (
        (20, 35, 50, 80, 110, 140, 170, 185, 200),
        (0, 0, 0, 3, 8, 3, 0, 0, 0),
    )  # the event is kept, from rest to rest
    angles = [value * factor * (DEG if unit == "rad" else 1.0) for value in at]
    lifts = [value * (1.0 if length == "mm" else 1e-3 / INCH) for value in heights]
    (tmp_path / "lift.csv").write_text(
        "# a table\n" + "".join(f"{a!r}, {b!r}\n" for a, b in zip(angles, lifts, strict=True))
    )
    text = f'kind = "table"\nfile = "lift.csv"\nangle_unit = "{unit}"\nangle_of = "{of}"\nlift_unit = "{length}"\n'
    found = read_lift_model(tomllib.loads(text)).values(Path(tmp_path))
    assert found["cam_angles"] == pytest.approx(STATIONS["cam_angles"]) and found[
        "lifts"
    ] == pytest.approx(STATIONS["lifts"])
    assert tomlkit.loads(text)["file"] == "lift.csv"


def test_a_table_without_room_for_its_jumps_is_a_smooth_spline():
    """Arcs jump in acceleration; straight acceleration between stations needs one more of them on
    either side of the event.
    """
    lobe = ThreeArc(**ARCS_SI, opening_start=45 * DEG)
    lifts = lobe.lift(np.linspace(45 * DEG, 175 * DEG, 66))
    lifts[[0, -1]] = 0.0
    narrow, whole = (
        Spline(cam_angles=tuple(np.linspace(0.0, span, 66)), lifts=tuple(lifts))
        for span in (4.0, 2 * math.pi)
    )
    assert len(narrow.joints) > 66 and narrow.joints[0] < 0 < narrow.joints[-1]
    assert whole.joints == whole.cam_angles
    for made, within in ((narrow, 2e-5), (whole, 1e-12)):
        assert made.lift(np.array(made.cam_angles)) == pytest.approx(lifts, abs=within)


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("110, nan", "is no row of numbers"),
        ("inf, 8", "is no row of numbers"),
        ("110, eight", "is no row of numbers"),
        ("110", "has 1 numbers, the first row 2"),
        ("; 8", "has 1 numbers, the first row 2"),
        ("110, 8, 1", "has 3 numbers, the first row 2"),
    ],
)
def test_a_row_of_a_file_that_is_no_pair_of_numbers_is_refused_by_its_number(tmp_path, row, words):
    rest = "\n".join(f"{angle}, 0" for angle in range(170, 260, 10))
    (tmp_path / "lift.csv").write_text(f"angle, lift\n50, 0\n80, 3\n{row}\n140, 3\n{rest}\n")
    text = 'kind = "table"\nfile = "lift.csv"\nangle_unit = "deg"\nangle_of = "cam"\nlift_unit = "mm"\n'
    with pytest.raises(Exception, match=rf"line 4 of lift\.csv {words}"):
        read_lift_model(tomllib.loads(text)).values(Path(tmp_path))
