"""Golden: the elements of every page of the workbench, line by line, at first and after what a
visitor does; ``pages/`` holds them.

``python tests/golden/test_workbench_pages.py`` writes the files anew; read the difference before it
is kept. What a browser makes of the
elements is looked at by ``tests/unit/test_workbench_browser.py``; here no word, class, address or
value may move unsaid.
"""

from __future__ import annotations

import asyncio
import hashlib
import json
import re
import sys
import tempfile
from collections.abc import Callable, Coroutine
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

from made_watch import are_same
from valvetrain.errors import InputError
from valvetrain.studies.run_store import Inputs, keep, new_folder
from valvetrain.workbench.jobs import JobStatus
from valvetrain.workbench.live import LiveResult
from valvetrain.workbench.saved_runs import keep_test
from valvetrain.workbench.settings import ServeSettings
from valvetrain.workbench.workspace import Workspace
from workbench_parts import SMALL, kept

pytest.importorskip("nicegui")
from nicegui import Client, core, ui
from nicegui.page import page as Address

from valvetrain.workbench.pages import case_page, compare_page, run_page
from valvetrain.workbench.pages import routes as home
from valvetrain.workbench.pages.desk import Desk, OpenChain

PAGES = Path(__file__).parent / "pages"
#: Addresses of assets bear a digest of what they hold; times of files are those of the test.
FLEETING = re.compile(r"(?<=/assets/)[0-9a-f]+|(?<=at=)[\d.]+")


def lines(element: Any, depth: int = 0) -> list[str]:
    """An element and what lies in it: tag, classes, words, what it hears, then its properties;
    lists of tables a line each.
    """
    head = "".join([element.tag, *(f".{one}" for one in element._classes)])
    every = f" every {element.interval:g} s" if hasattr(element, "interval") else ""
    heard = (
        " ".join(
            f"on {one.type}{'' if one.args is None else one.args}"
            for one in element._event_listeners.values()
        )
        + every
    )
    told, below = [], []
    for name, value in element._props.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            below += [f"{name}: {brief(one)}" for one in value]
        else:
            told.append(f"{name}={json.dumps(value, ensure_ascii=False, default=str)}")
    said = json.dumps(element.text, ensure_ascii=False) if getattr(element, "text", "") else ""
    words = " ".join(filter(None, (head, said, heard, *told)))
    found = [
        f"{'  ' * depth}{FLEETING.sub('*', one)}" for one in (words, *(f"  {one}" for one in below))
    ]
    return found + [
        line
        for slot in element.slots.values()
        for inside in slot.children
        for line in lines(inside, depth + 1)
    ]


def brief(one: Any, most: int = 100) -> str:
    """A table of a property: its title and what stands first in it, the rest as a digest."""
    text = json.dumps(one, ensure_ascii=False)
    return (
        text
        if len(text) < most
        else f"{text[: most - 20]}... {hashlib.sha256(text.encode()).hexdigest()[:8]}"
    )


class Visit:
    """One visitor: what a page is made of, what was sent to its elements, where it led."""

    def __init__(self) -> None:
        self.text: list[str] = []
        self.client = Client(Address("/"))

    def shows(self, words: str) -> None:
        """Keeps the page as it stands, under a heading."""
        asked = FLEETING.sub(
            "*",
            " ".join(re.findall(r'(?:src|href)="[^"]*"|"/assets[^"]*"', self.client._head_html)),
        )
        self.text += [
            f"== {words}",
            f"{self.client.title or ''} {asked}",
            *lines(self.client.layout),
        ]

    def hears(self, element: Any) -> None:
        """Keeps what is sent to an element that has a script, and that it was told of other
        properties.
        """
        element.update = lambda: self.text.append(f"-> {element.tag} is told anew")
        element.run_method = lambda *sent: self.text.append(f"-> {element.tag} {brief(sent, 700)}")


