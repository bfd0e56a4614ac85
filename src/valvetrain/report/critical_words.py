"""Critical speeds of a sweep as rows of a table, the same in the terminal and on the page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from valvetrain.report.words import in_unit, number, rpm
from valvetrain.solution.critical import KINDS, CriticalSpeed
from valvetrain.solution.definition import label_of
from valvetrain.solution.study import Study
from valvetrain.system.contract import TRAIN

NOT_COMPUTED = "not computed"
#: Ranges of further stretches that are named; of more only how many.
MOST_AGAIN = 2


@dataclass(frozen=True, slots=True)
class CriticalRow:
    """One line: the quantity it belongs to, words, and a cell per label (speeds in rpm)."""

    name: str
    words: str
    cells: tuple[str, ...]
    main: bool = False


def searched(study: Study) -> bool:
    """Whether the study is a sweep of a train, of which critical speeds are told or said not to be
    computed.
    """
    return study.command == "sweep" and any(
        run.provenance.system == TRAIN for run in study.solutions
    )


def critical_rows(study: Study, labels: Sequence[str]) -> list[CriticalRow]:
    """A line per kind, and below it where control comes back, what rising and falling speed show,
    and further stretches.
    """
    rows = []
    for kind, name in KINDS.items():
        found = [study.critical_speeds.of(kind, label) for label in labels]
        words = label_of(name)
        main = tuple(NOT_COMPUTED if one is None else one.words for one in found)
        rows.append(CriticalRow(name, words[:1].upper() + words[1:], main, True))
        for text, cell in (
            ("until", _until),
            ("rising / falling speed", _hysteresis),
            ("again", _again),
        ):
            cells = tuple("" if one is None else cell(one) for one in found)
            if any(cells):
                rows.append(CriticalRow(name, text, cells))
    return rows


def critical_notes(study: Study) -> tuple[str, ...]:
    """What must be known of the numbers: how they were searched."""
    if not len(study.critical_speeds):
        return ()
    one = study.critical_speeds.rows[0]
    limits = {row.kind: f"{number(in_unit(row.limit, 'mm'))} mm" for row in study.critical_speeds}
    return (
        f"Searched from {rpm(one.first_engine_speed):.6g} to {rpm(one.last_engine_speed):.6g} rpm, every speed from rest, and about each "
        f"change with the motion of the neighbouring speed carried on, rising and falling; brackets of {rpm(one.resolution):.3g} rpm or "
        f"less. Float: lift more than {limits['float']} above the rigid one with a contact open; bounce: higher than {limits['bounce']}. "
        "A stretch of speeds that is narrower than the slopes seen beside it suggest can be missed.",
    )


def _until(one: CriticalSpeed) -> str:
    if not one.found:
        return ""
    return (
        f"{rpm(one.last_engine_speed):.6g} or more" if one.ends is None else str(one.ends.from_rest)
    )


def _hysteresis(one: CriticalSpeed) -> str:
    """The brackets of rising and falling speed where they are apart by more than the resolution,
    empty elsewhere.
    """
    if one.begins is None:
        return ""
    ways = (one.begins.rising, one.begins.falling)
    same = all(way is not None and way.apart(one.begins.from_rest) <= 0 for way in ways)
    return "" if same else " / ".join("none" if way is None else str(way) for way in ways)


def _again(one: CriticalSpeed) -> str:
    if len(one.again) > MOST_AGAIN:
        first, last = rpm(one.again[0].lower_engine_speed), rpm(one.again[-1].upper_engine_speed)
        return f"{len(one.again)} times, {first:.0f}–{last:.0f}"
    return ", ".join(map(str, one.again))
