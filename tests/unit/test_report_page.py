"""The report folder: complete, self-contained, readable back, whole or not at all."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from synthetic_study import COILS, modal_run, rod_run, study
from valvetrain.errors import InputError
from valvetrain.report import write
from valvetrain.report.comparison_grid import comparison_grid, comparison_table
from valvetrain.report.page import Page, Section, render, text
from valvetrain.report.spring_page import spring_page
from valvetrain.report.values import case_rows
from valvetrain.report.words import number, percent, quantity_words, unit_words
from valvetrain.report.write import write_report
from valvetrain.solution.netcdf import load_modal_result, load_netcdf, load_static_curve
from valvetrain.solution.status import Status
from valvetrain.solution.textfile import load_csv


class _Reader(HTMLParser):
    """Collects what a browser would load, link to and jump to."""

    def __init__(self) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.links: list[str] = []
        self.keys: set[str] = set()
        self.style = ""
        self.open: list[str] = []

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.open.append(tag)
        self.keys |= {values["id"]} if "id" in values else set()
        self.loads += [values[key] for key in ("src", "srcset", "data", "poster", "action") if key in values]
        self.loads += [values["href"]] if tag == "link" else []
        self.links += [values["href"]] if tag == "a" else []
        self.style += values.get("style", "")

    def handle_data(self, data):
        if self.open and self.open[-1] == "style":
            self.style += data


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    return write_report(study(), tmp_path_factory.mktemp("report"))


@pytest.fixture(scope="module")
def page(report):
    reader = _Reader()
    reader.feed(report.page.read_text(encoding="utf-8"))
    return reader


def test_page_loads_nothing_from_outside(page):
    assert [load for load in page.loads if not load.startswith("data:")] == []
    assert "url(" not in page.style and "@import" not in page.style


def test_contents_lead_to_sections(page):
    assert page.links and all(link.startswith("#") for link in page.links)
    assert {link[1:] for link in page.links} <= page.keys
    assert {"summary", "force", "spikes", "statics", "motion", "comparison", "case", "runs", "references"} <= page.keys


def test_every_figure_of_the_page_has_its_data_and_its_picture(page, report):
    drawn = {key.removeprefix("data-") for key in page.keys if key.startswith("data-")}
    assert drawn == {path.stem for path in report.figures}
    assert {"force-5600", "spikes-5600", "static", "modes", "coils-5600", "clash-5600", "nodes-5600", "energy-5600", "lift"} <= drawn


def test_page_stays_small_beside_its_library(report):
    from valvetrain.report.page import plotly_script

    assert report.page.stat().st_size - len(plotly_script().encode()) < 6e6


def test_report_files_are_read_back(report):
    names = {path.name for path in report.data}
    assert {
        "finite-element-5600rpm.nc",
        "modal-varied-5600rpm.csv",
        "static.nc",
        "static.csv",
        "modes.nc",
        "modes.csv",
        "comparison.csv",
    } <= names
    assert load_netcdf(report.folder / "finite-element-5600rpm.nc").identical(rod_run())
    few = load_csv(report.folder / "finite-element-5600rpm.csv")
    np.testing.assert_array_equal(few.channel("seat_force"), rod_run().channel("seat_force"))
    np.testing.assert_array_equal(few.channels["coil_number"], COILS)
    assert len(load_static_curve(report.folder / "static.nc").force) == 40
    assert load_modal_result(report.folder / "modes.nc").axial_modes == (1, 2, 4)
    assert not [path for path in report.folder.rglob("*") if path.name.endswith(".part")]


def test_every_published_value_is_in_the_table(report):
    lines = (report.folder / "comparison.csv").read_text().splitlines()
    published = study().case.published
    assert len(lines) == 1 + len(published)
    shown = comparison_table(study().comparisons)
    assert shown["unit"].tolist() == [value.unit for value in published]
    grid = comparison_grid(study().comparisons)
    assert sum(len(cells) > 1 for cells, _ in grid.rows) == len(published)
    assert set(grid.filters) == {"calibration", "prediction"}


def test_comparison_csv_is_in_the_units_it_names():
    rows = [row for row in comparison_table(study().comparisons).rows() if row[0] == "stage_2_peak_cam_angle" and row[1] == 5600.0]
    assert (rows[0][2], rows[0][4], rows[0][7]) == ("solid finite elements", "finite-element", "deg")
    assert (rows[0][3], rows[0][5], rows[0][6]) == pytest.approx((175.0, 180.0, 5.0))


def test_words_from_outside_are_escaped():
    strange = replace(study(), case=study().case.replace(title="<script>alert(1)</script>", description="a & <b>"))
    html = render(spring_page(strange))
    assert "<script>alert" not in html and "&lt;script&gt;alert" in html and "A note &lt;for&gt; readers." in html


def test_a_failed_run_is_said_on_top(tmp_path):
    failed = Status("diverged", "the velocity grew without bound", 0.01, "coil 2.3", "shorten the step")
    run = rod_run(status=failed)
    cut = type(run)(run.channels.isel(sample=slice(0, 900)), (), failed, {}, run.provenance)
    html = write_report(study((cut, modal_run())), tmp_path).page.read_text()
    assert "1 of 2 completed" in html
    assert "diverged: the velocity grew without bound, at time 0.01 s at coil 2.3; shorten the step" in html


@pytest.mark.parametrize("keep", [0, 1, 2, 100])
def test_runs_that_ended_at_once_do_not_break_the_report(tmp_path, keep):
    run = rod_run(status=Status("diverged", "at once"))
    short = type(run)(run.channels.isel(sample=slice(0, keep)), (), run.status, {}, run.provenance)
    assert write_report(study((short,)), tmp_path).page.exists()


def test_report_of_nothing_but_a_case(tmp_path):
    bare = replace(study(()), static_curve=None, modal_result=None, comparisons=(), notes=())
    files = write_report(bare, tmp_path)
    assert files.figures == () and "none run" in files.page.read_text()


def test_page_that_cannot_be_finished_is_not_begun(tmp_path, monkeypatch):
    def fail(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(write, "render", fail)
    with pytest.raises(KeyboardInterrupt):
        write_report(study(), tmp_path)
    assert not (tmp_path / "report.html").exists()
    assert not [path for path in tmp_path.rglob("*") if path.name.endswith(".part")]
    assert load_netcdf(tmp_path / "finite-element-5600rpm.nc").status.completed


def test_unwritable_folder_is_an_input_error(tmp_path):
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(InputError, match="cannot be written"):
        write_report(study(()), tmp_path / "taken")


def test_same_study_gives_the_same_page(report, tmp_path):
    assert write_report(study(), tmp_path).page.read_bytes() == report.page.read_bytes()


def test_a_page_without_charts_carries_no_plotting_library():
    assert len(render(Page("t", "k", "l", (), (Section("a", "A", (text("b"),)),)))) < 30_000


def test_case_values_are_shown_with_status():
    rows = {path: (value, status) for path, value, status, _ in case_rows(study().case)}
    assert rows["installation.precompression"] == ("7 mm", "published")
    assert rows["operation.engine_speeds"] == ("4200, 5600, 8000 rpm", "published")
    assert rows["spring.material"][0].startswith("OTEVA 90 SC: E 206 GPa, G 79.6 GPa")
    assert all(value for value, _ in rows.values())


@pytest.mark.parametrize(
    ("value", "shown"),
    [(289.0, "289"), (0.0, "0"), (-0.191, "−0.191"), (1.03e8, "1.03·10⁸"), (2.5e-6, "2.5·10⁻⁶"), (826.013, "826"), (None, "–")],
)
def test_numbers_as_printed(value, shown):
    assert number(value) == shown


def test_names_and_units_as_printed():
    assert quantity_words("stage_2_peak_cam_angle") == "Stage II peak, cam angle"
    assert quantity_words("coil_1_2_installed_gap") == "Installed gap of coils 1 and 2"
    assert quantity_words("stage_3_below_10_khz_peak_force") == "Stage III peak force below 10 kHz"
    assert [percent(share) for share in (-4e-4, 4e-4, -0.0123, 1.5)] == ["0.0 %", "0.0 %", "−1.2 %", "+150.0 %"]
    assert (unit_words("mm/s^2"), unit_words("us")) == ("mm/s²", "µs")


def test_no_page_text_names_a_place_on_disk(report):
    html = report.page.read_text()
    own = html[: html.index("plotly.js v")] + html[html.rindex("</script>\n<script>") :]
    assert not re.search(r"/(home|work|tmp|usr|root)/", own)


def test_a_case_of_ones_own_has_cards_and_a_table_and_speaks_of_no_published_values():
    own = replace(study(), case=study().case.replace(published=()), comparisons=())
    summary = next(section for section in spring_page(own).sections if section.key == "summary")
    cards = next(block for block in summary.blocks if block.kind == "cards")
    words = [line for card in cards.cards for line in card.lines]
    peak = next(value for key, value in own.quantities.items() if (key.name, key.label) == ("stage_2_peak_force", "finite-element"))
    assert ("Stage II peak", f"{number(peak, 4)} N", "") in words
    assert any("sampled every 0.5 cam degrees; highest instant" in note for _, _, note in words)
    grids = [block for block in summary.blocks if block.kind == "grid"]
    assert [grid.headers[0] for grid in grids] == ["statics and modes", "finite-element rod", "modal model with varied stiffness"]
    shown = {row[0].hint: row[1].words for row, _ in grids[1].rows}
    assert shown["stage_2_peak_force"] == number(peak, 4)
    figures = [block.chart for section in spring_page(own).sections for block in section.blocks if block.kind == "figure"]
    assert not [chart.key for chart in figures if "ublished values" in chart.caption or "source" in chart.caption]


def test_stage_three_heights_say_how_they_are_sampled():
    blocks = [block for section in spring_page(study()).sections for block in section.blocks]
    figures = {block.chart.key: block.chart for block in blocks if block.kind == "figure"}
    assert "samples every 0.5 cam degrees, as the source sampled. The highest instant recorded is" in figures["spikes-5600"].caption
