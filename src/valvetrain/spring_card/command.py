"""``valvetrain spring-card``: a spring from its catalogue card or from the table of a spring
tester.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import (
    JsonOption,
    OpenOption,
    OutputOption,
    QuietOption,
    asks,
    take_folder,
)
from valvetrain.cli.run_answer import SavedRequest, keep_run, show_page
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.report.page import Page
    from valvetrain.spring_card.card import SpringLoad
    from valvetrain.spring_card.fit import SpringFit
    from valvetrain.spring_card.tester import TesterFit


#: Name of a spring that is given none.
SPRING = "spring"


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("spring-card")(spring_card)


def spring_card(
    table: Annotated[
        Path | None,
        typer.Argument(
            metavar="[TABLE]", help="File of a spring tester; without it give two loads."
        ),
    ] = None,
    wire_diameter: Annotated[
        str | None, asks("--wire-diameter", "LENGTH", "Diameter of the wire, such as '4.2 mm'.")
    ] = None,
    outer_diameter: Annotated[
        str | None, asks("--outer-diameter", "LENGTH", "Outer diameter of the coils.")
    ] = None,
    top_outer_diameter: Annotated[
        str | None,
        asks("--top-outer-diameter", "LENGTH", "Of a beehive: outer diameter at the top."),
    ] = None,
    taper_from_coil: Annotated[
        float | None, asks("--taper-from-coil", "TURNS", "Of a beehive: where it begins to taper.")
    ] = None,
    installed: Annotated[
        str | None,
        asks("--installed", "HEIGHT, LOAD", "Height and load closed, such as '1.80 in, 130 lbf'."),
    ] = None,
    open_: Annotated[
        str | None,
        asks("--open-load", "HEIGHT, LOAD", "Height and load open, such as '1.25 in, 350 lbf'."),
    ] = None,
    installed_height: Annotated[
        str | None,
        asks("--installed-height", "LENGTH", "With a table: height of the closed valve."),
    ] = None,
    solid_height: Annotated[
        str | None, asks("--solid-height", "LENGTH", "Height at coil bind.")
    ] = None,
    mass: Annotated[str | None, asks("--mass", "MASS", "Mass of the spring.")] = None,
    free_length: Annotated[str | None, asks("--free-length", "LENGTH", "Unloaded length.")] = None,
    total_coils: Annotated[
        float | None, asks("--total-coils", "TURNS", "All turns, tip to tip.")
    ] = None,
    material: Annotated[
        str, asks("--material", "NAME", "Wire by name (default: EN 10270-2 VDSiCr).")
    ] = "",
    closes: Annotated[
        str,
        typer.Option(
            "--closes", metavar="END", help="With a table: where coils close first (upper, both)."
        ),
    ] = "lower",
    columns: Annotated[
        str, asks("--columns", "WORDS", "With a table: 'height, force' (or compression, ignore).")
    ] = "",
    length_unit: Annotated[
        str, asks("--length-unit", "UNIT", "With a table: unit of heights.")
    ] = "",
    force_unit: Annotated[str, asks("--force-unit", "UNIT", "With a table: unit of forces.")] = "",
    name: Annotated[
        str, typer.Option("--name", metavar="NAME", help="Name of the spring in the results.")
    ] = SPRING,
    output: OutputOption = None,
    open_page: OpenOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Spring definition from a catalogue card or a spring tester's table, fitted to its loads, with
    the assumptions made.
    """
    from valvetrain.parameters.material import material_by_name
    from valvetrain.spring_card.card import CatalogueCard
    from valvetrain.units import parse_quantity

    take_folder(output)
    for flag, value, typical in (
        ("--wire-diameter", wire_diameter, "4.2 mm"),
        ("--outer-diameter", outer_diameter, "32 mm"),
    ):
        if value is None:
            raise InputError(
                f"the card needs the {flag[2:].replace('-', ' ')}; give it, such as {flag} '{typical}'",
                flag,
            )

    def length(value: str | None, flag: str) -> float | None:
        return None if value is None else parse_quantity(value, "length", flag)

    known: dict[str, Any] = {
        "wire_diameter": length(wire_diameter, "--wire-diameter"), "outer_diameter": length(outer_diameter, "--outer-diameter"),
        "top_outer_diameter": length(top_outer_diameter, "--top-outer-diameter"), "taper_from_coil": taper_from_coil,
        "solid_height": length(solid_height, "--solid-height"), "free_length": length(free_length, "--free-length"),
        "mass": None if mass is None else parse_quantity(mass, "mass", "--mass"), "total_coils": total_coils,
        "material": material_by_name(material) if material else None, "name": name,
    }  # fmt: skip
    request = _Request(name, output, datetime.now(UTC).replace(microsecond=0), open_page)
    if table is None:
        from valvetrain.spring_card.fit import spring_from_card

        if installed_height is not None:
            raise InputError(
                "the height of the closed valve belongs in --installed 'HEIGHT, LOAD' where there is no table",
                "--installed-height",
            )
        loads = [
            _load(text, flag) for flag, text in (("--installed", installed), ("--open-load", open_))
        ]
        return _show_card(
            spring_from_card(CatalogueCard(installed_load=loads[0], open_load=loads[1], **known)),
            request,
        )
    if installed is not None or open_ is not None:
        raise InputError(
            "a table holds the loads; leave --installed and --open-load out, or the table",
            "--installed",
        )
    from valvetrain.cli.progress import busy
    from valvetrain.measured.force_height import read_force_height
    from valvetrain.spring_card.tester import card_from_table, read_end, spring_from_tester

    names = tuple(word.strip() for word in columns.split(",") if word.strip())
    found = read_force_height(
        table,
        columns=names,
        length_unit=length_unit,
        force_unit=force_unit,
        free_length=known["free_length"],
    )
    with busy("fitting the spring to the table"):
        fit = spring_from_tester(
            found,
            card_from_table(found, **known),
            read_end(closes),
            length(installed_height, "--installed-height"),
        )
    return _show_tester(fit, request)


