"""Units of the reader: what a person reads in inches and pounds, while files, JSON and names stay SI."""

from __future__ import annotations

import base64
import json

import numpy as np
import pint
import pytest
from typer.testing import CliRunner

import valvetrain as vt
from valvetrain.cli.main import app
from valvetrain.errors import InputError
from valvetrain.parameters.templates import template_text
from valvetrain.report.chart import Chart, HeatMap, Line, Panel, Rule
from valvetrain.report.clauses import amount_text, quantity_text
from valvetrain.report.motion.project import motion_data
from valvetrain.report.motion.scene import moving_picture
from valvetrain.report.reader_charts import chart_for_reader
from valvetrain.report.text import amount
from valvetrain.solution.definition import definition_of, shown, tables
from valvetrain.units import dimension_of, dimension_powers
from valvetrain.units.reader import (
    IMPERIAL,
    for_reader,
    reader_factor,
    reader_text,
    reader_unit,
    request_units,
    shown_system,
)

ROWS = [one for rows in tables().values() for one in rows if "{" not in one.name]


@pytest.fixture
def imperial():
    """Numbers are formatted in inches and pounds."""
    request_units("imperial")
    with for_reader():
        yield
    request_units("si")


@pytest.mark.parametrize(
    ("metric", "name", "imperial_unit", "as_pint"),
    [
        ("N", "newton", "lbf", "force_pound"),
        ("mm", "millimeter", "in", "inch"),
        ("N/mm", "newton / millimeter", "lbf/in", "force_pound / inch"),
        ("MPa", "megapascal", "ksi", "kip_per_square_inch"),
        ("m/s", "meter / second", "in/s", "inch / second"),
        ("m/s2", "meter / second**2", "in/s^2", "inch / second**2"),
        ("N m", "newton * meter", "lbf in", "force_pound * inch"),
        ("mJ", "millijoule", "lbf in", "force_pound * inch"),
        ("mN s", "millinewton * second", "lbf s", "force_pound * second"),
        ("W", "watt", "hp", "horsepower"),
        ("mm/deg", "millimeter / degree", "in/deg", "inch / degree"),
        ("um/deg^2", "micrometer / degree**2", "in/deg^2", "inch / degree**2"),
    ],
)
def test_factors_are_those_of_pint(imperial, metric, name, imperial_unit, as_pint):
    """Other solver: the registry of pint as it ships, not the units that this package reads."""
    registry = pint.UnitRegistry()
    known = registry.Quantity(1.0, name).to(as_pint).magnitude
    assert reader_unit(metric) == imperial_unit
    assert reader_factor(metric) == pytest.approx(known, rel=1e-9)


@pytest.mark.parametrize("one", ROWS, ids=lambda one: one.name)
def test_every_quantity_is_read_in_a_unit_of_its_own_dimension(imperial, one):
    """Property: value times unit is the same in both systems, and inches stand where metres did."""
    row = definition_of(one.name)
    assert dimension_powers(f"1 {row.shown_unit}") == dimension_powers(f"1 {one.shown_unit}")
    assert row.si_unit == one.si_unit and row.label == one.label
    if dimension_of(one.shown_unit) in IMPERIAL:
        assert row.shown_unit in IMPERIAL.values()
    value, unit = shown(one.name, 1.0)
    assert unit == row.unit_word
    assert value / reader_factor(one.shown_unit) == pytest.approx(_metric(one), rel=1e-12)


def _metric(one) -> float:
    from valvetrain.units import unit_factor

    return 1.0 / unit_factor(one.shown_unit)


def test_nothing_is_converted_outside_of_what_a_reader_sees():
    """Contract: the request alone changes nothing, and the block gives back what was."""
    request_units("imperial")
    try:
        assert shown_system() == "si" and reader_unit("N") == "N" and reader_factor("N") == 1.0
        with for_reader():
            assert definition_of("peak_spring_force").shown_unit == "lbf"
        assert definition_of("peak_spring_force").shown_unit == "N"
    finally:
        request_units("si")
    with for_reader():
        assert amount(250.0, "N") == "250 N"
    with pytest.raises(InputError, match="use si or imperial"):
        request_units("metric")