class Runs:
    """Jobs that wait until they are told how they stand."""

    def __init__(self) -> None:
        self.told: list[str] = []
        self.newest: JobStatus | None = None

    def jobs(self, case: str, most: int) -> list[JobStatus]:
        return [self.newest][:most] if self.newest is not None else []

    def estimate(self, request: Any) -> str:
        if "massless" in request.spring_models:
            return ""
        if request.engine_speeds == "1 rpm":
            raise InputError("1 rpm is too slow; give 10 rpm or more", "engine speeds")
        return "about 3 s and 1 MB"

    def submit(self, request: Any) -> None:
        if request.engine_speeds == "1 rpm":
            raise InputError("1 rpm is too slow; give 10 rpm or more", "engine speeds")
        self.told.append(f"-> submitted {request}")

    def cancel(self, number: str) -> None:
        self.told.append(f"-> cancelled {number}")

    def restart(self, number: str) -> None:
        self.told.append(f"-> begun again {number}")
        if number == "9":
            raise InputError("the case is gone; make it anew", "case")


class Chain:
    """A chain that answers with lines of known numbers."""

    case = LiveResult(
        (0.0, 90.0, 180.0),
        (250.0, 400.0, 550.0),
        (0.0, 4.0, 9.0),
        0.01,
        "",
        {"largest force": (550.0, "N")},
        4000.0,
    )

    def curve(self, changes: Any, speed: str = "") -> LiveResult:
        if speed == "none":
            return LiveResult(sentence="the spring is solid at 8 mm")
        if speed == "wrong":
            raise InputError("4 sliders are in use; close one of them", "slider")
        forces = (
            (250.0, 410.0, 530.0 + 10 * len(changes)) if changes or speed else self.case.force_N
        )
        return replace(
            self.case,
            force_N=forces,
            quantities={"largest force": (forces[-1], "N"), "lift": (9.0, "mm")},
        )

    def rod(self, changes: Any, speed: str = "") -> LiveResult:
        return replace(self.curve(changes, speed), seconds=2.34, sentence="Mind the gap.")

    def cancel(self) -> None:
        raise InterruptedError("a rod was ended")

    def close(self) -> None:
        pass


def desk_of(folder: Path) -> Desk:
    settings = ServeSettings("127.0.0.1", 8420, "", (), False)
    return Desk(Workspace(folder), Runs(), settings)  # type: ignore[arg-type]


def event(**told: Any) -> Any:
    return SimpleNamespace(args=told)


async def home_pages(folder: Path) -> list[str]:
    """The first page of an empty workspace and of a used one, a case begun by its buttons, the list
    of runs, a run that is not there.
    """
    desk, visit, led = desk_of(folder), Visit(), list[str]()
    with visit.client, pytest.MonkeyPatch.context() as patch:
        patch.setattr(ui.navigate, "to", led.append)
        patch.setattr(ui, "notify", led.append)
        home.home_page(desk)
        visit.shows("nothing there")
        for name in ("spring", "uniform-spring", "uniform-spring", "spring", "spring"):
            await home.begin(
                desk, next(card for card in desk.workspace.library() if card.name == name)
            )
        patch.setattr(
            desk.workspace,
            "new_case",
            lambda *_: (_ for _ in ()).throw(InputError("the disk is full", "workspace")),
        )
        await home.begin(desk, desk.workspace.library()[0])
        visit.text += [f"-> {one}" for one in led]
    for hour in range(8):
        kept(desk.workspace, created=f"2026-01-{hour + 1:02d}T0{hour}:07:00+00:00")
    for words, make in (
        ("used", lambda: home.home_page(desk)),
        ("runs", lambda: run_page.runs_page(desk)),
        ("runs of none", lambda: run_page.runs_page(desk_of(folder / "empty"))),
        ("no such run", lambda: run_page.run_page(desk, "small/20200101-000000-00000000")),
    ):
        other = Visit()
        with other.client:
            make()
        other.shows(words)
        visit.text += other.text
    return visit.text


