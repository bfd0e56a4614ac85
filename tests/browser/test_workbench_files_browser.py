"""Files beside a case, spring sets and tests over a run in a real browser: what a user sends,
chooses and removes.

Evidence: what the page shows is compared with the files of the workspace and of the kept run;
accessibility by axe-core.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from valvetrain.measured.cycles import MeasuredCycles, write_cycles
from valvetrain.workbench.workspace import Workspace
from workbench_browser_parts import Bench, nothing_serious, open_case, opened, shown, watched
from workbench_parts import kept, page_with

pytestmark = pytest.mark.chromium

TRAIN = "tdi-pushrod"


@pytest.fixture(scope="module")
def bench(tmp_path_factory) -> Iterator[Bench]:
    folder = tmp_path_factory.mktemp("workspace")
    Workspace(folder).new_case(TRAIN, TRAIN)
    with opened(folder) as made:
        yield made


@pytest.fixture
def page(bench) -> Iterator[Any]:
    """A wide page of which nothing may go wrong."""
    with watched(bench) as made:
        yield made


@pytest.fixture(scope="module")
def finished(bench) -> str:
    """A run of the second spring set, chosen on the page; the run's id."""
    with watched(bench) as page:
        open_case(bench, page, TRAIN)
        for box in page.locator(".models input:checked").all():
            box.uncheck()
        page.locator("#models-massless").check()
        page.get_by_label("stock", exact=True).uncheck()
        page.wait_for_function(
            "document.getElementById('order-refusal').textContent.includes('o spring sets are chosen')"
        )
        page.get_by_label("performance", exact=True).check()
        page.get_by_label("Engine speeds (crank)").fill("3000 rpm")
        page.get_by_role("button", name="Run", exact=True).click()
        shown(page)
        return str(page.get_attribute(".results", "data-shown")).removeprefix("/part/")


def test_the_chosen_spring_set_runs_and_is_remembered(bench, page, finished):
    answer = bench.answer(finished)
    assert answer["choices"]["spring_sets"] == ["performance"]
    assert {run["spring_set"] for run in answer["runs"]} == {"performance"}
    page.goto(f"{bench.url}/run/{finished}")
    assert "performance" in page.locator("h1 ~ .said, .split ~ .said").first.inner_text()
    open_case(bench, page, TRAIN)
    assert (
        page.get_by_label("performance", exact=True).is_checked()
        and not page.get_by_label("stock", exact=True).is_checked()
    )


def test_branches_of_motion_are_marched_and_drawn(bench, page, finished):
    open_case(bench, page, TRAIN)
    page.locator("#kind-branches").check()
    page.get_by_label("Engine speeds (crank)").fill("3000:3100:50 rpm")
    page.get_by_role("button", name="Run", exact=True).click()
    shown(page)
    page.wait_for_function(
        "Array.from(document.querySelectorAll('.plot')).some((plot) => plot._fullData?.some((one) => one.name === 'stable, falling'))"
    )


def level(folder: Path, name: str, mean: float) -> Path:
    """A test that is made up: a level with two repeats 7 N above and below it, so its mean is
    known.
    """
    angle = np.linspace(0.0, 2 * np.pi, 90, endpoint=False)
    values = mean + np.outer([7.0, -7.0], np.ones(90))
    return write_cycles(
        folder / name,
        MeasuredCycles("seat_force", "N", angle, values, 50 * np.pi, synthetic=True),
    )


#: Whether a line of a figure is at a value; figures are drawn when they come into view.
DRAWN = (
    "(value) => Array.from(document.querySelectorAll('.plot'), (plot) => Array.from(plot._fullData ?? [])).flat()"
    ".some((trace) => trace.y?.length && Array.from(trace.y).slice(0, 5).every((one) => Math.abs(one - value) < 1e-3))"
)


def drawn(page: Any, value: float) -> bool:
    """Whether a line of a figure comes to be at ``value``, with the comparison in view."""
    page.locator("#test-opening").scroll_into_view_if_needed()
    page.wait_for_function(DRAWN, arg=value, timeout=30_000)
    return True


def test_a_test_over_a_run_outlives_a_reload_and_is_removed(bench, page, finished, tmp_path):
    page.goto(f"{bench.url}/run/{finished}")
    page.set_input_files("#test-file", str(level(tmp_path, "first-test.csv", 500.0)))
    page.wait_for_selector("#test-opening", timeout=30_000)
    page.reload()
    page.wait_for_selector("#test-opening", timeout=30_000)
    assert drawn(page, 500.0)
    page.set_input_files("#test-file", str(level(tmp_path, "second.csv", 600.0)))
    page.wait_for_selector("[aria-label='Show second.csv'][aria-pressed=true]")
    page.get_by_role("button", name="Show first-test.csv").click()
    page.wait_for_selector("[aria-label='Show first-test.csv'][aria-pressed=true]")
    folder = bench.folder / "runs" / finished / "laid-over"
    assert {path.name for path in folder.iterdir()} == {"first-test.csv", "second.csv"}
    page.set_viewport_size({"width": 390, "height": 900})
    nothing_serious(page)
    for name in ("first-test.csv", "second.csv"):
        page.get_by_role("button", name=f"Remove {name}").click()
        page.get_by_role("button", name=f"Remove {name}").wait_for(state="detached")
    page.wait_for_selector("#test-opening", state="detached")
    assert not folder.exists()


#: Words of somebody else, which would run a script wherever they are taken for HTML.
STRANGE = """<script>document.title = "taken"</script><img src="/none" onerror="document.title = 'taken'"><svg
onload="document.title = 'taken'"></svg>"""


def test_the_report_of_a_stranger_runs_nothing(bench):
    """Every text of it stays a text, on a page and opened by itself; the browser says so here."""
    verdict = {"code": STRANGE, "mark": "", "text": STRANGE, "reason": STRANGE}
    table = {"title": STRANGE, "columns": [STRANGE], "rows": [[STRANGE]]}
    figure = {"title": STRANGE, "hint": STRANGE, "height": 300}
    drawn = {"title": {"text": STRANGE}, "margin": {"l": 40}, "height": 300}
    texts = {
        "next_step": STRANGE, "verdict": verdict, "lines": [{"mark": "", "label": STRANGE, "cells": [STRANGE], "remark": STRANGE}],
        "bullets": [{"mark": "", "text": STRANGE}], "rests_on": [STRANGE], "figures": {"force": figure}, "tables": {"a": table},
        "computed": [STRANGE], "text": STRANGE, "gaps": [STRANGE],
    }  # fmt: skip
    line = {"type": "scatter", "x": [1, 2], "y": [1, 2], "name": STRANGE}
    page = page_with(texts, {"data-force": {"data": [line], "layout": drawn, "narrow": drawn}})
    run = kept(Workspace(bench.folder), TRAIN, report_html=page)
    page = bench.page()
    for place in ("part", "run"):
        page.goto(f"{bench.url}/{place}/{run}", wait_until="load")
        page.wait_for_timeout(500)
        assert page.title() != "taken", place
    shown(page)
    page.wait_for_selector("#fig-force .main-svg")
    assert page.title() != "taken"
    page.context.close()