def test_texts_are_in_pounds_and_inches(imperial):
    """Closed form: 1000 N = 224.8 lbf, 12.7 mm = 0.5 in, 100 N/mm = 571 lbf/in, 1 GPa = 145 ksi."""
    assert quantity_text("peak_spring_force", 1000.0) == "225 lbf"
    assert quantity_text("coil_bind_clearance", 12.7e-3) == "0.5 in"
    assert quantity_text("bounce_height", 50e-6) == "0.00197 in"
    assert amount(100.0, "N/mm") == "571 lbf/in" and amount_text(1000.0, "MPa") == "145 ksi"
    assert amount(62.0, "g") == "62 g" and amount(30.0, "deg") == "30 deg"


@pytest.mark.parametrize(
    ("metric", "pounds"),
    [
        ("they make 51.2 of 60 N/mm", "they make 292.4 of 342.6 lbf/in"),
        ("537 to 611 N, 7240–7371 rpm", "120.7 to 137.4 lbf, 7240–7371 rpm"),
        ("coils 1 and 2 at 584 ± 226 N", "coils 1 and 2 at 131.3 ± 50.81 lbf"),
        ("from −3 to −1.5 mm", "from −0.1181 to −0.05906 in"),
        ("2e10 N/m2, 3 mm^2 and N of 3", "2e10 N/m2, 3 mm^2 and N of 3"),
    ],
)
def test_numbers_of_a_note_that_share_a_unit_are_all_converted(imperial, metric, pounds):
    """Closed form: 4.4482 N a pound; of a range only the last number was converted."""
    assert reader_text(metric) == pounds


def test_axes_of_figures_are_scaled_with_all_that_is_on_them(imperial):
    """Contract: curves, rules, ranges, numbers of ticks and maps; angles as they are."""
    angle, lift = np.array([0.0, 90.0]), np.array([0.0, 25.4])
    panel = Panel(
        "cam angle (deg)", "lift (mm), each on its own zero", (Line(angle, lift, "a", "#000"),),
        rules=(Rule("y", 12.7, "bind"), Rule("x", 45.0)), x_range=(0, 360), x_step=30, y_range=(0.0, 50.8),
        y_tick_labels=((0.0, "0"), (25.4, "25.4"), (12.7, "half")),
    )  # fmt: skip
    force = Panel("speed (rpm)", "order", (HeatMap(angle, lift, np.ones((2, 2)), "surge", "N"),))
    found = chart_for_reader(Chart("k", "t", "c", (panel, force)))
    first, second = found.panels
    assert first.y_label == "lift (in), each on its own zero" and first.x_label == panel.x_label
    assert first.layers[0].y == pytest.approx([0.0, 1.0]) and first.layers[0].x is not None
    assert [rule.value for rule in first.rules] == pytest.approx([0.5, 45.0])
    assert first.y_range == pytest.approx((0.0, 2.0)) and first.x_step == 30
    assert [text for _, text in first.y_tick_labels] == ["0", "1", "half"]
    assert second.layers[0].unit == "lbf" and second.layers[0].z[0, 0] == pytest.approx(0.2248, rel=1e-3)  # fmt: skip


def test_figures_are_untouched_in_si():
    chart = Chart("k", "t", "c", (Panel("x", "force (N)", ()),))
    assert chart_for_reader(chart) is chart