@dataclass(frozen=True)
class _Request:
    """Where an answer goes."""

    name: str
    output: Path | None
    created_at: datetime
    open_page: bool

    @property
    def case_name(self) -> str:
        """Name of the case that is written: that of the spring where one is given, else of its folder,
        to distinguish two springs that are compared.
        """
        if self.name != SPRING:
            return self.name
        folder = "" if self.output is None else self.output.name
        return folder if re.fullmatch(r"[\w-]+", folder) else "spring-card"


def _load(text: str | None, flag: str) -> SpringLoad:
    """A load of text such as ``1.80 in, 130 lbf``."""
    from valvetrain.spring_card.card import SpringLoad

    parts = [part.strip() for part in (text or "").split(",")]
    if len(parts) != 2:
        raise InputError(
            f"a card has two loads, each with its height: give {flag} 'HEIGHT, LOAD', such as '1.80 in, 130 lbf'",
            flag,
        )
    return SpringLoad(*parts)


def _deliver(
    request: _Request,
    fit: SpringFit | TesterFit,
    page: Page,
    data: dict[str, Any],
    source: str,
    show: Any,
) -> None:
    """Write the folder (page, block of the spring, run.json) and report it."""
    from valvetrain.cli.outcome import Outcome, deliver
    from valvetrain.parameters.loading import parse_case
    from valvetrain.report.files import spring_text
    from valvetrain.report.page import render
    from valvetrain.report.verdict import verdict_of
    from valvetrain.solution.atomic import write_text

    text = spring_text(request.case_name, fit.spring, source)
    pages: list[Path] = []

    def fill(folder: Path) -> list[Path]:
        pages.append(write_text(folder / "report.html", render(page)))
        return [write_text(folder / "spring.toml", text), *pages]

    folder, files = keep_run(
        SavedRequest(
            "spring-card", parse_case(text, request.case_name), request.output, request.created_at
        ),
        text,
        {"name": request.name},
        data,
        fill,
    )
    if request.open_page:
        show_page(pages[0])
    data |= {"folder": str(folder), "files": files, "page": str(pages[0])}

    def show_text(console: Console) -> None:
        show(console)
        for sentence in fit.free:
            console.print(f"{sentence[:1].upper()}{sentence[1:]}.", soft_wrap=True)
        console.print()
        console.print(
            f"the spring for a case file: {folder / 'spring.toml'}; page: {pages[0]}",
            soft_wrap=True,
        )

    deliver(Outcome(data, show_text, (), verdict_of(fit)))


