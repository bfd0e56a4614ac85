"""The workbench in a real browser: from the first visit to a finished run, refusals in place,
cancel, reload, comparison, downloads.

Evidence: what the page shows is compared with the files of the kept run; accessibility by axe-core;
the browser's own console and requests.
"""

from __future__ import annotations

import os
import re
import tomllib
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from valvetrain.views.page import data_of
from workbench_browser_parts import (
    CASE,
    Bench,
    nothing_serious,
    open_case,
    opened,
    shown,
    watched,
)

pytestmark = pytest.mark.chromium

LONG = os.environ.get("VALVETRAIN_LONG") == "1"


@pytest.fixture(scope="module")
def bench(tmp_path_factory) -> Iterator[Bench]:
    with opened(tmp_path_factory.mktemp("workspace")) as made:
        yield made


@pytest.fixture
def page(bench) -> Iterator[Any]:
    """A wide page of which nothing may go wrong."""
    with watched(bench) as made:
        yield made


@pytest.fixture(scope="module")
def finished(bench) -> str:
    """From the first page to a finished run of the main case; the run's id."""
    seen: list[str] = []
    page = bench.page(seen=seen)
    page.goto(bench.url)
    page.locator("[data-source=gu2021-beehive-blind]").click()
    page.wait_for_url(f"**/case/{CASE}")
    page.get_by_label("Engine speeds (crank)").fill("4200 rpm")
    if LONG:
        page.locator("#models-finite-element").check()
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_selector(".results[data-shown]", timeout=600_000 if LONG else 60_000)
    run = page.get_attribute(".results", "data-shown").removeprefix("/part/")
    assert page.locator(".run-head").count() == 1
    assert (
        page.get_by_role("link", name="Open on its own page").get_attribute("href") == f"/run/{run}"
    )
    page.context.close()
    assert not seen
    return run


def test_a_finished_run_shows_the_numbers_of_its_files(bench, page, finished):
    page.goto(f"{bench.url}/run/{finished}")
    shown(page)
    told = (
        page.locator("#table-numbers tr", has_text="peak spring force below 10 kHz, N")
        .first.locator("td")
        .first.text_content()
    )
    runs = {run["label"]: run for run in bench.answer(finished)["runs"]}
    assert float(told) == pytest.approx(
        runs["multi-mass"]["quantities"]["peak_spring_force"]["value"], rel=1e-3
    )
    assert ("finite-element" in runs) is LONG
    page.locator("summary", has_text="Gaps between coils").click()
    page.wait_for_selector("#at-coils .plot .main-svg")
    assert page.locator("#at-coils .plot .scatterlayer .trace").count() > 1


def test_a_wrong_unit_is_refused_in_its_place_and_the_valid_value_kept(bench, page, finished):
    open_case(bench, page)
    field = page.get_by_label("Wire diameter", exact=True)
    before = field.input_value()
    field.fill("3.8 furlong")
    field.press("Enter")
    refusal = page.locator("[data-key='spring.wire_diameter'] [role=alert]")
    refusal.wait_for()
    assert "furlong" in refusal.inner_text() and before in refusal.inner_text()
    assert field.get_attribute("aria-invalid") == "true"
    assert bench.case()["spring"]["wire_diameter"]["value"] == before
    field.press("Escape")
    refusal.wait_for(state="detached")
    assert field.input_value() == before


def test_a_page_at_rest_asks_nothing(bench, page, finished):
    """Each answer brought the list of quantities anew, which asked for the next estimate: four
    messages a second without end.
    """
    sent = []
    page.on("websocket", lambda line: line.on("framesent", lambda frame: sent.append(str(frame))))
    open_case(bench, page)
    events, quiet, longest = 0, 0, 240
    for _ in range(longest):  # a busy machine may take seconds to open it
        page.wait_for_timeout(250)
        asked = sum("event" in frame for frame in sent)
        quiet, events = quiet + 1 if 0 < asked == events else 0, asked
        if quiet == 6:
            break
    assert quiet == 6, (
        f"{events} messages in {longest / 4:g} s, and never one and a half without one"
    )


