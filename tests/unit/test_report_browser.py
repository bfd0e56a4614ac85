"""The report page in a real browser: every chart is drawn, nothing goes wrong, nothing is asked of the network."""

from __future__ import annotations

import json
import re
import subprocess
from html import unescape
from pathlib import Path

import numpy as np
import pytest

from synthetic_study import modal_run, rod_run, study
from system_parts import program
from valvetrain.report.write import write_report

pytestmark = pytest.mark.chromium

#: Stands first in the page: refuses every request that would leave it, and keeps what goes wrong.
WATCH = """
<meta http-equiv="Content-Security-Policy"
 content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:">
<script>
const seen = {refused: [], errors: []};
document.addEventListener("securitypolicyviolation", (event) => seen.refused.push(event.blockedURI));
window.addEventListener("error", (event) => seen.errors.push(String(event.message)));
window.addEventListener("unhandledrejection", (event) => seen.errors.push(String(event.reason)));
</script>
"""
#: Stands last: opens every tab, as a reader would, then writes down what was seen.
ASK = """
<script>
window.addEventListener("load", () => setTimeout(() => {
  document.querySelectorAll("[role=tab]").forEach((tab) => tab.click());
  setTimeout(() => {
    seen.loaded = performance.getEntriesByType("resource").map((entry) => entry.name).filter((name) => !/^(data|blob):/.test(name));
    seen.charts = Object.fromEntries(Array.from(document.querySelectorAll(".plot[data-chart]"), (box) => [box.dataset.chart, {
      traces: box.querySelectorAll(".main-svg .scatterlayer .trace, .main-svg .heatmaplayer .hm, .main-svg .cartesianlayer .trace").length,
      ink: Array.from(box.querySelectorAll(".main-svg path")).filter((path) => (path.getAttribute("d") || "").length > 20).length,
    }]));
    const note = document.body.appendChild(document.createElement("pre"));
    note.id = "seen";
    note.textContent = JSON.stringify(seen);
  }, 2000);
}, 500));
</script>
"""


def browse(html: str, folder: Path) -> tuple[dict, list[str]]:
    """What a page has seen once loaded, and what it wrote to the console."""
    page = folder / "page.html"
    page.write_text(html.replace("<head>", f"<head>{WATCH}", 1).replace("</body>\n</html>", f"{ASK}</body>\n</html>"), encoding="utf-8")
    browser = program("chromium")
    assert browser
    command = [
        browser, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-sync",
        "--disable-component-update", "--disable-extensions", f"--user-data-dir={folder / 'profile'}", "--window-size=1400,24000",
        "--virtual-time-budget=20000", "--enable-logging=stderr", "--v=0", "--dump-dom", page.as_uri(),
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    note = re.search(r'<pre id="seen">(.*?)</pre>', done.stdout, re.DOTALL)
    assert note, f"the page did not come to its end:\n{done.stderr[-2000:]}"
    return json.loads(unescape(note[1])), re.findall(r":CONSOLE[^\]]*\] (.*)", done.stderr)


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    runs = (rod_run(), rod_run(4200 * np.pi / 30), modal_run(), modal_run(4200 * np.pi / 30))
    return write_report(study(runs), tmp_path_factory.mktemp("report"))


@pytest.fixture(scope="module")
def visit(report, tmp_path_factory):
    return browse(report.page.read_text(encoding="utf-8"), tmp_path_factory.mktemp("browser"))


def test_every_chart_is_drawn(visit, report):
    charts = visit[0]["charts"]
    assert {path.stem for path in report.figures} == set(charts)
    assert {"force-4200", "force-5600"} <= set(charts)
    assert not {key: drawn for key, drawn in charts.items() if not (drawn["traces"] and drawn["ink"])}


def test_nothing_goes_wrong_and_nothing_is_written_to_the_console(visit):
    seen, console = visit
    assert seen["errors"] == [] and console == []


def test_no_request_leaves_the_page(visit):
    assert visit[0]["refused"] == [] and visit[0]["loaded"] == []


@pytest.mark.parametrize(
    ("body", "kind"),
    [
        ("<script>fetch('https://example.invalid/a')</script>", "refused"),
        ("<img src='https://example.invalid/a.png'>", "refused"),
        ("<script>lost()</script>", "errors"),
        ("<div class='plot' data-chart='empty'></div><script>console.error('no')</script>", "console"),
    ],
)
def test_the_watch_catches_what_it_should(body, kind, tmp_path):
    seen, console = browse(f"<!DOCTYPE html>\n<html>\n<head></head>\n<body>{body}</body>\n</html>", tmp_path)
    assert console if kind == "console" else seen[kind]
    assert seen["charts"] in ({}, {"empty": {"traces": 0, "ink": 0}})
