"""``valvetrain spring-card``: a spring from its catalogue card or from the table of a spring
tester.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.cli.request import FolderLine, command_of
from valvetrain.errors import InputError
from valvetrain.runs.request_fields import (
    Fields,
    option,
    read_choice,
    read_path,
    read_positive,
    read_text,
    read_words,
)

if TYPE_CHECKING:
    from valvetrain.spring_card.card import SpringLoad
    from valvetrain.spring_card.fit import SpringFit
    from valvetrain.spring_card.tester import Closes, TesterFit

#: Name of a spring that is given none.
SPRING = "spring"
LENGTH = partial(read_positive, "length")
#: Sizes of a card that :class:`CatalogueCard` takes.
SIZES = (
    "wire_diameter", "outer_diameter", "top_outer_diameter", "taper_from_coil", "solid_height", "mass", "free_length", "total_coils", "name"
)  # fmt: skip


def read_load(given: Any, where: str) -> SpringLoad:
    """A load of text such as ``1.80 in, 130 lbf``."""
    from valvetrain.spring_card.card import SpringLoad

    parts = read_words(given, where)
    if len(parts) != 2:
        raise InputError(
            "a card has two loads, each with its height: 'HEIGHT, LOAD', such as '1.80 in, 130 lbf'",
            where,
        )
    return SpringLoad(*parts)


@dataclass(frozen=True, kw_only=True)
class CardRequest(Fields):
    """A spring by its card, or by a table of forces."""

    command = "spring-card"

    table: Path | None = option(
        read_path, "File of a spring tester; without it give two loads.", metavar="[TABLE]"
    )
    wire_diameter: str = option(
        read_text,
        "Diameter of the wire, such as '4.2 mm'.",
        "--wire-diameter",
        "LENGTH",
        default="",
    )
    outer_diameter: str = option(
        read_text, "Outer diameter of the coils.", "--outer-diameter", "LENGTH", default=""
    )
    top_outer_diameter: str = option(
        read_text,
        "Of a beehive: outer diameter at the top.",
        "--top-outer-diameter",
        "LENGTH",
        default="",
    )
    taper_from_coil: str = option(
        read_text,
        "Of a beehive: where it begins to taper.",
        "--taper-from-coil",
        "TURNS",
        default="",
    )
    solid_height: str = option(
        read_text, "Height at coil bind.", "--solid-height", "LENGTH", default=""
    )
    mass: str = option(read_text, "Mass of the spring.", "--mass", "MASS", default="")
    free_length: float | None = option(LENGTH, "Unloaded length.", "--free-length", "LENGTH")
    total_coils: str = option(
        read_text, "All turns, tip to tip.", "--total-coils", "TURNS", default=""
    )
    material: str = option(
        read_text, "Wire by name (default: EN 10270-2 VDSiCr).", "--material", "NAME", default=""
    )
    name: str = option(
        read_text, "Name of the spring in the results.", "--name", "NAME", default=SPRING
    )
    installed: SpringLoad | None = option(
        read_load,
        "Height and load closed, such as '1.80 in, 130 lbf'.",
        "--installed",
        "HEIGHT, LOAD",
    )
    open_load: SpringLoad | None = option(
        read_load,
        "Height and load open, such as '1.25 in, 350 lbf'.",
        "--open-load",
        "HEIGHT, LOAD",
    )
    installed_height: float | None = option(
        LENGTH, "With a table: height of the closed valve.", "--installed-height", "LENGTH"
    )
    closes: Closes = option(
        partial(read_choice, ("lower", "upper", "both")),
        "With a table: where coils close first.",
        "--closes",
        "lower|upper|both",
        default="lower",
    )
    columns: tuple[str, ...] = option(
        read_words,
        "With a table: 'height, force' (or compression, ignore).",
        "--columns",
        "WORDS",
        default=(),
    )
    length_unit: str = option(
        read_text, "With a table: unit of heights.", "--length-unit", "UNIT", default=""
    )
    force_unit: str = option(
        read_text, "With a table: unit of forces.", "--force-unit", "UNIT", default=""
    )

    def __post_init__(self) -> None:
        """Raise :class:`InputError` for a card without its sizes, and for what belongs to a table or to a card alone."""
        for key, typical in (("wire_diameter", "4.2 mm"), ("outer_diameter", "32 mm")):
            if not (getattr(self, key) or self.alone):
                name = key.replace("_", " ")
                raise InputError(f"the card needs the {name}; give it, such as '{typical}'", key)
        if self.table is None and self.installed_height is not None:
            raise InputError(
                "the height of the closed valve belongs in --installed 'HEIGHT, LOAD' where there is no table",
                "installed_height",
            )
        if self.table is not None and self.table.suffix == ".toml":
            raise InputError(
                f"'{self.table}' is a case, and no table of measured forces; 'valvetrain static {self.table}' gives the loads of its springs",
                "table",
            )
        if self.table is not None and (self.installed or self.open_load):
            raise InputError(
                "a table holds the loads; leave --installed and --open-load out, or the table",
                "installed",
            )
        for key in ("installed", "open_load"):
            if self.table is None and getattr(self, key) is None:
                read_load("", key)

    @property
    def alone(self) -> bool:
        """Whether a table is given without the sizes of a wire."""
        return self.table is not None and not (self.wire_diameter or self.outer_diameter)

    @property
    def sizes(self) -> dict[str, Any]:
        """What the card says besides its loads."""
        from valvetrain.parameters.material import material_by_name

        sizes = {name: value for name in SIZES if (value := getattr(self, name))}
        return sizes | ({"material": material_by_name(self.material)} if self.material else {})


def spring_card(request: CardRequest, line: FolderLine, _: Path) -> None:
    """Spring definition from a catalogue card or a spring tester's table, fitted to its loads, with
    the assumptions made.
    """
    from valvetrain.cli.progress import busy
    from valvetrain.measured.force_height import read_force_height
    from valvetrain.spring_card.card import CatalogueCard
    from valvetrain.spring_card.fit import spring_from_card
    from valvetrain.spring_card.tester import card_from_table, spring_from_tester

    sizes = request.sizes
    if request.table is None:
        assert request.installed is not None and request.open_load is not None
        loads = request.installed, request.open_load
        met = spring_from_card(CatalogueCard(installed_load=loads[0], open_load=loads[1], **sizes))
        rows = {one.quantity: {"asked": one.requested, "found": one.found} for one in met.held}
        return _deliver(met, {"card": rows}, request, line)
    table = read_force_height(
        request.table,
        columns=request.columns,
        length_unit=request.length_unit,
        force_unit=request.force_unit,
        free_length=request.free_length,
    )
    with busy("fitting the spring to the table"):
        card = None if request.alone else card_from_table(table, **sizes)
        fit = spring_from_tester(
            table, card, request.closes, request.installed_height, request.name
        )
    return _deliver(fit, _table_data(fit), request, line)


register = command_of(CardRequest, FolderLine, spring_card)


def _case_name(name: str, output: Path | None) -> str:
    """Name of the case that is written: that of the spring where one is given, else of its folder, to distinguish two springs
    that are compared.
    """
    folder = "" if output is None else output.name
    if name != SPRING:
        return name
    return folder if re.fullmatch(r"[\w-]+", folder) else "spring-card"


def _deliver(
    fit: SpringFit | TesterFit, numbers: dict[str, Any], request: CardRequest, line: FolderLine
) -> None:
    """Write the folder (page, block of the spring, run.json) and report it."""
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.run_answer import SavedRequest, saved_result
    from valvetrain.parameters.loading import parse_case
    from valvetrain.solution.atomic import write_text
    from valvetrain.spring_card.answer import CardAnswer
    from valvetrain.spring_card.rules import CardFacts
    from valvetrain.views.files import spring_text

    case, facts = _case_name(request.name, line.output), CardFacts(fit)
    source = f"from a {'catalogue card' if facts.by_card else 'table of forces'}"
    text = spring_text(case, fit.spring, source)
    outcome = saved_result(
        SavedRequest("spring-card", parse_case(text, case), line.output), text,
        {"command": "spring-card", "case": "", "completed": True, **numbers},
        lambda folder: CardAnswer(replace(facts, file=str(folder / "spring.toml"))),
        lambda folder: [write_text(folder / "spring.toml", text)], request.given, line.open_page,
    )  # fmt: skip
    deliver(outcome)


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
