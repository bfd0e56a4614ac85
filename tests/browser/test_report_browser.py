"""The report page in a real browser: every chart is drawn, nothing goes wrong, nothing is asked of
the network.
"""

from __future__ import annotations

import json
import re
import subprocess
from html import unescape
from pathlib import Path

import pytest

from synthetic_study import own_study, published_study, sweep_study, train_study
from system_parts import program
from valvetrain.views.answer import Answer
from valvetrain.views.page import data_of, page_of
from valvetrain.views.results import figures_of, write_figures

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
#: Stands last: opens every tab and every detail, as a reader would, then writes down what was seen.
ASK = """
<script>
window.addEventListener("load", () => setTimeout(() => {
  document.querySelectorAll("details").forEach((part) => { part.open = true; });
  // A loaded machine may show no frame in virtual time, so figures are asked for as for print.
  window.dispatchEvent(new Event("beforeprint"));
  document.querySelectorAll("[role=tab]").forEach((tab) => tab.click());
  setTimeout(() => {
    seen.loaded = performance.getEntriesByType("resource").map((entry) => entry.name).filter((name) => !/^(data|blob):/.test(name));
    seen.charts = Object.fromEntries(Array.from(document.querySelectorAll(".plot[data-chart]"), (box) => [box.dataset.chart, {
      traces: box.querySelectorAll(".main-svg .scatterlayer .trace, .main-svg .heatmaplayer .hm, .main-svg .cartesianlayer .trace").length,
      ink: Array.from(box.querySelectorAll(".main-svg path")).filter((path) => (path.getAttribute("d") || "").length > 20).length
        + box.querySelectorAll(".heatmaplayer image").length,
    }]));
    const note = document.body.appendChild(document.createElement("pre"));
    note.id = "seen";
    note.textContent = JSON.stringify(seen);
  }, 2500);
}, 500));
</script>
"""


def browse(html: str, folder: Path) -> tuple[dict, list[str]]:
    """What a page has seen once loaded, and what it wrote to the console."""
    page = folder / "page.html"
    page.write_text(
        html.replace("<head>", f"<head>{WATCH}", 1).replace(
            "</body>\n</html>", f"{ASK}</body>\n</html>"
        ),
        encoding="utf-8",
    )
    browser = program("chromium")
    assert browser
    command = [
        browser, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-sync",
        "--disable-component-update", "--disable-extensions", "--hide-scrollbars", f"--user-data-dir={folder / 'profile'}",
        "--window-size=1400,24000", "--virtual-time-budget=20000", "--enable-logging=stderr", "--v=0", "--dump-dom",
        page.as_uri(),
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    note = re.search(r'<pre id="seen">(.*?)</pre>', done.stdout, re.DOTALL)
    assert note, f"the page did not come to its end:\n{done.stderr[-2000:]}"
    return json.loads(unescape(note[1])), re.findall(r":CONSOLE[^\]]*\] (.*)", done.stderr)


STUDIES = {
    "own": own_study,
    "published": published_study,
    "train": train_study,
    "sweep": sweep_study,
}


@pytest.fixture(scope="module", params=STUDIES)
def answered(request, tmp_path_factory):
    text = page_of(Answer(STUDIES[request.param]()))
    return text, *browse(text, tmp_path_factory.mktemp("answer"))


def test_a_packed_page_unpacks_and_draws_every_figure_and_the_motion(answered):
    text, seen, console = answered
    figures = {key.removeprefix("data-") for key in data_of(text) if key.startswith("data-")}
    assert figures == set(seen["charts"])
    assert not {
        key: one for key, one in seen["charts"].items() if not (one["traces"] and one["ink"])
    }
    assert seen["errors"] == [] and console == []
    assert seen["refused"] == [] and seen["loaded"] == []
    assert len(text) < 2_800_000


def test_every_figure_is_written_in_each_format_as_its_own_file(tmp_path):
    answer = Answer(own_study())
    begins = {"svg": b"<svg", "png": b"\x89PNG", "pdf": b"%PDF"}
    for ending, begin in begins.items():
        files = write_figures(answer, tmp_path, ending)
        assert {one.stem for one in files} == set(figures_of(answer))
        assert all(one.suffix == f".{ending}" and begin in one.read_bytes()[:200] for one in files)
