"""Addresses of the pages."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from html import escape

from nicegui import app, ui

from valvetrain.errors import ValvetrainError
from valvetrain.units.text import clipped
from valvetrain.workbench.pages import files, pictures
from valvetrain.workbench.pages import frame as assets
from valvetrain.workbench.pages.case_page import case_page, missing_page
from valvetrain.workbench.pages.compare_page import compare_page
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.elements import Upload, link, tag
from valvetrain.workbench.pages.frame import frame
from valvetrain.workbench.pages.html import sentence_of
from valvetrain.workbench.pages.run_page import run_page, runs_page
from valvetrain.workbench.pages.runs import run_table
from valvetrain.workbench.workspace import CaseCard

_HOLDS = {
    "spring": "spring",
    "lift_law": "lift law",
    "train": "train",
    "published": "published values",
}
#: Runs listed on the first page.
MAX_RUNS = 6


def home_page(desk: Desk) -> None:
    """The first page."""
    with frame("Start", "/", figures=False):
        tag("h1", "What do you want to look at?")
        tag(
            "p",
            "Choose a case to begin with, or open a case file. Every value can be changed. Nothing leaves this machine.",
            "intro",
        )
        mine = desk.workspace.cases()
        if mine:
            tag("h2", "Your cases")
            rows = "".join(_row(desk, card) for card in mine)  # elements for each take seconds
            ui.html(rows, sanitize=False, tag="ul").classes("cases")
        known = desk.workspace.library()
        tag("h2", "Begin with a template")
        _choices(desk, [card for card in known if card.kind == "template"])
        tag("h2", "Begin with a case of the library")
        _choices(desk, [card for card in known if card.kind == "library"])
        with tag("div", classes="panel"):
            tag("h2", "Open a case file")
            most = desk.settings.most_upload
            hint = "A .toml file, as 'valvetrain new' writes it, and with it the tables that it names: choose them together."
            Upload(
                field="case-file", label="Case file", hint=hint, url="/upload/case", most=most, many=True,
            )  # fmt: skip
        runs = desk.workspace.runs()[:MAX_RUNS]
        if runs:
            tag("h2", "Last runs")
            run_table(runs)
            link("All runs", "/runs")


def _row(desk: Desk, card: CaseCard) -> str:
    """A case of the workspace in the list, with what is wrong with it where it cannot be opened."""
    title, more = card.title or card.name, card.name if card.title else ""
    text = f"<div><strong>{escape(title)}</strong><span>{escape(card.fault or more)}</span></div>"
    if card.fault:
        return f"<li>{text}</li>"
    drawn = escape(pictures.of_case(desk, card.name, small=True))
    picture = f'<span class="drawn"><img src="{drawn}" alt="" loading="lazy"></span>'
    return f'<li><a href="/case/{escape(card.name)}">{picture}{text}</a></li>'


def _choices(desk: Desk, cards: Sequence[CaseCard]) -> None:
    with tag("ul", classes="cases"):
        for card in cards:
            with (
                tag("li"),
                tag("button", type="button", data_source=card.name).on(
                    "click", lambda one=card: begin(desk, one), args=[]
                ),
            ):
                with tag("span", classes="drawn"):  # to scale
                    tag("img", src=pictures.of_source(card.name), alt="", loading="lazy")
                title = card.title.removeprefix("Template: ")
                with tag("div"):
                    tag("strong", title[:1].upper() + title[1:])
                    tag("span", ", ".join(_HOLDS.get(one, one) for one in card.holds) or "template")


async def begin(desk: Desk, card: CaseCard) -> None:
    """Make a case of a template or of a library case, under the first free name, and open it."""
    name = f"my-{card.name}" if card.kind == "template" else card.name
    try:
        made = await asyncio.to_thread(desk.workspace.new_case, name, card.name, numbered=True)
        ui.navigate.to(f"/case/{made}")
    except ValvetrainError as error:
        ui.notify(sentence_of(error))


#: How long a page waits for its case to be read (s): tables of lifts may be large.
MAX_READING_TIME = 300.0


def register(desk: Desk) -> None:
    """Add all pages, parts and assets to the server."""
    assets.register(app)
    files.register(app, desk)
    pictures.register(app, desk)

    @app.on_page_exception
    def _fault(error: Exception) -> None:
        missing_page("This page cannot be shown", clipped(f"{type(error).__name__}: {error}", 300))

    @ui.page("/")
    def _home() -> None:
        home_page(desk)

    @ui.page("/runs")
    def _runs() -> None:
        runs_page(desk)

    @ui.page("/compare")
    def _compare(a: str = "", b: str = "") -> None:
        compare_page(desk, a, b)

    @ui.page("/case/{case}", response_timeout=MAX_READING_TIME)
    async def _case(case: str) -> None:
        await case_page(desk, case)

    @ui.page("/run/{case}/{stamp}")
    def _run(case: str, stamp: str) -> None:
        run_page(desk, f"{case}/{stamp}")
