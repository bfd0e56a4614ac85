"""The documentation site builds without a warning, opens from files alone and fits a narrow page; a
minute, so with ``make test-long``.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from system_parts import program

ROOT = Path(__file__).resolve().parents[2]
#: An element of a page that fetches what it names.
FETCHED = re.compile(
    r"<(?:script|img|iframe|source|video|audio|link(?=[^>]*rel=\"(?:stylesheet|preload|icon)))[^>]*(?:src|href)=\"(?:https?:)?//[^\"]*"
)
STYLED = re.compile(r"(?:url\(|@import )\s*['\"]?(?:https?:)?//")
LOOKED_AT = (
    "index",
    "tutorial",
    "gallery/index",
    "gallery/g03_chain_and_rod",
    "theory/rod",
    "api/contact",
    "commands",
    "quantities",
    "how-to/README",
)

pytestmark = [pytest.mark.long]


@pytest.fixture(scope="module")
def site() -> Path:
    """The site as ``make docs`` builds it."""
    command = [
        "-m",
        "sphinx",
        "-b",
        "html",
        "-n",
        "-W",
        "--keep-going",
        "-q",
        "-d",
        "build/doctrees",
        "docs",
        "build/docs",
    ]
    paths = {"PYTHONPATH": str(ROOT / "src")}
    done = subprocess.run(
        [sys.executable, *command],
        cwd=ROOT,
        capture_output=True,
        text=True,
        env={**os.environ, **paths},
    )
    assert done.returncode == 0, done.stderr[-4000:]
    return ROOT / "build" / "docs"


def test_no_page_fetches_anything_from_elsewhere(site):
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 100
    assert not [
        (page.name, found)
        for page in pages
        for found in FETCHED.findall(page.read_text(encoding="utf-8"))
    ]
    styles = [
        path for path in site.rglob("*.css") if STYLED.search(path.read_text(encoding="utf-8"))
    ]
    assert not styles


def watch(page, found: list[str]) -> None:
    """Keep what goes wrong on a page, and what it asks of the network."""
    page.on(
        "console", lambda message: found.append(message.text) if message.type == "error" else None
    )
    page.on("pageerror", lambda error: found.append(str(error)))
    page.on(
        "request",
        lambda request: (
            found.append(request.url) if not re.match("file:|data:|blob:", request.url) else None
        ),
    )


@pytest.mark.chromium
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_pages_have_no_serious_finding_of_axe(site, scheme):
    from axe_playwright_python.sync_playwright import Axe
    from playwright.sync_api import sync_playwright

    found = []
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=program("chromium"), args=["--no-sandbox"])
        page = browser.new_context(
            viewport={"width": 1400, "height": 1000}, color_scheme=scheme
        ).new_page()
        for name in LOOKED_AT:
            page.goto(f"file://{site / name}.html")
            told = Axe().run(page).response["violations"]
            found += [
                (name, one["id"], one["nodes"][0]["html"][:200])
                for one in told
                if one["impact"] in ("serious", "critical")
            ]
        browser.close()
    assert not found


@pytest.mark.chromium
@pytest.mark.parametrize("width", [1400, 390])
def test_pages_open_without_a_network_and_fit(site, width):
    from playwright.sync_api import sync_playwright

    found: list[str] = []
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=program("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": width, "height": 900})
        watch(page, found)
        for name in LOOKED_AT:
            page.goto(f"file://{site / name}.html")
            over = page.evaluate("document.documentElement.scrollWidth - window.innerWidth")
            found += [f"{name} is {over} px too wide"] if over > 1 else []
        page.goto(f"file://{site}/gallery/g03_chain_and_rod.html")
        page.wait_for_selector(".figure-place .main-svg", timeout=20_000)
        page.goto(f"file://{site}/search.html?q=coil+clash")
        page.wait_for_selector("#search-results li a", timeout=20_000)
        browser.close()
    assert not found
