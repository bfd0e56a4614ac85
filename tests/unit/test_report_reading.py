"""Unit: the report page in the dark, and its figures as numbers, in a real browser."""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest

from synthetic_study import own_study, sweep_study, train_study
from system_parts import program
from valvetrain.report.chart import HeatMap
from valvetrain.report.page import charts, render
from valvetrain.report.study import study_page

pytestmark = pytest.mark.chromium


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        opened = driver.chromium.launch(
            executable_path=program("chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        yield opened
        opened.close()


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Name -> page and the file that it was written to."""
    folder, found = tmp_path_factory.mktemp("reading"), {}
    for name, study in {"own": own_study, "train": train_study, "sweep": sweep_study}.items():
        found[name] = page, path = study_page(study()), folder / f"{name}.html"
        path.write_text(render(page), encoding="utf-8")
    return found


def visit(browser, path, width=1400, **settings):
    """The page opened, and what went wrong on it."""
    context, wrong = (
        browser.new_context(
            viewport={"width": width, "height": 900}, accept_downloads=True, **settings
        ),
        [],
    )
    page = context.new_page()
    page.on(
        "console",
        lambda message: (
            wrong.append(message.text) if message.type in ("error", "warning") else None
        ),
    )
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.goto(path.as_uri())
    return page, wrong


def downloaded(page, key):
    """Rows of the data that the button under a figure gives."""
    button = page.locator(f'button[data-csv="{key}"]')
    page.wait_for_timeout(120)  # Chromium drops what a page saves for the eleventh time in a second
    with page.expect_download() as waiting:
        button.evaluate("button => button.click()")  # it may stand behind a tab
    path = waiting.value.path()
    assert waiting.value.suggested_filename == f"{key}.csv"
    return list(csv.reader(io.StringIO(path.read_text(encoding="utf-8-sig"))))


@pytest.mark.parametrize("name", [pytest.param("own", marks=pytest.mark.long), "sweep"])
def test_the_data_of_every_figure_are_its_lines(browser, pages, name):
    page, path = pages[name]
    seen, wrong = visit(browser, path)
    for chart in charts(page):
        heads, *rows = downloaded(seen, chart.key)
        columns = [
            np.array([float(cell) for cell in column if cell]) for column in zip(*rows, strict=True)
        ]
        at = 0
        for panel in chart.panels:
            for layer in panel.layers:
                assert layer.name in heads[at] and panel.x_label in heads[at], chart.key
                if isinstance(layer, HeatMap):
                    assert layer.unit in heads[at + 2]
                    assert columns[at + 2] == pytest.approx(
                        np.asarray(layer.z).ravel()[~np.isnan(np.asarray(layer.z).ravel())],
                        rel=1e-6,
                        abs=1e-30,
                    )
                    at += 3
                    continue
                assert panel.y_label in heads[at + 1]
                y = np.asarray(layer.y, dtype=float)
                assert columns[at + 1] == pytest.approx(y[~np.isnan(y)], rel=1e-6, abs=1e-30), (
                    chart.key,
                    layer.name,
                )
                at += 2
        assert at == len(heads)
    assert not wrong


def test_words_that_a_spreadsheet_would_calculate_are_disarmed(browser, pages):
    page, path = pages["own"]
    key = charts(page)[0].key
    seen, _ = visit(browser, path)
    seen.evaluate(
        """key => { const part = document.getElementById("data-" + key), told = JSON.parse(part.textContent);
        told.data[0].meta[0] = '=HYPERLINK("x")'; part.textContent = JSON.stringify(told); }""",
        key,
    )
    assert downloaded(seen, key)[0][0] == '\'=HYPERLINK("x")'
