"""``valvetrain spring-card``: a spring from its catalogue card or from the table of a spring
tester.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import (
    JsonOption,
    OpenOption,
    OutputOption,
    QuietOption,
    UnitsOption,
    asking,
    take_folder,
    take_units,
)
from valvetrain.cli.outcome import deliver
from valvetrain.cli.run_answer import SavedRequest, saved_result
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from valvetrain.spring_card.card import SpringLoad
    from valvetrain.spring_card.fit import SpringFit
    from valvetrain.spring_card.tester import TesterFit


#: Name of a spring that is given none.
SPRING = "spring"


#: Field of :class:`CatalogueCard` -> its option, what follows that, and its help.
SIZES = {
    "wire_diameter": ("--wire-diameter", "LENGTH", "Diameter of the wire, such as '4.2 mm'."),
    "outer_diameter": ("--outer-diameter", "LENGTH", "Outer diameter of the coils."),
    "top_outer_diameter": ("--top-outer-diameter", "LENGTH", "Of a beehive: outer diameter at the top."),
    "taper_from_coil": ("--taper-from-coil", "TURNS", "Of a beehive: where it begins to taper."),
    "solid_height": ("--solid-height", "LENGTH", "Height at coil bind."),
    "mass": ("--mass", "MASS", "Mass of the spring."),
    "free_length": ("--free-length", "LENGTH", "Unloaded length."),
    "total_coils": ("--total-coils", "TURNS", "All turns, tip to tip."),
    "material": ("--material", "NAME", "Wire by name (default: EN 10270-2 VDSiCr)."),
    "name": ("--name", "NAME", "Name of the spring in the results."),
}  # fmt: skip
#: Further questions, in the same way.
ASKED = SIZES | {
    "installed": ("--installed", "HEIGHT, LOAD", "Height and load closed, such as '1.80 in, 130 lbf'."),
    "open_load": ("--open-load", "HEIGHT, LOAD", "Height and load open, such as '1.25 in, 350 lbf'."),
    "installed_height": ("--installed-height", "LENGTH", "With a table: height of the closed valve."),
    "closes": ("--closes", "END", "With a table: where coils close first (lower, upper, both)."),
    "columns": ("--columns", "WORDS", "With a table: 'height, force' (or compression, ignore)."),
    "length_unit": ("--length-unit", "UNIT", "With a table: unit of heights."),
    "force_unit": ("--force-unit", "UNIT", "With a table: unit of forces."),
}  # fmt: skip


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("spring-card")(asking(spring_card, ASKED))


def spring_card(
    table: Annotated[
        Path | None,
        typer.Argument(
            metavar="[TABLE]", help="File of a spring tester; without it give two loads."
        ),
    ] = None,
    output: OutputOption = None,
    open_page: OpenOption = False,
    units: UnitsOption = "si",
    as_json: JsonOption = False,
    quiet: QuietOption = False,
    *,
    answers: dict[str, Any],
) -> None:
    """Spring definition from a catalogue card or a spring tester's table, fitted to its loads, with
    the assumptions made.
    """
    from valvetrain.parameters.material import material_by_name
    from valvetrain.spring_card.card import CatalogueCard
    from valvetrain.units import parse_quantity

    take_folder(output)
    take_units(units)
    alone = table is not None and not {"wire_diameter", "outer_diameter"} & {*answers}
    for key, typical in (("wire_diameter", "4.2 mm"), ("outer_diameter", "32 mm")):
        if key not in answers and not alone:
            flag = SIZES[key][0]
            raise InputError(
                f"the card needs the {key.replace('_', ' ')}; give it, such as {flag} '{typical}'",
                flag,
            )
    for key in ("free_length", "installed_height"):
        if key in answers:
            answers[key] = parse_quantity(answers[key], "length", ASKED[key][0])
    if "material" in answers:
        answers["material"] = material_by_name(answers["material"])
    sizes = {name: answers[name] for name in SIZES if name in answers}
    given, name = answers.get, answers.get("name", SPRING)
    if table is None:
        from valvetrain.spring_card.fit import spring_from_card

        if "installed_height" in answers:
            raise InputError(
                "the height of the closed valve belongs in --installed 'HEIGHT, LOAD' where there is no table",
                "--installed-height",
            )
        loads = [_load(given(key), ASKED[key][0]) for key in ("installed", "open_load")]
        met = spring_from_card(CatalogueCard(installed_load=loads[0], open_load=loads[1], **sizes))
        return _deliver(met, _card_data(met), name, output, open_page)
    if {"installed", "open_load"} & {*answers}:
        raise InputError(
            "a table holds the loads; leave --installed and --open-load out, or the table",
            "--installed",
        )
    from valvetrain.cli.progress import busy
    from valvetrain.measured.force_height import read_force_height
    from valvetrain.spring_card.tester import card_from_table, read_end, spring_from_tester

    found = read_force_height(
        table,
        columns=tuple(filter(None, map(str.strip, given("columns", "").split(",")))),
        length_unit=given("length_unit", ""),
        force_unit=given("force_unit", ""),
        free_length=given("free_length"),
    )
    with busy("fitting the spring to the table"):
        card = None if alone else card_from_table(found, **sizes)
        end = read_end(given("closes", "lower"))
        fit = spring_from_tester(found, card, end, given("installed_height"), name)
    return _deliver(fit, _table_data(fit), name, output, open_page)


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


def _case_name(name: str, output: Path | None) -> str:
    """Name of the case that is written: that of the spring where one is given, else of its folder, to distinguish two springs
    that are compared.
    """
    folder = "" if output is None else output.name
    if name != SPRING:
        return name
    return folder if re.fullmatch(r"[\w-]+", folder) else "spring-card"


def _deliver(
    fit: SpringFit | TesterFit,
    found: dict[str, Any],
    name: str,
    output: Path | None,
    open_page: bool,
) -> None:
    """Write the folder (page, block of the spring, run.json) and report it."""
    from valvetrain.parameters.loading import parse_case
    from valvetrain.solution.atomic import write_text
    from valvetrain.spring_card.answer import CardAnswer
    from valvetrain.spring_card.rules import CardFacts
    from valvetrain.views.files import spring_text

    case, facts = _case_name(name, output), CardFacts(fit)
    source = f"from a {'catalogue card' if facts.by_card else 'table of forces'}"
    text = spring_text(case, fit.spring, source)
    outcome = saved_result(
        SavedRequest("spring-card", parse_case(text, case), output), text,
        {"command": "spring-card", "case": "", "completed": True, **found},
        lambda folder: CardAnswer(replace(facts, file=str(folder / "spring.toml"))),
        lambda folder: [write_text(folder / "spring.toml", text)], {"name": name}, open_page,
    )  # fmt: skip
    deliver(outcome)


def _card_data(fit: SpringFit) -> dict[str, Any]:
    """Every number of the card (SI) and that of the spring."""
    return {
        "card": {one.quantity: {"asked": one.requested, "found": one.found} for one in fit.held}
    }


def _table_data(fit: TesterFit) -> dict[str, Any]:
    """What the table gives (SI), with standard deviations."""
    from valvetrain.measured.json import json_estimate

    data: dict[str, Any] = {
        "height": fit.height,
        "reaches_coil_bind": fit.bound,
        "scatter": fit.table.curve.scatter,
    }
    for name in ("free_length", "rate", "preload", "solid_height"):
        pair = getattr(fit, name)
        data[name] = None if pair is None else json_estimate(pair)
    if (wire := fit.wire) is None:
        return data
    law = wire.stations
    rows = zip(law.coil, law.pitch, law.spread, strict=True)
    return data | {
        "active_coils": json_estimate(wire.active_coils),
        "worst_by_rod": wire.worst_by_rod,
        "pitch": [{"coil": coil, "pitch": pitch, "standard_deviation": sd} for coil, pitch, sd in rows],
    }  # fmt: skip
