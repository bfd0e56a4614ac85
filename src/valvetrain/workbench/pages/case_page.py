"""The page of a case: its form, a slider, what to run, the state of the job, and the results as soon
as they are there.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from functools import partial
from typing import Any

from nicegui import events, ui
from pydantic import ValidationError

from valvetrain.cli.cases import first_answer
from valvetrain.errors import InputError, ValvetrainError
from valvetrain.parameters.case import Case
from valvetrain.units.reader import follow_case, for_reader
from valvetrain.workbench.form import CaseForm
from valvetrain.workbench.jobs import JobStatus
from valvetrain.workbench.live import LiveChain
from valvetrain.workbench.live_result import LiveResult
from valvetrain.workbench.pages.desk import Desk
from valvetrain.workbench.pages.elements import (
    Form,
    JobPanel,
    Order,
    Results,
    Slider,
    button,
    link,
    tag,
)
from valvetrain.workbench.pages.file_lists import case_files
from valvetrain.workbench.pages.forms import (
    ENGINE_SPEED,
    engine_speed,
    sliding,
)
from valvetrain.workbench.pages.frame import frame
from valvetrain.workbench.pages.html import job_shown, sentence_of
from valvetrain.workbench.pages.live_curve import float_text, live_lines, live_numbers
from valvetrain.workbench.pages.orders import orders_for
from valvetrain.workbench.pages.pictures import has_picture, of_case, prepare
from valvetrain.workbench.pages.runs import run_head, run_table
from valvetrain.workbench.requests import STORED, JobRequest
from valvetrain.workbench.saved_runs import Run
from valvetrain.workbench.workspace import CaseId

#: Time between two looks at a job (s), and how many of them are one where no job is running.
LOOK, SLOW_LOOK = 0.05, 10
#: Groups of the form that are open at first, and earlier runs listed.
OPEN_GROUPS, MAX_RUNS = 1, 8
#: What is shown of a case without runs.
NO_RUN = "none"
#: Jobs of the case whose choices its page begins with.
MAX_JOBS = 10


async def case_page(desk: Desk, case: CaseId) -> None:
    """The page of a case of the workspace."""
    try:
        text, read = await asyncio.to_thread(current_text, desk, case)
    except ValvetrainError as error:
        missing_page("This case cannot be shown", sentence_of(error))
        return
    CasePage(desk, case, text, read).build()


def current_text(desk: Desk, case: CaseId) -> tuple[str, Case]:
    """Text of a case, and what is read of it. Raises :class:`InputError` for an unknown one."""
    text = desk.workspace.text(case)
    return text, desk.workspace.parse(case, text)


def first_said(case: Case) -> str:
    """What is said of a case that has not run yet: what ``check`` says, or what is wrong with it."""
    follow_case(case.text)
    try:
        with for_reader():
            return first_answer(case)
    except ValvetrainError as error:
        return sentence_of(error)


def missing_page(title: str, sentence: str) -> None:
    """A page that says what is not there."""
    with frame(title, figures=False):
        tag("h1", title)
        tag("p", sentence, "refusal", role="alert")
        link("Back to the start", "/", "button")


def _shown(case_form: CaseForm) -> dict[str, list[dict[str, Any]]]:
    """Groups of the form, and tables that may be added, as its script takes them."""
    groups, more = case_form.groups, case_form.additions
    return {"groups": [asdict(one) for one in groups], "additions": [asdict(one) for one in more]}


def _place(event: events.GenericEventArguments) -> tuple[str, str]:
    """Key and value that the script of a form or of a slider sent."""
    return str(event.args["key"]), str(event.args["value"])


class CasePage:
    """One visit of a case's page; what it shows is in the workspace, so that a reload or
    another tab finds the same.
    """

    def __init__(self, desk: Desk, case: CaseId, text: str, read: Case) -> None:
        self.desk, self.case, self.text, self.read = desk, case, text, read
        self.job: JobStatus | None = None
        self.shown_run = ""
        self.moved: tuple[str, LiveResult] | None = None
        self.own_float: float | None = None
        self.drawn, self.requested, self.drawing = "", ("", ""), False
        self.looks = -1
        self.line = asyncio.Lock()

    # -- layout
    # ----------------------------------------------------------------------------------------------------------

    def build(self) -> None:
        """Make the page."""
        case_form, jobs = self.case_form(), self.desk.jobs
        earlier = [jobs.request(one.job_id) for one in jobs.jobs(self.case, MAX_JOBS)]
        with frame(self.read.title or self.case):
            tag("h1", self.read.title or self.case)
            self.newest = tag("p", classes="newest")
            quantities = sliding(case_form.groups)
            self.order = Order(
                {"estimate": self.estimate, "run": self.start},
                **orders_for(self.read, quantities, earlier),
            )
            self.panel = JobPanel({"cancel": self.cancel, "again": self.again})
            with tag("div", classes="split"):
                tag("p", f"Case {self.case}. Changes are saved as you make them.", "said")
                with tag("div", classes="row"):
                    link(
                        "Download the case",
                        f"/download-case/{self.case}",
                        "button small",
                        download="",
                    )
                    button("Copy of the case", self.copy, "button small")
                    self.undoing = button("Undo the last change", self.undo, "button small")
            with tag("div", classes="bench"):
                with tag("section", classes="inputs", aria_labelledby="inputs-title"):
                    tag("h2", "Case", id="inputs-title")
                    opened = [group.key for group in case_form.groups if group.key][:OPEN_GROUPS]
                    changes = {"change": self.change, "add": self.add}
                    self.form = Form(changes, open=opened, **_shown(case_form))
                    self.side_files = case_files(self.desk, self.case, self.refresh)
                with tag("div", classes="outputs"):
                    with tag("figure", classes="drawn case-drawn") as self.figure:
                        self.picture = tag("img", alt="the parts to scale, valve closed and open")
                        tag("figcaption", "To scale: valve closed and at full lift.", "hint")
                    events = ("begin", "move", "moving", "rest", "settle", "keep")
                    self.slider = Slider({one: getattr(self, one) for one in events})
                    self.slide(quantities)
                    self.head = tag("div", classes="run-head", id="results")
                    self.results = Results()
                    self.list = tag("div", classes="run-list")
        self.undoing.set_visibility(self.desk.workspace.last_change(self.case) is not None)
        self.figure.set_visibility(has_picture(self.read))
        self.picture.props["src"] = of_case(self.desk, self.case)
        ui.timer(LOOK, self.look)

    def slide(self, quantities: list[dict[str, Any]]) -> None:
        """Offer ``quantities`` to the slider; a train has a float speed."""
        offered = [*engine_speed(self.read), *quantities]
        self.slider.tell(quantities=offered, floats=self.read.train is not None)

    async def draw(self, key: str = "", value: str = "") -> None:
        """Draw the case with ``value`` at ``key``; of positions that come meanwhile, the newest is
        drawn next.
        """
        self.requested = key, value
        if self.drawing:
            return
        self.drawing = True
        try:
            while (address := of_case(self.desk, self.case, *self.requested)) != self.drawn:
                self.drawn = address
                await asyncio.to_thread(prepare, self.desk, self.case, *self.requested)
                self.picture.props["src"] = address
                self.picture.update()
        finally:
            self.drawing = False

    # -- the form
    # --------------------------------------------------------------------------------------------------------

    async def change(self, event: events.GenericEventArguments) -> None:
        """A field was changed, or a table is to be removed: taken, or refused in its place."""
        key, value = _place(event)
        self.form.answer(key, await self.put(key, value))

    async def put(self, key: str, value: str) -> str:
        """Set a value of the case; the refusal, empty where it was taken."""
        if key == "lift_law.kind" and value:
            return await self.done(lambda: self.desk.workspace.change_law(self.case, value), key)
        return await self.done(lambda: self.desk.put(self.case, key, value), key)

    async def done(self, change: Callable[[], None], key: str) -> str:
        """Make a change to the case, after those requested before and in a thread; the
        refusal, empty where it was made.
        """
        async with self.line:
            try:
                await asyncio.to_thread(change)
            except ValvetrainError as error:
                return sentence_of(error, key)
            await self.refreshed()
        return ""

    async def add(self, event: events.GenericEventArguments) -> None:
        """A table is to be added."""
        key = str(event.args["key"])
        refusal = await self.done(lambda: self.desk.workspace.add_table(self.case, key), key)
        self.form.answer(key, refusal)

    async def undo(self) -> None:
        """The last change is to be taken back."""
        if refusal := await self.done(lambda: self.desk.workspace.undo(self.case), ""):
            ui.notify(refusal)

    def case_form(self) -> CaseForm:
        """The form of the case as it is."""
        return CaseForm(self.text, [one.name for one in self.desk.workspace.side_files(self.case)])

    async def after_changes(self, ask: Callable[[], str]) -> str:
        """Request something once the changes that were requested before are made; it runs next to
        what the pages do.
        """
        async with self.line:
            return await asyncio.to_thread(ask)

    async def refresh(self) -> None:
        """Show the case as it is, after the changes that were requested before."""
        async with self.line:
            await self.refreshed()

    async def refreshed(self) -> None:
        """Show the case as it is; it is read in a thread."""
        self.text, self.read = await asyncio.to_thread(current_text, self.desk, self.case)
        self.moved = None
        case_form = self.case_form()
        quantities = sliding(case_form.groups)
        self.form.tell(**_shown(case_form))
        self.undoing.set_visibility(self.desk.workspace.last_change(self.case) is not None)
        self.side_files.show()
        self.own_float = None
        if self.shown_run == NO_RUN:  # its first answer is that of the case as it was
            self.shown_run = ""
        self.slide(quantities)
        self.figure.set_visibility(has_picture(self.read))
        await self.draw()
        self.order.tell(**orders_for(self.read, quantities))

    async def copy(self) -> None:
        """A copy of the case, and its page."""
        try:
            ui.navigate.to(
                f"/case/{await self.after_changes(lambda: self.desk.workspace.duplicate(self.case))}"
            )
        except ValvetrainError as error:
            ui.notify(sentence_of(error))

    # -- the slider
    # --------------------------------------------------------------------------------------------------------

    async def begin(self) -> None:
        """The list of quantities is opened: the chain is begun meanwhile."""
        with suppress(ValvetrainError):
            await asyncio.to_thread(self.desk.chain, self.case)

    async def move(self, event: events.GenericEventArguments) -> None:
        """The slider moved: the curve by the chain."""
        key, value = _place(event)
        base, moved = await self.desk.ask(self.case, key, value)
        if not base.angle_deg or not moved.angle_deg:
            self.slider.answer([], [], moved.sentence or base.sentence)
            return
        self.moved = (value, moved)
        self.slider.answer(
            live_lines(base, moved, None, value), live_numbers(base, moved), moved.sentence
        )
        await self.draw(key, value)

    async def settle(self, event: events.GenericEventArguments) -> None:
        """The slider rests: the float speed is searched for."""
        _, result = await self.desk.ask(
            self.case, *_place(event), lambda chain, changes, _: chain.float_speed(changes)
        )
        speed = result.quantities.get("float speed", (None, ""))[0]
        if not event.args.get("asked"):
            self.own_float = speed
        if not result.skipped:
            self.slider.float_answer(float_text(speed, self.own_float, result.sentence))

    async def rest(self, event: events.GenericEventArguments) -> None:
        """The slider rests: the curve by the rod too."""
        key, value = _place(event)
        base, rod = await self.desk.ask(self.case, key, value, LiveChain.rod)
        moved = self.moved[1] if self.moved is not None and self.moved[0] == value else None
        if moved is None or not base.angle_deg or not rod.angle_deg:
            self.slider.rod_answer([], "" if rod.skipped else rod.sentence)
            return
        sentence = f"The rod took {rod.seconds:.1f} s. {rod.sentence}".strip()
        self.slider.rod_answer(live_lines(base, moved, rod, value), sentence)

    def moving(self) -> None:
        """The slider moves again: a rod that runs is ended."""
        opened = self.desk.chains.get(self.case)
        if opened is not None:
            opened.chain.cancel()

    async def keep(self, event: events.GenericEventArguments) -> None:
        """Put the value of the slider into the case."""
        key, value = _place(event)
        key = "operation.engine_speeds" if key == ENGINE_SPEED else key
        if refusal := await self.put(key, value):
            self.slider.answer([], [], refusal)

    def wish(self, event: events.GenericEventArguments) -> JobRequest:
        """The request of what was chosen. Raises :class:`InputError` for what no page of this server sends."""
        try:
            return STORED.validate_python({**event.args, "case": self.case})
        except (ValidationError, TypeError):
            raise InputError("this cannot be read; open the page again", "choice") from None

    # -- jobs
    # ----------------------------------------------------------------------------------------------------------------

    async def estimate(self, event: events.GenericEventArguments) -> None:
        """What the choice would cost, or why it cannot be run."""
        try:
            async with self.line:
                pass  # changes that were requested before are made; those that come need not wait for this
            cost = await asyncio.to_thread(self.desk.jobs.estimate, self.wish(event))
            self.order.tell(estimate=f"Takes {cost}." if cost else "", refusal="")
        except ValvetrainError as error:
            self.order.tell(estimate="", refusal=sentence_of(error))

    async def start(self, event: events.GenericEventArguments) -> None:
        """Submit the job."""
        try:
            await self.after_changes(lambda: self.desk.jobs.submit(self.wish(event)))
        except ValvetrainError as error:
            self.order.tell(estimate="", refusal=sentence_of(error))
            return
        self.looks = -1

    def cancel(self) -> None:
        """Stop the job that is shown."""
        if self.job is not None:
            self.desk.jobs.cancel(self.job.job_id)

    async def again(self) -> None:
        """Start the job that is shown again."""
        if self.job is not None:
            try:
                await self.after_changes(partial(self.desk.jobs.restart, self.job.job_id))
            except ValvetrainError as error:
                ui.notify(sentence_of(error))

    async def look(self) -> None:
        """Show the state of the newest job of the case, and its run when there is one."""
        self.looks += 1
        if self.looks % SLOW_LOOK and (self.job is None or self.job.ended):
            return
        newest = next(iter(self.desk.jobs.jobs(self.case, 1)), None)
        if newest != self.job:
            self.job = newest
            self.panel.tell(job=job_shown(newest))
            self.order.tell(busy=newest is not None and not newest.ended)
        if (
            newest is not None
            and newest.ended
            and newest.run_id
            and newest.run_id != self.shown_run
        ):
            self.results.tell(source=f"/part/{newest.run_id}")
            await asyncio.sleep(0.02)  # its figures first, then what is around them
            await self.show_run(newest.run_id)
        elif not self.shown_run:
            await self.show_run("")

    async def show_run(self, run_id: str) -> None:
        """Show a run, the newest of the case where none is named, with the earlier ones below it."""
        runs = await asyncio.to_thread(self.desk.workspace.runs, self.case)
        chosen: Run | None = next((one for one in runs if one.run_id == run_id), None) or next(
            iter(runs), None
        )
        self.shown_run = run_id or (chosen.run_id if chosen is not None else NO_RUN)
        self.newest.clear()
        if chosen is None:
            with self.newest:
                tag("strong", await asyncio.to_thread(first_said, self.read))
            return
        self.results.tell(source=f"/part/{chosen.run_id}")
        with self.newest:
            if chosen.verdict:
                tag("strong", chosen.verdict)
                link("Results", "#results", "quiet")
        self.head.clear()
        with self.head:
            run_head(self.desk, chosen, full=False)
        self.list.clear()
        others = [run for run in runs if run is not chosen][:MAX_RUNS]
        if others:
            with self.list:
                tag("h2", "Earlier runs of this case")
                run_table(others, alone=True)
