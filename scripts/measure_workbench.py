"""Measure the workbench in a browser: first page, figures after the end of a run, a new curve while
the slider moves.

Use: python scripts/measure_workbench.py [--visits 5]      needs Chromium, playwright and NiceGUI
Prints medians and largest values beside the bounds; 1 where a median is beyond its bound.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
#: Bounds (s): first page, figures after the end of a run, slider to curve.
BOUNDS = {
    "first page": 1.0,
    "page of a case": 1.0,
    "figures after the end of a run": 0.3,
    "slider to new curve": 0.15,
}


def main() -> int:
    """Start a server in a new folder, visit it, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--visits", type=int, default=5)
    visits = parser.parse_args().visits
    from playwright.sync_api import sync_playwright

    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    with tempfile.TemporaryDirectory() as folder:
        command = [
            sys.executable,
            "-m",
            "valvetrain",
            "serve",
            "--folder",
            folder,
            "--port",
            str(port),
            "--no-open",
            "--quiet",
        ]
        server = subprocess.Popen(command, env=environment, start_new_session=True)
        try:
            wait_for(port)
            with sync_playwright() as driver:
                path = (
                    shutil.which("chromium")
                    or shutil.which("chromium-browser")
                    or shutil.which("google-chrome")
                )
                browser = driver.chromium.launch(
                    executable_path=path, args=["--no-sandbox", "--disable-gpu"]
                )
                found = measured(browser, f"http://127.0.0.1:{port}", visits)
                browser.close()
        finally:
            os.killpg(server.pid, signal.SIGINT)
            server.wait(30)
    print(f"load of the machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    for name, seconds in found.items():
        middle = statistics.median(seconds)
        told = f"median {middle * 1e3:5.0f} ms, largest {max(seconds) * 1e3:5.0f} ms, bound {BOUNDS[name] * 1e3:.0f} ms"
        print(f"{name:34} {told}, {len(seconds)} times")
    return int(any(statistics.median(seconds) > BOUNDS[name] for name, seconds in found.items()))


def wait_for(port: int) -> None:
    """Until the server listens."""
    for _ in range(600):
        with socket.socket() as door:
            if door.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.1)
    raise SystemExit("the server does not listen")


def measured(browser: Any, url: str, visits: int) -> dict[str, list[float]]:
    """What the browser sees (s)."""
    found: dict[str, list[float]] = {name: [] for name in BOUNDS}
    for _ in range(visits):
        page = browser.new_context(viewport={"width": 1400, "height": 900}).new_page()
        begun = time.perf_counter()
        page.goto(url, wait_until="commit")
        page.wait_for_selector("ul.cases button")
        found["first page"].append(time.perf_counter() - begun)
        page.context.close()
    page = browser.new_context(viewport={"width": 1400, "height": 900}).new_page()
    page.goto(url)
    page.locator("[data-source=gu2021-beehive-blind]").click()
    page.wait_for_url("**/case/gu2021-beehive-blind")
    page.wait_for_selector(".form")
    for _ in range(visits):
        begun = time.perf_counter()
        page.goto(f"{url}/case/gu2021-beehive-blind", wait_until="commit")
        page.wait_for_selector(".form")
        found["page of a case"].append(time.perf_counter() - begun)
    page.get_by_label("Engine speeds (crank)").fill("4200 rpm")
    page.wait_for_function("typeof Plotly !== 'undefined'")
    for _ in range(visits):
        shown = page.get_attribute(".results", "data-shown") or ""
        page.click("#run-button")
        page.wait_for_function(
            f"(document.querySelector('.results').dataset.shown || '') !== '{shown}'",
            timeout=600_000,
        )
        drawn = page.evaluate("window.valvetrainResults.at")
        ended = page.evaluate("fetch('/job/gu2021-beehive-blind').then((answer) => answer.json())")[
            "ended_at"
        ]
        found["figures after the end of a run"].append(drawn - ended)
    page.select_option("#live-quantity", "spring.precompression")
    page.wait_for_selector(".live .numbers", timeout=600_000)
    page.focus("#live-slider")
    for _ in range(4 * visits):
        page.keyboard.press("ArrowRight")
        page.wait_for_timeout(250)
    found["slider to new curve"] = [
        one / 1e3 for one in page.evaluate("window.valvetrainSlider")[1:]
    ]
    return found


if __name__ == "__main__":
    sys.exit(main())