def test_what_is_being_typed_outlives_the_answer_to_the_field_before(bench, page, finished):
    open_case(bench, page)
    page.locator("summary", has_text="Spring: damping").click()
    first, second = (
        page.get_by_label("Ratio", exact=True),
        page.get_by_label("Ratio frequency", exact=True),
    )
    first.fill("0.017")
    first.press("Tab")  # sets it; its answer comes while the next field is typed in
    second.press_sequentially("64", delay=5)
    page.wait_for_timeout(700)
    assert bench.case()["spring"]["damping"]["ratio"] == 0.017
    assert "64" in second.input_value()
    second.press("Escape")
    first.fill("0.016")
    first.press("Enter")
    page.wait_for_timeout(300)


def test_a_reload_and_another_tab_find_the_job_which_is_then_cancelled(bench, page, finished):
    open_case(bench, page)
    page.locator("#models-multi-mass").uncheck()
    page.locator("#models-finite-element").check()
    page.get_by_label("Engine speeds (crank)").fill("4200, 5600, 8000 rpm")
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_selector(".job progress")
    page.reload()
    page.wait_for_selector(".job progress")
    other = bench.page(seen=[])
    open_case(bench, other)
    other.wait_for_selector(".job progress")
    assert other.get_by_role("button", name="Running").is_disabled()
    other.get_by_role("button", name="Cancel").click()
    for one in (page, other):
        one.wait_for_selector(".job[data-state=cancelled]", timeout=30_000)
    assert page.get_by_role("button", name="Run it again").is_visible()
    other.context.close()


def test_the_slider_moves_the_curve_and_its_value_can_be_kept(bench, page, finished):
    open_case(bench, page)
    page.select_option("#live-quantity", "spring.precompression")
    page.wait_for_selector(".live .numbers", timeout=60_000)
    slider = page.locator("#live-slider")
    slider.focus()
    slider.press("End")
    page.wait_for_function(
        "document.querySelector('.live .numbers').textContent.includes('+')", timeout=30_000
    )
    assert page.locator(".live .plot .scatterlayer .trace").count() == 2
    page.get_by_role("button", name="Keep this value").click()
    page.wait_for_function(
        "document.getElementById('field-spring-precompression').value === '10.4 mm'"
    )
    assert bench.case()["spring"]["precompression"] == "10.4 mm"
    field = page.get_by_label("Precompression", exact=True)
    field.fill("7 mm")
    field.press("Enter")
    page.wait_for_function("document.getElementById('live-value').value === '7'")


def test_two_runs_are_compared(bench, page, finished):
    open_case(bench, page)
    shown(page)
    field = page.get_by_label("Wire diameter", exact=True)
    field.fill("3.9 mm")
    field.press("Enter")
    for box in page.locator(".models input:checked").all():
        box.uncheck()
    page.locator("#models-multi-mass").check()
    page.get_by_label("Engine speeds (crank)").fill("4200 rpm")
    page.get_by_role("button", name="Run", exact=True).click()
    page.wait_for_function(
        f"!document.querySelector('.results').dataset.shown.includes('{finished}')", timeout=60_000
    )
    other = page.get_attribute(".results", "data-shown").removeprefix("/part/")
    page.goto(f"{bench.url}/compare?a={finished}&b={other}")
    shown(page)
    rows = {
        row.locator("td").first.text_content(): row.text_content()
        for row in page.locator("#table-inputs tbody tr").all()
    }
    assert "spring.wire_diameter" in rows and "3.9 mm" in rows["spring.wire_diameter"]
    assert page.locator("#table-results tbody tr").count() > 5
    page.locator("#at-force > details").evaluate_all(
        "(folds) => folds.forEach((one) => { one.open = true; })"
    )
    page.wait_for_selector("#fig-force .scatterlayer .trace")
    assert page.locator("#fig-force .scatterlayer .trace").count() >= 2


