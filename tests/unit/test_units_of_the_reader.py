"""Units of the reader: what a person reads in inches and pounds, while files, JSON and names stay SI."""

from __future__ import annotations

import json

import pint
import plotly.graph_objects as go
import pytest
from typer.testing import CliRunner

from valvetrain.cli.main import app
from valvetrain.errors import InputError
from valvetrain.findings.words import Amount, Words
from valvetrain.parameters.loading import load_case
from valvetrain.parameters.summary import amount
from valvetrain.parameters.templates import template_text
from valvetrain.solution.definition import definition_of, shown, tables
from valvetrain.units import dimension_of, dimension_powers
from valvetrain.units.reader import (
    IMPERIAL,
    for_reader,
    reader_factor,
    reader_unit,
    request_units,
    shown_system,
)
from valvetrain.views.page import data_of
from valvetrain.views.style import in_reader_units

ROWS = [one for rows in tables().values() for one in rows if "{" not in one.name]


@pytest.fixture
def imperial():
    """Numbers are formatted in inches and pounds."""
    request_units("imperial")
    with for_reader():
        yield
    request_units("")


@pytest.mark.parametrize(
    ("metric", "name", "imperial_unit", "as_pint"),
    [
        ("N", "newton", "lbf", "force_pound"),
        ("mm", "millimeter", "in", "inch"),
        ("N/mm", "newton / millimeter", "lbf/in", "force_pound / inch"),
        ("MPa", "megapascal", "ksi", "kip_per_square_inch"),
        ("m/s", "meter / second", "ft/s", "foot / second"),
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
        request_units("")
    with for_reader():
        assert amount(250.0, "N") == "250 N"
    with pytest.raises(InputError, match="use si or imperial"):
        request_units("metric")


def test_a_run_is_read_in_pounds_and_saved_in_si(tmp_path):
    """Contract: terminal, sentence and page in lbf and in; JSON, CSV and the saved verdict as without."""
    texts, saved, files = {}, {}, {}
    for system in ("si", "imperial"):
        folder = tmp_path / system
        more = ["--rpm", "3000 rpm", "--model", "massless", "--units", system]
        done = CliRunner().invoke(app, ["run", "job-t", *more, "--output", str(folder)])
        assert done.exit_code == 0, done.output
        texts[system] = done.stdout
        saved[system] = json.loads((folder / "run.json").read_text(encoding="utf-8"))
        page = (folder / "report.html").read_text(encoding="utf-8")
        axis = data_of(page)["data-force"]["layout"]["yaxis"]["title"]["text"]
        assert axis.endswith("lbf") == (system == "imperial")
        files[system] = {
            path.name: [line for line in path.read_text(encoding="utf-8").splitlines() if line[:1] != "#"]
            for path in folder.glob("*.csv")
        }  # fmt: skip
    assert " lbf " in texts["imperial"] and " lbf" not in texts["si"]
    assert saved["si"]["findings"][0]["text"] == saved["imperial"]["findings"][0]["text"]
    assert saved["si"]["runs"] == saved["imperial"]["runs"] if "runs" in saved["si"] else True
    assert files["si"] == files["imperial"] and files["si"]


def test_a_map_of_forces_and_a_power_are_in_units_of_the_reader(imperial):
    """Contract: the map of cam orders stayed in N, and the cam power of a small engine in W."""
    bar = {"title": "N"}
    (trace,) = in_reader_units(
        go.Figure(go.Heatmap(x=[1, 2], y=[3], z=[[4.4482216, 0]], colorbar=bar))
    ).data
    assert trace.z[0][0] == pytest.approx(1) and trace.colorbar.title.text == "lbf"
    assert Words("imperial").amount(Amount("mean_cam_power", 74.569987)) == "0.1 hp"


def test_check_in_units_of_the_case_of_the_flag_and_of_the_environment(tmp_path, monkeypatch):
    """Contract: as the case is written, or by the flag or VALVETRAIN_UNITS; JSON stays SI, its sentence too."""
    path, metric = tmp_path / "v8.toml", tmp_path / "metric.toml"
    path.write_text(template_text("pushrod"), encoding="utf-8")
    metric.write_text(template_text("bucket"), encoding="utf-8")

    def check(*words):
        return CliRunner().invoke(app, ["check", *map(str, words)])

    plain, in_newton = check(path).stdout, check(path, "--units", "si").stdout
    assert "400 lbf/in" in plain and "0.5 thou/deg" in plain and "lbf" not in in_newton
    assert "--units" not in plain and "--units si" in in_newton
    assert "lbf" not in check(metric).stdout
    assert "lbf" in check(metric, "--units", "imperial").stdout
    monkeypatch.setenv("VALVETRAIN_UNITS", "imperial")
    assert "lbf" in check(metric).stdout
    as_json = json.loads(check(path, "--json").stdout)
    assert as_json["quantities"]["card_rate"]["unit"] == "N/m"
    assert as_json["findings"][0]["fields"]["left"]["value"]["unit"] == "m"
    assert check(path, "--units", "stones").exit_code == 2


def test_the_workbench_says_the_first_sentence_in_units_of_the_case():
    """Contract: a case in pounds was greeted in newtons."""
    pytest.importorskip("nicegui")
    from valvetrain.workbench.pages.case_page import first_said

    in_pounds = first_said(load_case("template:pushrod"))
    assert "lbf" in in_pounds and " N " not in in_pounds
    request_units("")
    assert "lbf" not in first_said(load_case("template:bucket"))
