"""Addresses of the pages."""

from __future__ import annotations

from nicegui import app, ui

from valvetrain.workbench.pages import assets, files
from valvetrain.workbench.pages.case_page import case_page
from valvetrain.workbench.pages.compare_page import compare_page
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.home import home_page
from valvetrain.workbench.pages.run_page import run_page, runs_page

#: How long a page waits for its case to be read (s): tables of lifts may be large.
LONGEST_READING = 300.0


def register(desk: Desk) -> None:
    """Add all pages, parts and assets to the server."""
    assets.register(app)
    files.register(app, desk)

    @ui.page("/")
    def _home() -> None:
        home_page(desk)

    @ui.page("/runs")
    def _runs() -> None:
        runs_page(desk)

    @ui.page("/compare")
    def _compare(a: str = "", b: str = "") -> None:
        compare_page(desk, a, b)

    @ui.page("/case/{case}", response_timeout=LONGEST_READING)
    async def _case(case: str) -> None:
        await case_page(desk, case)

    @ui.page("/run/{case}/{stamp}")
    def _run(case: str, stamp: str) -> None:
        run_page(desk, f"{case}/{stamp}")
