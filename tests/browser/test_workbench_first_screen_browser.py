"""The first screen of the workbench in a real browser: pictures to scale, Run at once, live numbers of
control, tables and laws without TOML.

Evidence: what the page draws and says, against the parts of the case and the search of its worker.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest

from workbench_browser_parts import Bench, open_case, opened, watched

pytestmark = pytest.mark.chromium
CASE = "my-pushrod"
PRELOAD = "train.springs.card.0.preload"


@pytest.fixture(scope="module")
def bench(tmp_path_factory) -> Iterator[Bench]:
    with opened(tmp_path_factory.mktemp("first-screen")) as made:
        yield made


@pytest.fixture(scope="module", autouse=True)
def case(bench) -> None:
    """A case of the pushrod template, made from its card."""
    with watched(bench) as page:
        page.goto(bench.url)
        page.get_by_role("button", name="A pushrod and rocker").click()
        page.wait_for_url(f"**/case/{CASE}")


def number_of(page: Any, label: str) -> float:
    told = page.locator(".live .numbers div", has_text=label).first.locator("dd").inner_text()
    return float(re.match(r"[-−\d.]+", told)[0])


def test_a_case_that_has_not_run_opens_with_what_check_says(bench):
    """Above the forms, and after a change what is in doubt of the changed case."""
    with watched(bench) as page:
        open_case(bench, page, CASE)
        said = page.locator(".newest strong", has_text="ready to run")
        said.wait_for(timeout=60_000)
        assert said.bounding_box()["y"] < page.locator(".inputs").bounding_box()["y"]
        page.evaluate(
            "document.querySelectorAll('.inputs details').forEach(one => one.open = true)"
        )
        page.fill("#field-operation-red_line", "9500 rpm")
        page.keyboard.press("Enter")
        short = page.locator(".newest strong", has_text="short at")
        short.wait_for(timeout=60_000)
        page.get_by_role("button", name="Undo the last change").click()
        said.wait_for(timeout=60_000)


def test_a_table_is_added_the_law_changed_and_both_are_taken_back(bench):
    """Without TOML: a spring inside the first, another kind of lift law; the file says so each time."""
    with watched(bench) as page:
        open_case(bench, page, CASE)
        before = bench.case(CASE)
        page.select_option("#field-lift_law-kind", "polynomial")
        page.wait_for_function("document.getElementById('field-lift_law-maximum_lift')?.value")
        made = bench.case(CASE)
        assert made["lift_law"]["maximum_lift"]["status"] == "assumed"
        ratio = before["lift_law"]["rocker_ratio"]
        assert "ratio" not in before["train"]["lever"] and made["train"]["lever"]["ratio"] == ratio
        page.locator("summary", has_text="Add to the case").click()
        page.get_by_role("button", name="Add: Second spring card").click()
        page.wait_for_function("document.activeElement.id === 'field-train-springs-card-1-name'")
        assert len(bench.case(CASE)["train"]["springs"]["card"]) == 2
        page.get_by_role("button", name="Undo the last change").click()
        page.locator("#field-train-springs-card-1-name").wait_for(state="detached")
        page.get_by_role("button", name="Undo the last change").click()
        page.wait_for_function(
            "document.getElementById('field-lift_law-kind').value === 'cam-card'"
        )
        assert bench.case(CASE) == before
        page.get_by_role("button", name="Undo the last change").wait_for(state="hidden")


def test_float_cam_force_and_margin_follow_the_slider(bench):
    """More preload on a spring of one open load leaves more margin; fifteen presses are felt."""
    with watched(bench) as page:
        open_case(bench, page, CASE)
        page.select_option("#live-quantity", PRELOAD)
        page.wait_for_selector(".live .numbers", timeout=60_000)
        margin = number_of(page, "Minimum spring margin")
        assert "Minimum cam contact force" in page.inner_text(".live .numbers")
        assert "computing" in page.inner_text(".live .numbers")
        page.locator("#live-slider").focus()
        before = float(page.input_value("#live-value"))
        for _ in range(5):
            page.keyboard.press("ArrowRight")
        assert float(page.input_value("#live-value")) >= 1.1 * before
        page.wait_for_function(
            "document.querySelector('.live .numbers').textContent.includes('(+')", timeout=30_000
        )
        assert number_of(page, "Minimum spring margin") > margin
        page.wait_for_function(
            "/Float speed, about\\s*\\d{4} rpm/.test(document.querySelector('.live .numbers').textContent)",
            timeout=60_000,
        )
        assert 6000 < number_of(page, "Float speed, about") < 9000
