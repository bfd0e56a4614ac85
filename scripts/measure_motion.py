"""Measure the moving picture of the beehive (168 elements) in headless Chromium with software
rendering (SwiftShader, no GPU).

Prints sizes of data, script and page, the time from opening the page to the first picture, the
median time between pictures while it
plays, and the processor time of one. Run on Linux: python scripts/measure_motion.py [SECONDS]
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

import valvetrain as vt
from valvetrain.views.motion.project import motion_data
from valvetrain.views.motion.scene import moving_picture
from valvetrain.views.page import motion_script

#: The page is put together on the processor, WebGL is drawn there too.
OPTIONS = ["--no-sandbox", "--enable-unsafe-swiftshader"]
HANDLE = "document.querySelector('.vtm').parentElement.motion"
#: A page of the picture alone.
PAGE = """<!DOCTYPE html><meta charset="utf-8"><title>motion</title><script>{script}</script><div id="place"></div>
<script>valvetrainMotion.mount(document.getElementById("place"), {data});</script>"""
NEEDED = 30.0


def processor_time(profile: str) -> float:
    """Processor time (ms) of all processes of the browser that keeps its files in ``profile``."""
    found = 0.0
    for process in Path("/proc").glob("[0-9]*"):
        try:
            if profile in (process / "cmdline").read_text():
                fields = (process / "stat").read_text().rpartition(")")[2].split()
                found += 1e3 * (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        except OSError:
            continue
    return found


def measure(study: vt.Study, seconds: float) -> dict[str, float]:
    """Sizes (kB) and times (ms) of the picture of a study."""
    from playwright.sync_api import sync_playwright

    begun = time.perf_counter()
    moving = moving_picture(study)
    assert moving is not None
    data = json.dumps(motion_data(moving))
    built = time.perf_counter() - begun
    html = PAGE.format(script=motion_script(), data=data)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        file, profile = Path(folder) / "page.html", f"{folder}/profile"
        file.write_text(html, encoding="utf-8")
        browser = driver.chromium.launch_persistent_context(
            profile,
            executable_path=shutil.which("chromium"),
            args=OPTIONS,
            viewport={"width": 1400, "height": 900},
        )
        page = browser.new_page()
        page.goto(file.as_uri())
        page.wait_for_function(
            f"document.querySelector('.vtm') && {HANDLE}.statistics().frames > 0"
        )
        first, loaded = page.evaluate(
            "[performance.now(), performance.getEntriesByType('navigation')[0].loadEventEnd]"
        )
        page.evaluate(f"{HANDLE}.play()")
        page.wait_for_timeout(1000)
        before, frames = processor_time(profile), page.evaluate(f"{HANDLE}.statistics().frames")
        page.wait_for_timeout(1000 * seconds)
        found = page.evaluate(f"{HANDLE}.statistics()")
        used = (processor_time(profile) - before) / max(found["frames"] - frames, 1)
        pixels = page.evaluate(
            "document.querySelector('.vtm canvas').width * document.querySelector('.vtm canvas').height"
        )
        browser.close()
    return {
        "data (kB)": len(data) / 1e3,
        "scripts (kB)": len(motion_script()) / 1e3,
        "page of this alone (kB)": len(html) / 1e3,
        "building the data (ms)": 1e3 * built,
        "page loaded (ms)": loaded,
        "first picture (ms)": first,
        "median between pictures (ms)": found["interval"],
        "pictures a second": 1000 / found["interval"],
        "processor time of a picture (ms)": used,
        "of that, the page's own script (ms)": found["drawing"],
        "pixels of the picture": pixels,
        "load of the machine": os.getloadavg()[0],
    }


def main() -> None:
    """Measure and print; exit code 1 below :data:`NEEDED` pictures a second."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 6.0
    study = vt.simulate("gu2021-beehive-blind", "5600 rpm", models=["finite-element"])
    found = measure(study, seconds)
    for name, value in found.items():
        print(f"{name:34s} {value:10.1f}")
    sys.exit(found["pictures a second"] < NEEDED)


if __name__ == "__main__":
    main()