def _show_card(fit: SpringFit, request: _Request) -> None:
    from valvetrain.cli.outcome import plain_table
    from valvetrain.spring_card.page import card_page, held_rows, spring_rows

    def show(console: Console) -> None:
        console.print(
            plain_table(
                ("", "card", "spring", "", "difference"), held_rows(fit.held), right=(1, 2, 4)
            )
        )
        console.print()
        console.print(plain_table(("the spring", "", ""), spring_rows(fit.spring), right=(1,)))
        console.print()
        console.print(f"{fit.in_engine}.", soft_wrap=True)

    data: dict[str, Any] = {
        "command": "spring-card", "case": "", "completed": True, "left_free": list(fit.free), "in_engine": fit.in_engine,
        "card": {one.quantity: {"asked": one.requested, "found": one.found} for one in fit.held},
    }  # fmt: skip
    _deliver(request, fit, card_page(fit), data, "from a catalogue card", show)


def _show_tester(fit: TesterFit, request: _Request) -> None:
    from valvetrain.cli.outcome import plain_table
    from valvetrain.spring_card.page import spring_rows, tester_page, tester_rows

    def show(console: Console) -> None:
        console.print(f"{fit.table!r}", soft_wrap=True)
        rows = [
            (names, value, spread and f"±{spread}", unit)
            for names, value, spread, unit in tester_rows(fit)
        ]
        console.print(plain_table(("", "value", "95 %", ""), rows, right=(1, 2)))
        console.print()
        stations = zip(fit.stations.coil, fit.stations.pitch, fit.stations.spread, strict=True)
        law = [
            (f"{coil:.2f}", f"{1e3 * pitch:.3f}", f"±{2e3 * spread:.2g}", "mm")
            for coil, pitch, spread in stations
        ]
        console.print(plain_table(("coil", "pitch", "95 %", ""), law, right=(0, 1, 2)))
        console.print()
        console.print(plain_table(("the spring", "", ""), spring_rows(fit.spring), right=(1,)))
        console.print()
        for note in fit.table.notes:
            console.print(f"{note[:1].upper()}{note[1:]}.", soft_wrap=True)

    def spread(pair: tuple[float, float]) -> dict[str, float]:
        return {"value": pair[0], "standard_deviation": pair[1]}

    data: dict[str, Any] = {
        "command": "spring-card", "case": "", "completed": True, "left_free": list(fit.free), "notes": list(fit.table.notes),
        "active_coils": spread(fit.active_coils), "free_length": spread(fit.free_length), "rate": spread(fit.rate),
        "preload": spread(fit.preload), "coil_bind_height": fit.coil_bind, "scatter": fit.scatter, "worst_by_rod": fit.worst_by_rod,
        "pitch": [
            {"coil": coil, "pitch": pitch, "standard_deviation": sd}
            for coil, pitch, sd in zip(fit.stations.coil.tolist(), fit.stations.pitch.tolist(), fit.stations.spread.tolist(), strict=True)
        ],
    }  # fmt: skip
    _deliver(request, fit, tester_page(fit), data, "from a table of forces", show)
