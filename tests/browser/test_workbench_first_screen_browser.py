"""The first screen of the workbench in a real browser: pictures to scale, Run at once, live numbers of
control, two different runs to compare.

Evidence: what the page draws and says, against the parts of the case and the search of its worker.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest

from workbench_browser_parts import Bench, nothing_serious, open_case, opened, shown, watched

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


@pytest.mark.parametrize("width", [1400, 390])
def test_run_is_seen_at_once_and_is_a_few_keys_away(bench, width):
    """It was 62 presses of Tab away, and on a phone 1610 px down."""
    seen: list[str] = []
    page = bench.page(width, seen)
    open_case(bench, page, CASE)
    place = page.locator("#run-button").bounding_box()
    assert place["y"] + place["height"] < 500
    page.evaluate("document.querySelector('.sheet').focus()")
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")  # the link to the content
    pressed = 0
    while page.evaluate("document.activeElement.id") != "run-button":
        page.keyboard.press("Tab")
        pressed += 1
        assert pressed < 12
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
    nothing_serious(page)
    page.context.close()
    assert not seen


def number_of(page: Any, label: str) -> float:
    told = page.locator(".live .numbers div", has_text=label).first.locator("dd").inner_text()
    return float(re.match(r"[-−\d.]+", told)[0])


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


def test_a_solid_height_above_the_lift_is_refused_in_its_field(bench):
    with watched(bench) as page:
        open_case(bench, page, CASE)
        page.get_by_label("Find a quantity").fill("solid height")
        field = page.locator("[id='field-train-springs-card-0-solid_height']")
        field.fill("1.6 in")
        field.press("Enter")
        refusal = page.locator("[data-key='train.springs.card.0.solid_height'] [role=alert]")
        refusal.wait_for()
        assert "solid_height" in refusal.inner_text() and "1.15 in" in refusal.inner_text()


def test_comparing_offers_two_different_runs(bench):
    """Ctrl+Enter runs from any field; the second run differs by its preload."""
    with watched(bench) as page:
        open_case(bench, page, CASE)
        page.get_by_label("Engine speeds (crank)").fill("3000 rpm")
        page.get_by_label("Find a quantity").fill("preload")
        runs = []
        for preload in ("140 lbf", "150 lbf"):
            page.locator("[id='field-train-springs-card-0-preload']").fill(preload)
            page.keyboard.press("Control+Enter")
            page.wait_for_function(
                "(done) => { const at = document.querySelector('.results')?.dataset.shown; return at && !done.includes(at); }",
                arg=[f"/part/{run}" for run in runs],
                timeout=60_000,
            )
            runs.append(page.get_attribute(".results", "data-shown").removeprefix("/part/"))
        for query in ("", f"?a={runs[0]}", f"?a={runs[1]}", f"?b={runs[1]}"):
            page.goto(f"{bench.url}/compare{query}")
            chosen = {page.input_value("#run-a"), page.input_value("#run-b")}
            assert chosen == set(runs), query
        page.goto(f"{bench.url}/run/{runs[0]}")
        shown(page)
        verdict = page.locator(".verdict")
        assert verdict.count() == 1 and "coil bind" in verdict.inner_text()
        assert verdict.bounding_box()["y"] < 200, "first on its page"


def test_a_study_varies_about_the_value_of_the_case_and_is_not_offered_to_compare(bench):
    """Half to one and a half times a duration is no cam: seven of nine points failed, named by their key."""
    with watched(bench) as page:
        open_case(bench, page, CASE)
        page.get_by_label("Study of a quantity").check()
        page.get_by_label("Quantity varied").select_option("train.valve.mass")
        low, high = (float(page.input_value(f"#study-{end}").split()[0]) for end in ("low", "high"))
        assert high / low == pytest.approx(1.5, rel=0.01)
        page.locator("#study-points").fill("3")
        page.locator("#model-massless").check()
        page.locator("#run-button").click()
        page.wait_for_function(
            "document.querySelector('.newest strong')?.textContent.includes('mass')",
            timeout=120_000,
        )
        assert "train.valve.mass" not in page.inner_text(".newest")
        page.goto(f"{bench.url}/compare")
        offered = page.locator("#run-a option").all_inner_texts()
        assert not [one for one in offered if "study" in one]
