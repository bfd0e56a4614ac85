"""``valvetrain findings`` and ``quantities``: what a finding or a number of a result means."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from valvetrain.cli.outcome import Outcome, deliver, plain_table
from valvetrain.cli.request import AnswerLine, command_without_case
from valvetrain.errors import InputError
from valvetrain.runs.request_fields import option, read_text


@dataclass(frozen=True, kw_only=True)
class FindingsLine(AnswerLine):
    """The command line of ``findings``."""

    code: str = option(
        read_text,
        "Code of a finding, such as C101; all without one.",
        metavar="[CODE]",
        default="",
    )


@dataclass(frozen=True, kw_only=True)
class QuantitiesLine(AnswerLine):
    """The command line of ``quantities``."""

    words: str = option(
        read_text,
        "Words of the name or its label, such as 'spring force'; all quantities without any.",
        metavar="[WORDS]",
        default="",
    )


def findings(line: FindingsLine) -> None:
    """Explain a finding: what it says, when it holds, what it reads and what to do next."""
    from valvetrain.findings.table import every_rule, explain, plain

    if line.code:
        told = explain(line.code)
        _deliver(told, ("", ""), list(told.items()))
        return
    rows = [(one.code, one.level, plain(one.text)) for one in every_rule()]
    _deliver({"findings": _objects(("code", "level", "says"), rows)}, ("", "", ""), rows)


register_findings = command_without_case("findings", FindingsLine, findings)


def quantities(line: QuantitiesLine) -> None:
    """List the quantities of results: name, the unit they are shown in, and definition."""
    from valvetrain.solution.definition import tables

    wanted = line.words.lower().replace("_", " ").split()
    rows = [
        (row.name, row.shown_unit, row.definition)
        for table in tables().values()
        for row in table
        if all(word in f"{row.name} {row.label}".lower() for word in wanted)
    ]
    if not rows:
        raise InputError(
            f"no quantity has '{line.words[:80]}' in its name; give fewer words, or none for all"
        )
    data = {"quantities": _objects(("name", "shown_unit", "definition"), rows)}
    _deliver(data, ("quantity", "unit", "definition"), rows)


register_quantities = command_without_case("quantities", QuantitiesLine, quantities)


def _objects(keys: Sequence[str], rows: Sequence[tuple[str, ...]]) -> list[dict[str, str]]:
    return [dict(zip(keys, row, strict=True)) for row in rows]


def _deliver(
    data: Mapping[str, object], heads: Sequence[str], rows: Sequence[tuple[str, ...]]
) -> None:
    deliver(Outcome(data, lambda console: console.print(plain_table(heads, rows))))
