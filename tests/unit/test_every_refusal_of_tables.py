"""What a case file is refused for, one change of a good file at a time: the sentence, and the key
that it names.
"""

from __future__ import annotations

import copy
import tomllib
from typing import Any

import pytest
import tomlkit

from valvetrain.errors import InputError
from valvetrain.parameters.loading import load_case, parse_case

WIRE = """
[spring]
wire_diameter = "4 mm"
mean_diameter = "24 mm"
pitch = "7.5 mm"
total_coils = 7
material = "OTEVA 90 SC"
precompression = "6 mm"
[lift_law]
kind = "sine-power"
maximum_lift = "8 mm"
opening_start = "50 deg"
closing_end = "170 deg"
[operation]
engine_speeds = ["2000 rpm"]
[[published]]
model = "test"
origin = "test"
source = "test"
role = "prediction"
engine_speed = "2000 rpm"
[published.quantities.peak_seat_force]
value = "500 N"
tolerance = "10 N"
"""
CARD = """
[spring]
preload = "300 N"
rate = "40 N/mm"
installed_height = "40 mm"
solid_height = "25 mm"
wire_diameter = "4 mm"
mean_diameter = "24 mm"
"""
TABLE = """
[lift_law]
kind = "table"
cam_angles = "50, 80, 110, 140, 170 deg"
lifts = "0, 3, 8, 3, 0 mm"
"""
TRAIN = load_case("tdi-pushrod").text
FILES = {"wire": WIRE, "card": CARD, "table": TABLE, "train": TRAIN}
GONE = None
#: File, what is changed (dotted key -> value, None: taken out), key that the refusal names, words
#: of it.
REFUSED: list[tuple[str, dict[str, Any], str, str]] = [
    ("wire", {"spring": GONE, "lift_law": GONE, "operation": GONE, "published": GONE}, "", "at least one of"),
    ("wire", {"study": "nobody-1900"}, "study", "is unknown"),
    ("wire", {"rubbing": {"coefficient": 0.1}}, "rubbing", "between two nested springs"),
    ("wire", {"operation.cam_speeds": ["1000 rpm"]}, "operation.cam_speeds", "both given"),
    ("wire", {"operation.engine_speeds": ["-2000 rpm"]}, "operation", "must be positive"),
    ("wire", {"operation.cycles": 0}, "operation.cycles", "from 1 to 10000"),
    ("wire", {"operation.cycles": 10001}, "operation.cycles", "from 1 to 10000"),
    ("wire", {"spring.wire_diameter": "4 N"}, "spring.wire_diameter", "a length"),
    ("wire", {"spring.wire_diameter": {"coils": [0, 7], "clearances": "1, 1 mm"}}, "spring.wire_diameter", "belong to a pitch"),
    ("wire", {"spring.mean_diameter": {"coils": [7, 0], "values": "24, 24 mm"}}, "spring.mean_diameter", "must increase"),
    ("wire", {"spring.mean_diameter": {"coils": [0, 7]}}, "spring.mean_diameter", "give one of them"),
    ("wire", {"spring.mean_diameter": {"coils": [0, 7], "values": "24, 24 mm", "clearances": "1, 1 mm"}}, "spring.mean_diameter",
     "give one of them"),
    ("wire", {"spring.mean_diameter": {"formula": "barrel", "ends": "24 mm", "middle": "20 mm"}}, "spring.mean_diameter", "wrong way"),
    ("wire", {"spring.mean_diameter": {"formula": "hourglass", "ends": "20 mm", "middle": "24 mm"}}, "spring.mean_diameter", "wrong way"),
    ("wire", {"spring.mean_diameter": {"formula": "conical", "lower": "24 mm"}}, "spring.mean_diameter", "add upper"),
    ("wire", {"spring.mean_diameter": {"formula": "beehive", "lower": "24 mm", "upper": "20 mm"}}, "spring.mean_diameter",
     "add taper_from_coil"),
    ("wire", {"spring.wire_diameter": {"coils": [0, 7], "values": "4, 4.1 mm"},
               "spring.pitch": {"formula": "closed-ends", "pitch": "7 mm"}},
     "spring.pitch", "constant diameter"),
    ("wire", {"spring.outer_diameter": "28 mm"}, "spring.outer_diameter", "are both given"),
    ("wire", {"spring.free_length": "50 mm"}, "spring.free_length", "are both given"),
    ("wire", {"spring.pitch": GONE}, "spring", "neither"),
    ("wire", {"spring.pitch": GONE, "spring.free_length": "27 mm"}, "spring.free_length", "no gap"),
    ("wire", {"spring.pitch": GONE, "spring.free_length": "50 mm", "spring.wire_diameter": {"coils": [0, 7], "values": "4, 4.1 mm"}},
     "spring.free_length", "constant diameter"),
    ("wire", {"spring.ends": "closed", "spring.lower_end": "open"}, "spring.ends", "speaks for both ends"),
    ("wire", {"spring.ends": "closed", "spring.upper_end": "open"}, "spring.ends", "speaks for both ends"),
    ("wire", {"spring.material": {"youngs_modulus": "206 GPa", "shear_modulus": "70 GPa", "poisson_ratio": 0.3, "density": "7850 kg/m^3"}},
     "spring.material", "contradicts"),
    ("wire", {"spring.material": {"youngs_modulus": "206 GPa", "density": "7850 kg/m^3"}}, "spring.material", "a name from the library"),
    ("wire", {"lift_law": "sine"}, "lift_law", "needs its kind"), ("wire", {"lift_law.kind": GONE}, "lift_law", "needs its kind"),
    ("wire", {"lift_law.kind": "sine-powr"}, "lift_law.kind", "sine-power"),
    ("wire", {"lift_law.power": 1}, "lift_law.power", "from 2 to 40"), ("wire", {"lift_law.power": 41}, "lift_law.power", "from 2 to 40"),
    ("wire", {"lift_law.closing_end": "50 deg"}, "lift_law.closing_end", "must come after"),
    ("wire", {"lift_law.closing_end": "411 deg"}, "lift_law.closing_end", "longer than one cam revolution"),
    ("wire", {"lift_law.kind": "polynomial", "lift_law.exponents": "3-x", "lift_law.opening_end": "110 deg",
               "lift_law.closing_start": "110 deg"}, "lift_law", "whole numbers from 1"),
    ("wire", {"published.0.quantities.peak_seat_force.tolerance": "-10 N"}, "published.0.quantities.peak_seat_force.tolerance",
     "zero or more"),
    ("wire", {"published.0.quantities.peak_seat_force.tolerance": "10 mm"}, "published.0.quantities.peak_seat_force.tolerance", "N"),
    ("wire", {"published.0.quantities.peak_seat_force.value": "10 mm"}, "published.0.quantities.peak_seat_force.value", "N"),
    ("card", {"spring.preload": "-1 N"}, "spring.preload", "zero or more"),
    ("card", {"spring.preload_height": "30 mm", "spring.installed_height": "40 mm"}, "spring.installed_height", "loose"),
    ("card", {"spring.solid_height": "40 mm"}, "spring.solid_height", "not below installed_height"),
    ("card", {"spring.rate": GONE}, "spring", "the rate is missing"),
    ("card", {"spring.free_length": "52 mm"}, "spring.free_length", "leave one of them out"),
    ("card", {"spring.rate": GONE, "spring.free_length": "40 mm"}, "spring.free_length", "not above the height of a preload"),
    ("card", {"spring.rate": GONE, "spring.free_length": "52 mm", "spring.installed_height": GONE}, "spring.free_length", "add installed_height"),
    ("card", {"spring.open_load": "700 N", "spring.open_lift": "8 mm"}, "spring.rate", "contradicts the loads"),
    ("card", {"spring.open_load": "300 N", "spring.open_lift": "8 mm"}, "spring.open_load", "does not exceed preload"),
    ("card", {"spring.open_height": "32 mm", "spring.open_lift": "8 mm"}, "spring.open_height", "both given"),
    ("card", {"spring.open_height": "32 mm", "spring.installed_height": GONE}, "spring.open_height", "add installed_height"),
    ("card", {"spring.open_height": "41 mm"}, "spring.open_height", "not below that of the preload"),
    ("card", {"spring.wire_diameter": GONE}, "spring.wire_diameter", "add it, or mass"),
    ("card", {"spring.wire_diameter": GONE, "spring.mean_diameter": GONE, "spring.active_coils": 5},
     "spring.wire_diameter", "add it, or mass"),
    ("card", {"spring.wire_diameter": GONE, "spring.mean_diameter": GONE, "spring.outer_diameter": "28 mm"},
     "spring.wire_diameter", "add it, or mass"),
    ("card", {"spring.mean_diameter": GONE}, "spring.mean_diameter", "give one of them"),
    ("card", {"spring.outer_diameter": "28 mm"}, "spring.mean_diameter", "give one of them"),
    ("card", {"spring.mean_diameter": "8 mm"}, "spring.wire_diameter", "too narrow"),
    ("card", {"spring.active_coils": 12}, "spring.wire_diameter", "active coils"),
    ("table", {"lift_law.cam_angles": "50, 80, 170 deg", "lift_law.lifts": "0, 3, 0 mm"}, "lift_law", "at least four stations"),
    ("table", {"lift_law.cam_angles": "50, 80, 80, 140, 170 deg"}, "lift_law", "must increase"),
    ("table", {"lift_law.cam_angles": "50, 80, 110, 140, 411 deg"}, "lift_law", "more than one cam revolution"),
    ("table", {"lift_law.lifts": "0, 3, 8, 0 mm"}, "lift_law", "4"),
    ("table", {"lift_law.lifts": GONE}, "lift_law", "lifts"), ("table", {"lift_law.cam_angles": GONE}, "lift_law", "cam_angles"),
    ("table", {"lift_law.smoothing": "-1 um"}, "lift_law.smoothing", "zero or more"),
    ("table", {"lift_law.file": "lift.csv"}, "lift_law", "file"),
    ("train", {"train.kind": "pushrods"}, "train.kind", "pushrod"),
    ("train", {"train.gravity": "0, 0, -9.81 m/s^2"}, "train.gravity", "two accelerations"),
    ("train", {"train.lever.ratio": 3.0}, "train.lever.ratio", "contradicts the arms"),
    ("train", {"train.lever.valve_arm": GONE}, "train.lever.valve_arm", "valve_arm over drive_arm"),
    ("train", {"train.contacts": "wood"}, "train.contacts", "a table of places"),
    ("train", {"train.contacts.cam": "wood"}, "train.contacts.cam", "needs its law"),
    ("train", {"train.contacts.cam": {"law": "impacts"}}, "train.contacts.cam.law", "impact"),
    ("train", {"train.contacts.cam.contact_stiffness": "3 mm"}, "train.contacts.cam", "a force over a length"),
    ("train", {"train.contacts.cam.contact_stiffness": "3 N/mm^4"}, "train.contacts.cam", "a force over a length"),
    ("train", {"train.contacts.cam.damping": "3 mm"}, "train.contacts.cam", "no damping of a contact"),
    ("train", {"train.contacts.others": {"law": "linear", "contact_stiffness": "1e5 N/mm"}}, "train.contacts.others",
     "the contacts not named"),
    ("train", {"train.variants": [{"label": "x", "spring_set": "none"}]}, "train.variants.0.spring_set", "is unknown"),
    ("train", {"train.spring_set": "none"}, "train", "is unknown"),
    ("train", {"train.cycles": 0}, "train", "from 1 to 10000"),
    ("train", {"train.lash": "-1 mm"}, "train", "lash"),
    ("train", {"spring": {"wire_diameter": "4 mm", "mean_diameter": "24 mm", "pitch": "7 mm", "total_coils": 7, "material": "OTEVA 90 SC"}},
     "spring", "move it there"),
    ("train", {"train.follower.tilt": "31 deg"}, "train.follower", "30 deg"),
    ("train", {"train.valve.head_fraction": 1.2}, "train.valve", "head_fraction"),
    ("train", {"train.follower.shape": "dome"}, "train.follower.shape", "domed"),
    ("train", {"train.push_rod": {"mass": "60 g"}}, "train.push_rod", "pushrod"),
    ("train", {"train.lever.pivot": "25 mm"}, "train.lever.pivot", "two lengths"),
]  # fmt: skip


def changed(text: str, changes: dict[str, Any]) -> str:
    tree = copy.deepcopy(tomllib.loads(text))
    for key, value in changes.items():
        *path, last = (int(part) if part.isdecimal() else part for part in key.split("."))
        table: Any = tree
        for part in path:
            table = table.setdefault(part, {}) if isinstance(table, dict) else table[part]
        if value is GONE:
            table.pop(last, None)
        else:
            table[last] = value
    return tomlkit.dumps(tree)


@pytest.mark.parametrize("name", FILES)
def test_each_file_is_taken_as_it_stands(name):
    parse_case(changed(FILES[name], {}))


@pytest.mark.parametrize(
    ("name", "changes", "key", "words"),
    REFUSED,
    ids=[f"{name} {change}"[:70] for name, change, *_ in REFUSED],
)
def test_one_change_is_refused_where_it_stands(name, changes, key, words):
    with pytest.raises(InputError, match=words) as refusal:
        parse_case(changed(FILES[name], changes))
    assert key in refusal.value.where
