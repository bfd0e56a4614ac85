"""Measure the moving picture of the beehive (168 elements) in headless Chromium with software rendering.

Prints sizes of data, script and page, the time from opening the page to the first picture, and the median time between pictures while
it plays. Run: python scripts/measure_motion.py [SECONDS]
"""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
import time
from pathlib import Path

import valvetrain as vt
from valvetrain.report.motion.pack import motion_json
from valvetrain.report.motion.scene import moving_picture
from valvetrain.report.motion.script import motion_script
from valvetrain.report.page import Page, Section, render
from valvetrain.report.sections.in_motion import blocks

#: Chromium draws WebGL by SwiftShader, on the processor alone.
OPTIONS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]
HANDLE = "document.querySelector('[data-motion]').motion"


def measure(study: vt.Study, seconds: float) -> dict[str, float]:
    """Sizes (kB) and times (ms) of the picture of a study."""
    from playwright.sync_api import sync_playwright

    begun = time.perf_counter()
    data = motion_json(moving_picture(study))
    built = time.perf_counter() - begun
    html = render(Page("motion", "", "", (), (Section("in-motion", "In motion", blocks(study)),)))
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        file = Path(folder) / "page.html"
        file.write_text(html, encoding="utf-8")
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=OPTIONS)
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        page.goto(file.as_uri())
        page.wait_for_function(f"{HANDLE} && {HANDLE}.statistics().frames > 0")
        first = page.evaluate("performance.now()")
        loaded = page.evaluate("performance.getEntriesByType('navigation')[0].loadEventEnd")
        page.evaluate(f"{HANDLE}.play()")
        page.wait_for_timeout(1000 * seconds)
        found = page.evaluate(f"{HANDLE}.statistics()")
        size = page.evaluate("[document.querySelector('.vtm canvas').width, document.querySelector('.vtm canvas').height]")
        rings = page.evaluate(f"{HANDLE}.shown().tubes.map((tube) => tube.rings)")
        browser.close()
    return {
        "data (kB)": len(data) / 1e3, "script with three.js (kB)": len(motion_script()) / 1e3, "page without other figures (kB)": len(html) / 1e3,
        "building the data (ms)": 1e3 * built, "page loaded (ms)": loaded, "first picture (ms)": first,
        "pictures while playing": found["counted"], "median between pictures (ms)": found["interval"],
        "median of drawing one (ms)": found["drawing"], "pixels": size[0] * size[1], "rings of the wire": sum(rings),
    }  # fmt: skip


def main() -> None:
    """Measure and print."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 6.0
    study = vt.simulate("gu2021-beehive", "5600 rpm", spring_models=["finite-element"])
    for name, value in measure(study, seconds).items():
        print(f"{name:36s} {value:10.1f}")
    print(json.dumps({"frames per second": 1000 / measure(study, seconds)["median between pictures (ms)"]}))


if __name__ == "__main__":
    main()