def test_files_of_a_run_are_handed_out(bench, page, finished, tmp_path):
    page.goto(f"{bench.url}/run/{finished}")
    paths = {}
    for words in ("Report (HTML)", "All data", "Tables (CSV)", "Case file"):
        with page.expect_download() as waited:
            page.get_by_role("link", name=words).click()
        paths[words] = tmp_path / waited.value.suggested_filename
        waited.value.save_as(paths[words])
    assert "data-force" in data_of(paths["Report (HTML)"].read_text("utf-8"))
    names = zipfile.ZipFile(paths["All data"]).namelist()
    assert any(name.endswith("run.json") for name in names) and any(
        name.endswith(".nc") for name in names
    )
    assert {Path(name).suffix for name in zipfile.ZipFile(paths["Tables (CSV)"]).namelist()} == {
        ".csv"
    }
    assert (
        tomllib.loads(paths["Case file"].read_text("utf-8"))["spring"]["wire_diameter"]["value"]
        == "3.7709 mm"
    )


def test_a_file_that_is_no_case_is_refused_and_a_case_opens(bench, page, tmp_path):
    page.goto(bench.url)
    wrong = tmp_path / "notes.toml"
    wrong.write_bytes(b"[spring]\nwire_diameter = \xff\xfe")
    page.set_input_files("#case-file", str(wrong))
    page.get_by_role("alert").wait_for()
    assert "text" in page.get_by_role("alert").inner_text()
    mine = tmp_path / "mine.toml"
    mine.write_text(
        '[spring]\npreload = "250 N"\nrate = "32 N/mm"\nmass = "42 g"\n', encoding="utf-8"
    )
    page.set_input_files("#case-file", str(mine))
    page.wait_for_url("**/case/mine")
    assert page.get_by_label("Preload", exact=True).input_value() == "250 N"


def test_all_is_done_by_the_keyboard(bench, page, finished):
    page.goto(bench.url)
    page.wait_for_selector("ul.cases button")
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.textContent") == "Skip to the content"
    page.keyboard.press("Enter")
    for _ in range(40):
        page.keyboard.press("Tab")
        if "A spring alone" in page.evaluate("document.activeElement.textContent"):
            break
    outline = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
    assert outline == "solid"
    page.keyboard.press("Enter")
    page.wait_for_url("**/case/my-spring")
    page.wait_for_selector(".form")
    page.locator("#find-quantity").focus()
    page.keyboard.type("wire dia")
    page.wait_for_function("document.getElementById('found-quantities').textContent === '1 value'")
    page.keyboard.press("Tab")
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.id") == "field-spring-wire_diameter"
    page.keyboard.press("Control+A")
    page.keyboard.type("4 m")
    page.keyboard.press("Enter")
    page.locator("[data-key='spring.wire_diameter'] [role=alert]").wait_for()
    page.keyboard.press("Escape")
    for _ in range(60):
        if page.evaluate("document.activeElement.id") == "run-button":
            break
        page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.id") == "run-button"
    page.goto(f"{bench.url}/run/{finished}")
    shown(page)
    page.locator("#computed summary").focus()
    page.keyboard.press("Enter")
    assert page.locator("#computed details").evaluate("(fold) => fold.open")


PLACES = ("/", "/runs", "/case/CASE", "/run/RUN", "/compare?a=RUN&b=RUN", "/case/none")


@pytest.mark.parametrize("width", [1400, 390] if LONG else [390])
def test_nothing_is_cut_off_and_axe_finds_nothing_serious(bench, finished, width):
    seen: list[str] = []
    page = bench.page(width, seen)
    for place in PLACES:
        page.goto(bench.url + place.replace("CASE", CASE).replace("RUN", finished))
        page.wait_for_selector(".sheet h1")
        if place.startswith(("/case/CASE", "/run/")):
            shown(page)
            page.locator(".results .plot").first.scroll_into_view_if_needed()
            page.wait_for_selector(".results .plot .main-svg", state="attached")
        nothing_serious(page)
    page.context.close()
    assert [line for line in seen if "404" not in line] == []


def test_every_page_carries_the_policy_and_asks_nothing_of_the_network(bench, page, finished):
    for place in ("/", f"/run/{finished}"):
        answer = page.goto(bench.url + place)
        assert re.search(
            r"default-src 'self'", answer.headers.get("content-security-policy", "")
        ), place
        assert (
            "http:" not in answer.headers["content-security-policy"]
            and "https:" not in answer.headers["content-security-policy"]
        )
