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
from valvetrain.report.page import charts, render
from valvetrain.report.study import study_page

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
#: Stands last: notes what is folded and follows a link, then opens every tab and every detail, as a reader would, then writes down what was seen.
ASK = """
<script>
window.addEventListener("load", () => setTimeout(() => {
  const parts = Array.from(document.querySelectorAll("details.part"));
  seen.folded = parts.map((part) => !part.open);
  seen.height = document.querySelector("main") ? document.querySelector("main").scrollHeight : 0;
  const picture = document.querySelector("#opening figure");
  const plot = picture && picture.querySelector(".plot");
  seen.bottom = plot ? plot.getBoundingClientRect().bottom + window.scrollY : -1;
  seen.picture = picture ? picture.getBoundingClientRect().top + window.scrollY : -1;
  const aim = document.querySelector("details.part figure");
  if (aim) { location.hash = aim.id; }
}, 300));
window.addEventListener("load", () => setTimeout(() => {
  const aimed = location.hash && document.getElementById(location.hash.slice(1));
  seen.led = Boolean(aimed) && aimed.getBoundingClientRect().height > 0;
  document.querySelectorAll("details").forEach((part) => { part.open = true; });
  // A loaded machine may show no frame in virtual time, so figures are asked for as for print.
  window.dispatchEvent(new Event("beforeprint"));
  document.querySelectorAll("[role=tab]").forEach((tab) => tab.click());
  setTimeout(() => {
    seen.loaded = performance.getEntriesByType("resource").map((entry) => entry.name).filter((name) => !/^(data|blob):/.test(name));
    seen.width = window.innerWidth;
    seen.wider = document.documentElement.scrollWidth - window.innerWidth;
    seen.outside = [];
    const words = ".ytick text, .xtick text, .annotation-text, .xtitle, .ytitle, .cbtitle text";
    document.querySelectorAll(".plot[data-chart]").forEach((box) => {
      const frame = box.getBoundingClientRect();
      if (!frame.width) { return; }
      box.querySelectorAll(words).forEach((text) => {
        const place = text.getBoundingClientRect();
        const off = Math.max(frame.left - place.left, place.right - frame.right, frame.top - place.top, place.bottom - frame.bottom);
        if (place.width && off > 2) { seen.outside.push(box.dataset.chart + ": " + text.textContent + " by " + off.toFixed(1)); }
      });
    });
    seen.charts = Object.fromEntries(Array.from(document.querySelectorAll(".plot[data-chart]"), (box) => [box.dataset.chart, {
      traces: box.querySelectorAll(".main-svg .scatterlayer .trace, .main-svg .heatmaplayer .hm, .main-svg .cartesianlayer .trace").length,
      ink: Array.from(box.querySelectorAll(".main-svg path")).filter((path) => (path.getAttribute("d") || "").length > 20).length
        + box.querySelectorAll(".heatmaplayer image").length,
    }]));
    const first = document.querySelector(".cards");
    seen.cards = first ? Array.from(first.querySelectorAll(".card h3, .card tr.topic th"), (title) => title.textContent) : [];
    seen.hidden = Array.from(document.querySelectorAll(".card .scroll")).filter((part) => part.scrollWidth > part.clientWidth + 1).length;
    const note = document.body.appendChild(document.createElement("pre"));
    note.id = "seen";
    note.textContent = JSON.stringify(seen);
    // A page that stands in a frame tells it to the page around it.
    window.parent.postMessage(JSON.stringify(seen), "*");
  }, 2500);
}, 500));
</script>
"""
#: A window of chromium is never narrower than 500 px, so a narrow page stands in a frame.
FRAME = """<!DOCTYPE html>
<html><body style="margin:0"><iframe src="page.html" style="width:WIDTHpx;height:24000px;border:0"></iframe>
<script>
window.addEventListener("message", (event) => {
  const note = document.body.appendChild(document.createElement("pre"));
  note.id = "seen";
  note.textContent = event.data;
});
</script></body></html>
"""


def browse(html: str, folder: Path, width: int = 1400) -> tuple[dict, list[str]]:
    """What a page of that width (px) has seen once loaded, and what it wrote to the console."""
    page = folder / "page.html"
    page.write_text(
        html.replace("<head>", f"<head>{WATCH}", 1).replace(
            "</body>\n</html>", f"{ASK}</body>\n</html>"
        ),
        encoding="utf-8",
    )
    if width < 500:
        page = folder / "frame.html"
        page.write_text(FRAME.replace("WIDTH", str(width)), encoding="utf-8")
    browser = program("chromium")
    assert browser
    command = [
        browser, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking", "--disable-sync",
        "--disable-component-update", "--disable-extensions", "--hide-scrollbars", f"--user-data-dir={folder / 'profile'}",
        f"--window-size={max(width, 500)},24000", "--virtual-time-budget=20000", "--enable-logging=stderr", "--v=0", "--dump-dom",
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


#: Every page wide; the narrow ones but for the largest with the long tests.
WIDTHS = [(name, 1400) for name in STUDIES] + [
    (name, 390) if name == "published" else pytest.param((name, 390), marks=pytest.mark.long)
    for name in STUDIES
]


@pytest.fixture(scope="module", params=WIDTHS, ids=lambda one: f"{one[0]}-{one[1]}")
def visit(request, tmp_path_factory):
    name, width = request.param
    page = study_page(STUDIES[name]())
    return page, width, *browse(render(page), tmp_path_factory.mktemp("browser"), width)


def test_every_chart_is_drawn_and_nothing_goes_wrong(visit):
    page, width, seen, console = visit
    assert seen["width"] == width
    assert {chart.key for chart in charts(page)} == set(seen["charts"])
    assert not {
        key: drawn
        for key, drawn in seen["charts"].items()
        if not (drawn["traces"] and drawn["ink"])
    }
    assert seen["errors"] == [] and console == []
    assert seen["refused"] == [] and seen["loaded"] == []


def test_the_watch_catches_what_it_should(tmp_path):
    """One page on which everything goes wrong at once."""
    body = """<div style='width:3000px;height:2px'></div><img src='https://example.invalid/a.png'>
<div class='plot' data-chart='empty'></div><script>console.error('no')</script>
<script>fetch('https://example.invalid/b')</script><script>lost()</script>"""
    seen, console = browse(
        f"<!DOCTYPE html>\n<html>\n<head></head>\n<body>{body}</body>\n</html>", tmp_path
    )
    assert {address.rpartition("/")[2] for address in seen["refused"]} == {"a.png", "b"}
    assert any("lost is not defined" in error for error in seen["errors"])
    assert any('"no"' in line for line in console)
    assert seen["wider"] > 0
    assert seen["charts"] == {"empty": {"traces": 0, "ink": 0}}