async def run_pages(folder: Path) -> list[str]:
    """The page of a run with no test, one, two, one taken away; two runs chosen and compared."""
    desk, visit = desk_of(folder), Visit()
    first = kept(desk.workspace)
    for make in (
        lambda: compare_page.compare_page(desk, "", ""),
        lambda: run_page.run_page(desk, first),
    ):
        with (other := Visit()).client:
            make()
        other.shows("one run")
        visit.text += other.text
    desk.workspace.new_case("small", "uniform-spring")
    second = kept(desk.workspace, created="2026-02-01T00:00:00+00:00")
    run = desk.workspace.run(first)
    with visit.client:
        panel = run_page.RunTests(desk, run)
        for name in ("one.csv", "two.csv"):
            keep_test(run, name, b"cam angle [deg],spring force [N]\n0,1\n1,2\n")
            panel.arrived(event(test=name))
            visit.shows(f"sent {name}")
        panel.remove("one.csv")
        panel.remove("none.csv")
        visit.shows("one taken away, one that is not there")
    for a, b in (("", ""), (first, second), (second, ""), ("a b", "c&d")):
        with (other := Visit()).client:
            compare_page.compare_page(desk, a, b)
        other.shows(f"compare '{a}' '{b}'")
        visit.text += other.text
    with (other := Visit()).client:
        run_page.run_page(desk, second)
    other.shows("run with its case")
    return visit.text + other.text


def figure(key: str, scale: float, low: float | None) -> str:
    """A figure as a report holds it: one line, one mark, two axes of y of which one has no range."""
    traces = [{"name": "force", "mode": "lines", "y": [scale, 2 * scale], "line": {"color": "red"}},
              {"mode": "markers", "y": [scale]}, {"mode": "lines", "yaxis": "y2", "y": [3 * scale], "line": {}},
              {"mode": "lines", "yaxis": "y3", "y": [4 * scale], "line": {}}]  # fmt: skip
    axes = {
        "yaxis": {"range": [low, 5 * scale]} if low is not None else {},
        "yaxis2": {},
        "xaxis": {"range": [0, scale]},
    }
    return f'<script type="application/json" id="data-{key}">{json.dumps({"data": traces, "layout": axes, "narrow": axes})}</script>'


