"""What --json prints: one object, every number with its unit, every name documented; and what a
failed run leaves behind.
"""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from unit.cli_parts import PUBLISHED, SMALL, call
from valvetrain.solution.definition import is_defined
from valvetrain.solution.quantity import unit_of

DOCUMENT = (Path(__file__).resolve().parents[2] / "docs" / "json.md").read_text(encoding="utf-8")


def numbers(item, path=""):
    """Every number in a JSON tree that stands without a unit."""
    if isinstance(item, dict):
        if set(item) in ({"value", "unit"}, {"values", "unit"}):
            assert isinstance(item["unit"], str) and item["unit"]
            return
        for key, value in item.items():
            yield from numbers(value, f"{path}.{key}")
    elif isinstance(item, list):
        for value in item:
            yield from numbers(value, path)
    elif isinstance(item, (int, float)) and not isinstance(item, bool):
        yield path


def quantities(tree):
    """Every object of named quantities in a JSON tree."""
    if isinstance(tree, dict):
        for key, value in tree.items():
            if key == "quantities":
                yield from value.items()
            else:
                yield from quantities(value)
    elif isinstance(tree, list):
        for value in tree:
            yield from quantities(value)


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    """The JSON text of each command."""
    folder = tmp_path_factory.mktemp("json")
    path = folder / "small.toml"
    path.write_text(SMALL + PUBLISHED)
    commands = {
        "run": ("--output", str(folder / "out"), "--no-report"),
        "sweep": ("--rpm", "8000:9000:500", "--model", "massless", "--output", str(folder / "swept")),
        "static": ("--steps", "8"),
        "modes": ("--count", "6"), "check": (),
    }  # fmt: skip
    results = {name: call(name, str(path), *rest, "--json") for name, rest in commands.items()}
    results["cases"] = call("cases", "--json")
    assert {name: result.exit_code for name, result in results.items()} == dict.fromkeys(results, 0)
    return {name: result.stdout for name, result in results.items()}


@pytest.mark.parametrize("command", ["run", "static", "modes", "check", "cases"])
def test_standard_output_is_one_object_whose_numbers_have_units(outputs, command):
    text = outputs[command]
    found = json.loads(text, parse_constant=pytest.fail)
    assert isinstance(found, dict) and found["command"] == command
    assert set(numbers(found)) <= {
        ".springs_at_rest.modes.modes.mode",
        ".springs_at_rest.modes.modes.axial",
    }  # plain counts


@pytest.mark.parametrize("command", ["run", "static", "modes", "check"])
def test_every_name_and_key_is_documented(outputs, command):
    found = json.loads(outputs[command])
    names = dict(quantities(found))
    assert names and not [name for name in names if not is_defined(name)]
    assert all(value["unit"] == unit_of(name) for name, value in names.items())
    assert not [
        key
        for key in (*found, *(key for run in found.get("runs", ()) for key in run))
        if f"`{key}`" not in DOCUMENT
    ]


def test_comparisons_hold_both_values_and_their_difference(outputs):
    rows = {row["quantity"]: row for row in json.loads(outputs["run"])["comparisons"]}
    peak = rows["peak_spring_force"]
    assert peak["engine_speed"] == {"value": 9000.0, "unit": "rpm"} and peak["role"] == "prediction"
    assert peak["published"] == {"value": 1.0, "unit": "N"} == peak["tolerance"]
    assert peak["difference"]["value"] == pytest.approx(peak["computed"]["value"] - 1.0)
    assert rows["seating_velocity"]["computed"] is None
    assert rows["peak_spring_force_cam_angle"]["published"]["unit"] == "rad"


def test_quantities_are_found_by_their_words():
    rows = json.loads(call("quantities", "float speed", "--json").stdout)["quantities"]
    assert {row["name"]: row["shown_unit"] for row in rows}["float_engine_speed"] == "rpm"