def test_a_run_is_read_in_pounds_and_saved_in_si(tmp_path):
    """Contract: terminal, sentence and page in lbf and in; JSON, CSV and the saved verdict as without."""
    texts, saved, files = {}, {}, {}
    for system in ("si", "imperial"):
        folder = tmp_path / system
        more = ["--engine-speed", "3000 rpm", "--spring", "massless", "--units", system]
        done = CliRunner().invoke(app, ["run", "job-t", *more, "--output", str(folder)])
        assert done.exit_code == 0, done.output
        texts[system] = done.stdout
        saved[system] = json.loads((folder / "run.json").read_text(encoding="utf-8"))
        page = (folder / "report.html").read_text(encoding="utf-8")
        assert ("(lbf)" in page) == (system == "imperial")
        files[system] = {
            path.name: [line for line in path.read_text(encoding="utf-8").splitlines() if line[:1] != "#"]
            for path in folder.glob("*.csv")
        }  # fmt: skip
    assert " lbf " in texts["imperial"] and " lbf" not in texts["si"]
    assert texts["imperial"].rstrip().splitlines()[-1] != texts["si"].rstrip().splitlines()[-1]
    assert saved["si"]["verdict"] == saved["imperial"]["verdict"]
    assert saved["si"]["runs"] == saved["imperial"]["runs"] if "runs" in saved["si"] else True
    assert files["si"] == files["imperial"] and files["si"]


def test_check_in_imperial_and_by_the_environment(tmp_path, monkeypatch):
    """Contract: the flag or VALVETRAIN_UNITS; JSON stays SI, its sentence too."""
    path = tmp_path / "v8.toml"
    path.write_text(template_text("pushrod"), encoding="utf-8")
    flag = CliRunner().invoke(app, ["check", str(path), "--units", "imperial"]).stdout
    plain = CliRunner().invoke(app, ["check", str(path)]).stdout
    assert "400  lbf/in" in flag and "0.0005  in/deg" in flag and "lbf" not in plain
    assert " ".join(flag.split()).endswith("0.0852 in are left to coil bind.")
    monkeypatch.setenv("VALVETRAIN_UNITS", "imperial")
    assert CliRunner().invoke(app, ["check", str(path)]).stdout == flag
    as_json = json.loads(CliRunner().invoke(app, ["check", str(path), "--json"]).stdout)
    assert as_json["quantities"]["card_rate"]["unit"] == "N/m"
    assert as_json["verdict"].endswith("2.16 mm are left to coil bind.")
    wrong = CliRunner().invoke(app, ["check", str(path), "--units", "stones"])
    assert wrong.exit_code == 2


def test_refusals_are_read_in_the_units_requested_and_quote_the_input_as_it_is(tmp_path):
    """Contract: a refusal said mm to a reader of inches; what the file says stays as written."""
    path = tmp_path / "v8.toml"
    text = template_text("pushrod").replace(
        'outer_diameter = "0.3125 in"', 'outer_diameter = "9.5 mm"'
    )
    path.write_text(text.replace('"0.080 in"', '"6 mm"', 1), encoding="utf-8")
    said = {
        units: " ".join(
            CliRunner().invoke(app, ["check", str(path), "--units", units]).stderr.split()
        )
        for units in ("si", "imperial")
    }
    assert "a wall of 6 mm does not fit into an outer diameter of 9.5 mm" in said["si"]
    assert "a wall of 0.2362 in does not fit into an outer diameter of 0.374 in" in said["imperial"]
    path.write_text(
        template_text("pushrod").replace('"60 kN/mm"', '"60 mm"'), encoding="utf-8"
    )  # of the stem
    assert "60 mm" in CliRunner().invoke(app, ["check", str(path), "--units", "imperial"]).stderr


def test_the_player_shows_pounds_and_inches():
    """Contract: forces, lift and colours of the motion stayed SI on a page in inches and pounds."""
    study = vt.simulate("job-c", "4000 rpm", spring_models=["finite-element"], workers=1)
    (plain,) = motion_data(moving_picture(study))["variants"]
    request_units("imperial")
    with for_reader():
        (read,) = motion_data(moving_picture(study))["variants"]
    request_units("si")
    assert read["units"] == {"lift": "in", "force": "lbf"} and plain["units"]["force"] == "N"

    def force(one):
        return np.frombuffer(base64.b64decode(one["forces"][0]["values"]), "<f4")

    assert force(read) * 4.4482216 == pytest.approx(force(plain), rel=1e-5)
    colours = [
        {one["key"]: one for one in found["springs"][0]["colours"]} for found in (plain, read)
    ]
    assert colours[1]["stress"]["unit"] == "ksi"
    assert colours[1]["stress"]["high"] * 6.894757 == pytest.approx(colours[0]["stress"]["high"])