async def comparisons(folder: Path) -> list[str]:
    """Two runs over each other: figures that both have, inputs and results that differ; the same
    run twice; runs without a report.
    """
    desk, runs = desk_of(folder), []
    for day, (text, speeds, models, force) in enumerate(
        (
            (SMALL, [4000.0], ["massless"], 550.0),
            (SMALL.replace("32 N/mm", "41 N/mm"), [1000.0, 2000.0, 3000.0, 4000.0], [], 600.0),
            (SMALL, [1000.0, 2000.0, 3000.0, 4000.0, 5000.5], ["multi-mass", "massless"], 550.0),
            (SMALL, [], ["massless"], 550.0),
        )
    ):
        at = datetime(2026, 1, day + 1, 12, tzinfo=UTC)
        inputs = Inputs(
            "small",
            text,
            {},
            {"spring_models": models, "engine_speeds": speeds, "spring_sets": ["a", "b"][:day]},
        )
        place = new_folder(inputs, at, desk.workspace.runs_folder)
        if day < 3:
            keys = (
                ("force-retainer", 1.0 + day, 0.5 if day < 2 else None),
                ("static-1", 2.0, 1.0 + day),
                ("own", 1.0, 1.0),
            )[day // 2 :]
            (place / "report.html").write_text(
                "".join(figure(*one) for one in keys), encoding="utf-8"
            )
        told = {
            "case": "small", "command": ("run", "run-up", "static", "odd")[day], "created_at": at.isoformat()[: 19 - day],
            "completed": day != 1, "failures": ["one", "two"][:day], "choices": inputs.choices,
            "quantities": {"peak_spring_force": {"value": force, "unit": "N"}},
        }  # fmt: skip
        runs.append(
            keep(place, inputs, told).folder.relative_to(desk.workspace.runs_folder).as_posix()
        )
    visit = Visit()
    with visit.client:
        run_page.runs_page(desk)
        for one in runs:
            run_page.run_page(desk, one)
        compare_page.compare_page(desk, runs[2], "")
    visit.shows("runs of all kinds")
    for a, b in ((0, 1), (1, 0), (0, 2), (2, 0), (2, 3), (0, 0)):
        try:
            text = compare_page.comparison_part(desk, runs[a], runs[b])
        except InputError as error:
            text = str(error)
        visit.text += [
            f"== {a} and {b}",
            *re.sub(r"(?=<(?:tr|section|script|figure|h2))", "\n", text).splitlines(),
        ]
    return visit.text


async def case_pages(folder: Path) -> list[str]:
    """Cases of every kind at first: a card, a spring of a published case, trains, one that does not
    read, one that is not there.
    """
    desk, told = desk_of(folder), list[str]()
    for name in (
        "spring",
        "direct",
        "finger",
        "rocker",
        "pushrod",
        "gu2021-beehive",
        "tdi-pushrod",
        "vaz-ohc",
        "job-c",
    ):
        own = desk.workspace.new_case(f"my-{name}", name)
        with (visit := Visit()).client:
            await case_page.case_page(desk, own)
        visit.shows(name)
        told += visit.text
    with (visit := Visit()).client:
        await case_page.case_page(desk, "none")
    visit.shows("no such case")
    return told + visit.text


async def visits(folder: Path) -> list[str]:
    """One visit of a case: values taken and refused, tables added and removed, files, the slider,
    jobs and their runs, a copy.
    """
    desk, visit = desk_of(folder), Visit()
    desk.workspace.upload("small", SMALL.encode())
    text = desk.workspace.text("small")
    with visit.client, pytest.MonkeyPatch.context() as patch:
        patch.setattr(ui.navigate, "to", lambda place: visit.text.append(f"-> to {place}"))
        patch.setattr(ui, "notify", lambda words: visit.text.append(f"-> said {words}"))
        patch.setattr(
            desk,
            "chain",
            lambda case: (desk.chains.setdefault(case, OpenChain(Chain(), text, ())), Chain.case),
        )  # type: ignore[arg-type]
        page = case_page.CasePage(desk, "small", text, desk.workspace.parse("small", text))
        page.build()
        for one in (page.form, page.slider, page.order, page.panel, page.results):
            visit.hears(one)
        visit.shows("first")
        for key, value in (
            ("spring.rate", "41 N/mm"),
            ("spring.rate", "41 furlong"),
            ("lift_law.kind", "measured"),
            ("title", "Own"),
        ):
            await page.change(event(key=key, value=value))
        visit.shows("changed")
        for key in ("spring.damping", "spring.1"):
            await page.add(event(key=key))
        visit.shows("added")
        for key in ("spring.damping", "spring.1"):
            await page.remove(event(key=key))
        desk.workspace.attach("small", "lift.csv", b"0 1\n" * 700)
        await page.beside.changed()
        visit.shows("a file came")
        await page.beside.remove("none.csv")
        visit.shows("a file that is not there was removed")
        await page.beside.remove("lift.csv")
        await page.begin()
        for key, value in (
            ("spring.rate", "45 N/mm"),
            ("engine_speed", "5000 rpm"),
            ("engine_speed", "none"),
            ("engine_speed", "wrong"),
        ):
            await page.move(event(key=key, value=value))
            await page.rest(event(key=key, value=value))
        await page.rest(event(key="spring.rate", value="46 N/mm"))
        with pytest.raises(InterruptedError):
            page.moving()
        for key, value in (
            ("spring.0.rate", "45 N/mm"),
            ("engine_speed", "5000 rpm"),
            ("spring.0.rate", "45 rpm"),
        ):
            await page.keep(event(key=key, value=value))
        await jobs(desk, visit, page)
        await page.copy()
        patch.setattr(
            desk.workspace,
            "duplicate",
            lambda *_: (_ for _ in ()).throw(InputError("the disk is full", "workspace")),
        )
        await page.copy()
    return [*visit.text, desk.workspace.text("small")]


async def jobs(desk: Desk, visit: Visit, page: Any) -> None:
    """What is asked for, estimated, begun, looked at, cancelled, begun again."""
    asked: dict[str, Any] = {
        "kind": "run",
        "models": ["multi-mass", "massless"],
        "speeds": "4000 rpm",
    }
    chain = asked | {"models": ["multi-mass"]}
    for wish in (
        asked,
        chain,
        chain | {"speeds": "1 rpm"},
        {"kind": "study"},
        chain | {"speeds": "1 rpm"},
        chain,
    ):
        await page.estimate(event(**wish))
        visit.text.append(
            f"-> order {page.order.props['estimate']!r} {page.order.props['refusal']!r}"
        )
    sweep = asked | {"kind": "sweep", "speeds": "1000:2000:500 rpm", "sets": ["a", "b"]}
    for wish in (asked, sweep, asked | {"models": []}, asked | {"speeds": "1 rpm"}):
        await page.start(event(**wish))
        visit.text.append(
            f"-> order {page.order.props['estimate']!r} {page.order.props['refusal']!r}"
        )
    visit.text += [*desk.jobs.told, json.dumps(desk.workspace.remembered("small"))]  # type: ignore[attr-defined]
    page.cancel()
    await page.again()
    first = kept(desk.workspace)
    states: tuple[dict[str, Any], ...] = (
        {"state": "queued"}, {"state": "running", "share": 0.256, "text": "run 1 of 4", "seconds_left": 42.4},
        {"state": "running", "share": 0.5, "seconds_left": 600.0}, {"state": "cancelled"}, {"state": "cancelled", "run_id": first},
        {"state": "failed", "error": "a wire of 4 m is no wire"}, {"state": "finished", "run_id": first},
    )  # fmt: skip
    for number, more in enumerate(states):
        desk.jobs.newest = JobStatus(
            str(number + 4), "small", ("run", "sweep", "study", "compare")[number % 4], **more
        )  # type: ignore
        page.looks = -1
        await page.look()
        visit.text.append(f"-> job {page.panel.props['job']} busy {page.order.props['busy']}")
    page.cancel()
    await page.again()
    page.job = replace(desk.jobs.newest, job_id="9")  # type: ignore[attr-defined]
    await page.again()
    visit.text += desk.jobs.told  # type: ignore[attr-defined]
    for day in range(11):
        kept(desk.workspace, created=f"2026-02-{day + 1:02d}T08:00:00+00:00")
    for run in ("", first, "small/20200101-000000-00000000"):
        await page.show_run(run)
        visit.shows(f"runs, shown '{run}'")
        visit.text.append(f"-> shown {page.shown_run}")
    page.shown_run, desk.jobs.newest = "", JobStatus("12", "small", "run", "running")  # type: ignore[attr-defined]
    page.looks = -1
    await page.look()
    visit.text.append(f"-> shown {page.shown_run}")
    for _ in range(11):
        desk.jobs.newest = None
        await page.look()
        visit.text.append(f"-> job {page.panel.props['job']}")


MADE: dict[str, Callable[[Path], Coroutine[Any, Any, list[str]]]] = {
    one.__name__: one for one in (home_pages, run_pages, comparisons, case_pages, visits)
}


def told(name: str) -> str:
    async def made(folder: Path) -> list[str]:
        core.loop = asyncio.get_running_loop()
        try:
            return await MADE[name](folder)
        finally:
            core.loop = None

    with tempfile.TemporaryDirectory() as folder:
        return "\n".join(asyncio.run(made(Path(folder)))).replace(folder, "FOLDER") + "\n"


@pytest.mark.skipif(not are_same(), reason="kept with other versions of Python or of libraries")
@pytest.mark.parametrize("name", MADE)
def test_the_pages_hold_what_they_held(name):
    assert told(name) == (PAGES / f"{name}.txt").read_text(encoding="utf-8")


if __name__ == "__main__":
    for name in MADE:
        (PAGES / f"{name}.txt").write_text(told(name), encoding="utf-8")
