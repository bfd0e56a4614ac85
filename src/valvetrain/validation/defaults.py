"""Chapter of the book on what a run prints by default: its rows, known misses, summary and file."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from typing import NamedTuple

from valvetrain.solution.definition import label_of, shown
from valvetrain.validation.default_runs import RPM, SUBJECTS, Compared, compare, compare_exact
from valvetrain.validation.row import FILES, NOTES, Kind, Row, book_case

TOPIC = "defaults against the finest division"


@cache
def compared() -> tuple[Compared, ...]:
    """Every number of the table, computed once."""
    return tuple(one for subject in SUBJECTS for one in compare(subject))


@cache
def compared_exactly() -> tuple[Compared, ...]:
    """The rows of the exact wave equation, computed once."""
    return tuple(compare_exact())


@book_case(slow=True)
def default_against_exact() -> list[Row]:
    """A card by its default models against the exact damped wave equation."""
    return rows_of(compared_exactly(), "closed form")


@book_case(slow=True)
def default_against_finest() -> list[Row]:
    """The worst number of every run, and every number that is missed."""
    return rows_of(compared(), "consistency")


def rows_of(numbers: Iterable[Compared], kind: Kind) -> list[Row]:
    """A row for every run with the number nearest to its limit, and one for every number beyond."""
    runs: dict[tuple[str, str, float], list[Compared]] = {}
    for one in numbers:
        runs.setdefault((one.subject.label, one.model, one.engine_speed), []).append(one)
    rows = []
    for members in runs.values():
        missed = [one for one in members if one.verdict == "missed"]
        held = [one for one in members if one.verdict != "missed"]
        worst = sorted(held, key=lambda one: -one.error / max(one.allowed, 1e-300))[:1]
        rows += [_row(one, members, kind) for one in (*worst, *missed)]
    return rows


def _row(one: Compared, members: Sequence[Compared], kind: Kind) -> Row:
    counts = [sum(m.verdict == word for m in members) for word in VERDICTS]
    parts = [f"{n} {word}" for n, word in zip(counts, VERDICTS, strict=True) if n]
    inputs = f"{len(members)} numbers: {', '.join(parts)}"
    if not all(m.repeats for m in members):
        inputs += "; motion does not repeat, compared within the scatter of both"
    factor = float(shown(one.quantity, 1.0)[0])
    unit = shown(one.quantity, 1.0)[1] or "1"
    reason = _reason(one)
    share, why = _explained(one)
    reach = share * max(abs(one.finest), abs(one.default))
    band = (factor * (one.finest - reach), factor * (one.finest + reach))
    name = f"{one.subject.label}, {one.model}, {one.engine_speed / RPM:.0f} rpm: {label_of(one.quantity)}"
    return Row(
        TOPIC, name, "", inputs, factor * one.finest, factor * one.default, unit,
        max(factor * one.allowed, 1e-12), reason, kind, band if why else None, why,
    )  # fmt: skip


VERDICTS = ("converged", "inside its bar", "missed")


def _reason(one: Compared) -> str:
    if one.bar > one.converged:
        return "its bar" if one.repeats else "its bar and the scatter of both"
    return "1 %" if one.converged > one.near else "nothing beside the preload or the lift"


class Explained(NamedTuple):
    """A known miss: of which runs (parts of the label, all where empty), models and quantities; up to which
    share of the larger value; why.
    """

    subject: str
    models: tuple[str, ...]
    quantities: tuple[str, ...]
    share: float
    why: str


ROD, CHAIN = ("finite-element",), ("multi-mass",)
EXPLAINED: tuple[Explained, ...] = (
    Explained(
        "",
        ("modal-uniform", "wave-rod", *CHAIN),
        ("loss_of_contact",),
        1.1,
        "a sum of openings of less than 5 um that a rattling tappet has in some revolutions or divisions and not in others: "
        "each is there or not, and two further divisions may agree on it by chance",
    ),
    Explained(
        "vaz-ohc nested",
        CHAIN,
        ("lift_loss",),
        0.4,
        "just below float: the finest chain leaves its cam for 0.44 ms, the default one, 14 N from it, does not; lift lost includes the loft",
    ),
    Explained(
        "job-c",
        CHAIN,
        ("largest_clash_impulse",),
        0.6,
        "coils 1 to 5 meet within 0.3 ms and are one clash of 544 mN s on the finest chain; on the default one they are two, of 260 and 232 mN s",
    ),
    Explained(
        "direct stock",
        ROD,
        ("peak_seat", "seating_velocity", "loft"),
        0.5,
        "just below float the bucket rattles: from the fifth to the twelfth revolution the seat force goes from 1332 to 1349 N, the seating "
        "velocity from 0.771 to 0.780 m/s, the loft from 7 to 13 um; a rod is not compared over revolutions and prints no scatter",
    ),
    Explained(
        "",
        ROD,
        ("below_",),
        0.05,
        "coils clash: the height of the filtered spike follows no order up to 24 elements per coil, with 16, 19, 24 and 36: 1078, 1077, 1074 "
        "and 1106 N of the pushrod template below 10 kHz, 1315, 1307, 1312 and 1363 N of job C below 20 kHz",
    ),
)


def _explained(one: Compared) -> tuple[float, str]:
    for known in EXPLAINED:
        if (
            known.subject in one.subject.label
            and one.model in known.models
            and any(part in one.quantity for part in known.quantities)
        ):
            return known.share, known.why
    return 0.0, ""


def summary() -> str:
    """The sentence above the table."""
    numbers = (*compared_exactly(), *compared())
    counts = {word: sum(one.verdict == word for one in numbers) for word in VERDICTS}
    labels = len({one.subject.label for one in numbers})
    beyond: dict[str, int] = {}
    for one in numbers:
        if one.verdict == "missed":
            beyond[label_of(one.quantity)] = beyond.get(label_of(one.quantity), 0) + 1
    missed = ", ".join(f"{count} {label}" for label, count in beyond.items())
    runs = len({(one.subject.label, one.model, one.engine_speed) for one in numbers})
    return SUMMARY.format(
        numbers=len(numbers), labels=labels, runs=runs, converged=counts["converged"],
        inside=counts["inside its bar"], missed=counts["missed"], which=f" ({missed})" if missed else "",
    )  # fmt: skip


#: Text above the table.
SUMMARY = """*Computed* is what a run prints with no option, *expected* the same spring model divided more finely
(chain twice and, of a card, at least 60 elements; modes twice; rod 1.5 times) at half the step (the wave rod, whose grid follows its step, a
quarter), or the exact damped wave equation. {numbers} headline numbers of {runs} runs of {labels} cases at three engine speeds, the last just below
float: {converged} within 1 % (forces: or 0.5 % of the preload; lengths: or 0.5 um; cam angles: within 0.5 degrees), {inside} more inside the bar
printed with them, {missed} beyond both{which}. Each run has the row of its number nearest to its limit, and a row for each number
beyond. All numbers: [validation-defaults.csv](data/validation-defaults.csv).

"""


def csv_text() -> str:
    """Every number of the table, a line each (units as tables print them)."""
    lines = ["case,model,engine speed (rpm),quantity,unit,default,bar,finest,verdict"]
    for one in (*compared_exactly(), *compared()):
        factor, unit = shown(one.quantity, 1.0)
        values = ",".join(f"{factor * value:.5g}" for value in (one.default, one.bar, one.finest))
        label = one.subject.label.replace(",", "")
        rpm = f"{one.engine_speed / RPM:.0f}"
        lines.append(f"{label},{one.model},{rpm},{one.quantity},{unit or 1},{values},{one.verdict}")
    return "\n".join(lines) + "\n"


NOTES[TOPIC], FILES[TOPIC] = summary, ("data/validation-defaults.csv", csv_text)
