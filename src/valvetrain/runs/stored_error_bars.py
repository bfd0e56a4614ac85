"""Error bars and calibration spread that ship with a library case, and the sentences on them in the
notes of a run.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from importlib import resources
from typing import TYPE_CHECKING, Any, NamedTuple

from valvetrain.parameters.loading import library_names
from valvetrain.runs.error_bars import STIFFNESS_FACTORS, grouped
from valvetrain.solution.comparison import Comparison
from valvetrain.solution.definition import shown
from valvetrain.solution.later import LaterMapping
from valvetrain.solution.provenance import CaseRecord, PublishedValue
from valvetrain.solution.quantity import Quantity, same_speed, unit_of
from valvetrain.solution.uncertainty import Uncertainty

if TYPE_CHECKING:
    from valvetrain.runs.error_bars import UncertaintyStudy
    from valvetrain.solution.result import Solution

RPM = math.pi / 30
#: The model whose bars are stored of a spring under prescribed motion.
ROD = "finite-element"
#: Heading of the rows without engine speed, and what separates engine speed and variant in the
#: headings of a train.
_STATICS, _OF = "statics", ", of "
#: Share of a value beyond which its error bar is explained.
COARSE = 0.05
#: A stored row belongs to a computed value that differs by less than this share, or less than its
#: own uncertainty.
SAME = 1e-3
#: Quantities in the sentence on a train, and in that on a clash, with their labels.
TRAIN_LABELS = (
    ("peak_spring_force", "peak spring force"), ("peak_cam_contact_force", "peak cam force"),
    ("peak_seat_contact_force", "peak seat force"), ("seating_velocity", "seating velocity"),
)  # fmt: skip
CLASH_LABELS = (
    ("main_clash_below_5_khz_peak_force", "height below 5 kHz"),
    ("main_clash_peak_force", "raw"), ("main_clash_cam_angle", "at"), ("main_clash_impulse", "impulse"),
)  # fmt: skip
#: Quantities in the sentence on the calibration spread, with their labels.
SPREAD_LABELS = {
    "stage_2_peak_force": "Stage II peak force",
    "stage_2_first_peak_force": "first Stage II peak",
    "stage_2_second_peak_force": "second Stage II peak",
    "stage_3_peak_force": "Stage III spike",
    "node_2_maximum_displacement": "largest displacement of node 2",
}


def load_uncertainty(record: CaseRecord) -> tuple[Uncertainty, ...]:
    """Rows that ship with a library case; empty without a file, and for a case other than the one
    that was refined.
    """
    return rows_of(_library_file(record, "uncertainty"))


def stored_rows(
    record: CaseRecord, solutions: Sequence[Solution]
) -> dict[tuple[str, float], tuple[Uncertainty, ...]]:
    """Stored rows by label and engine speed (rad/s) of those ``solutions`` that reproduce every one of theirs.

    Of a run that computes numbers when they are first read, only those at hand are compared.
    """
    rows, found = load_uncertainty(record), {}
    for run in solutions:
        numbers = run.quantities
        at_hand = numbers.known if isinstance(numbers, LaterMapping) else numbers
        own = tuple(
            row
            for row in rows
            if row.label == run.label and same_speed(row.engine_speed, run.engine_speed)
        )
        known = [(row, at_hand[row.quantity]) for row in own if row.quantity in at_hand]
        if known and all(_is_same(row, value) for row, value in known):
            found[run.label, run.engine_speed] = own
    return found


def rows_of(content: Mapping[str, Mapping[str, Any]]) -> tuple[Uncertainty, ...]:
    """Rows of the tables of a file, whatever case they belong to."""
    tables = ((label, table) for label, table in content.items() if label != "case")
    return tuple(
        _row(name, label, numbers) for label, table in tables for name, numbers in table.items()
    )


def meshes_of(record: CaseRecord) -> tuple[int, ...]:
    """Elements per coil of the meshes behind :func:`load_uncertainty`; empty where that has no
    rows.
    """
    content = _library_file(record, "uncertainty")
    return tuple(content.get("case", {}).get("elements_per_coil", ()))


def _library_file(record: CaseRecord, ending: str) -> dict[str, Any]:
    """Tables of a file next to a library case; empty without one, and where its digest is not that
    of ``record``.
    """
    file = resources.files("valvetrain") / "parameters" / "library" / f"{record.name}.{ending}"
    if record.name not in library_names() or not file.is_file():
        return {}
    content = tomllib.loads(file.read_text(encoding="utf-8"))
    return content if content.get("case", {}).get("digest") == record.digest else {}


def uncertainty_text(study: UncertaintyStudy) -> str:
    """Content of the file that ships with a library case."""
    meshes = ", ".join(map(str, study.elements_per_coil))
    (soft, stiff), (least, most) = study.stiffness_factors, study.damping_factors
    lines = [
        f"# Uncertainty of the headline numbers of {study.record.name}; written by scripts/write_uncertainty.py. SI units.",
        "# value, numerical uncertainty, observed order (nan: not monotonic), extrapolated value, part of the step,",
        f"# least and largest over contact stiffness x {soft:g} to x {stiff:g}, least and largest over damping x {least:g} to "
        f"x {most:g}.",
        "", "[case]", f'digest = "{study.record.digest}"', f"elements_per_coil = [{meshes}]",
    ]  # fmt: skip
    for (speed, label), rows in grouped(study.rows).items():
        variant = _OF + label if label else ""
        lines += ["", f'["{_STATICS if speed is None else _rpm(speed)}{variant}"]']
        for row in rows:
            numbers = ", ".join(f"{number:.7g}" for number in _numbers(row))
            lines.append(f"{row.quantity} = [{numbers}]")
    return "\n".join(lines) + "\n"


def belongs(row: Uncertainty, quantities: Mapping[Quantity, float]) -> bool:
    """Whether ``quantities`` hold the number of a stored row, the same within its own uncertainty."""
    return any(
        _is_same(row, value)
        for key, value in quantities.items()
        if key.name == row.quantity
        and (row.engine_speed is None or key.label == row.label)
        and same_speed(key.engine_speed, row.engine_speed)
    )


def _is_same(row: Uncertainty, value: float) -> bool:
    return abs(value - row.value) <= max(SAME * abs(row.value), row.numerical)


def rows_that_hold(
    record: CaseRecord, quantities: Mapping[Quantity, float]
) -> tuple[Uncertainty, ...]:
    """Rows of :func:`load_uncertainty` at every engine speed and variant of which ``quantities``
    reproduce all numbers.
    """
    rows = load_uncertainty(record)
    computed = {key.name for key in quantities}
    lost = {
        (row.engine_speed, row.label)
        for row in rows
        if row.quantity in computed and not belongs(row, quantities)
    }
    return tuple(row for row in rows if (row.engine_speed, row.label) not in lost)


def uncertainty_sentences(
    record: CaseRecord, engine_speeds: Sequence[float], quantities: Mapping[Quantity, float]
) -> tuple[str, ...]:
    """One sentence on the error bars per engine speed that was run (rad/s), and per variant of a
    train.

    None for a speed at which ``quantities`` are not those that were refined.
    """
    return sentences_of(rows_that_hold(record, quantities), meshes_of(record), engine_speeds)


def sentences_of(
    rows: Sequence[Uncertainty], elements_per_coil: Sequence[int], engine_speeds: Sequence[float]
) -> tuple[str, ...]:
    """One sentence per variant and engine speed (rad/s) of the rows that is among
    ``engine_speeds``.
    """
    run, sentences = {round(speed / RPM) for speed in engine_speeds}, []
    meshes = ", ".join(map(str, elements_per_coil))
    for (speed, label), group in grouped(rows).items():
        if speed is None or round(speed / RPM) not in run:
            continue
        found = {row.quantity: row for row in group}
        if label != ROD:
            sentences.append(
                f"{_rpm(speed)}, {label}, with numerical uncertainty: {_bars(found, TRAIN_LABELS)}.{_coarse_springs(found)}"
            )
        elif CLASH_LABELS[0][0] in found:
            sentences.append(_clash_sentence(speed, found, meshes))
    return tuple(sentences)


def _bars(rows: Mapping[str, Uncertainty], labels: Sequence[tuple[str, str]]) -> str:
    """Label, value and error bar of the rows that are there."""
    return "; ".join(
        f"{label} {_with_unit(rows[name].value, name)} ± {_with_unit(rows[name].numerical, name, 2)}"
        for name, label in labels
        if name in rows
    )


def _coarse_springs(rows: Mapping[str, Uncertainty]) -> str:
    """A sentence on large error bars that the division of the springs causes, not the step."""
    large = [
        label
        for name, label in TRAIN_LABELS
        if (row := rows.get(name)) is not None
        and row.numerical > COARSE * abs(row.value)
        and row.step_part < 0.1 * row.numerical
    ]
    if not large:
        return ""
    return (
        f" More than {100 * COARSE:.0f} % of {', '.join(large)} depends on how finely the springs are divided (elements or masses), next "
        "to nothing on the step: surge of few elements runs at other frequencies and meets the seating in another phase."
    )


def _clash_sentence(speed: float, rows: Mapping[str, Uncertainty], meshes: str) -> str:
    raw, (soft, stiff) = rows["main_clash_peak_force"].contact_stiffness, STIFFNESS_FACTORS
    filtered = rows["main_clash_below_5_khz_peak_force"].contact_stiffness
    return (
        f"{_rpm(speed)}, main clash of coils 1 and 2, numerical uncertainty from {meshes} elements per coil: "
        f"{_bars(rows, CLASH_LABELS)}. Contact stiffness from {soft:g} to {stiff:g} times the case's moves the height from "
        f"{filtered[0]:.4g} to {filtered[1]:.4g} N below 5 kHz and from {raw[0]:.4g} to {raw[1]:.4g} N raw."
    )


def _row(name: str, label: str, numbers: list[float]) -> Uncertainty:
    heading, _, variant = label.partition(_OF)
    speed = None if heading == _STATICS else float(heading.split()[0]) * math.pi / 30
    value, numerical, order, limit, step, *ranges = map(float, numbers)
    stiffness, damping = (ranges[0], ranges[1]), (ranges[2], ranges[3])
    known = None if math.isnan(order) else order
    return Uncertainty(
        name, speed, value, numerical, known, limit, step, stiffness, damping, variant
    )


def _numbers(row: Uncertainty) -> tuple[float, ...]:
    order = math.nan if row.observed_order is None else row.observed_order
    return (
        row.value,
        row.numerical,
        order,
        row.extrapolated,
        row.step_part,
        *row.contact_stiffness,
        *row.damping,
    )


def _rpm(engine_speed: float) -> str:
    return f"{engine_speed * 30 / math.pi:g} rpm"


def _with_unit(value: float, name: str, digits: int = 4) -> str:
    number, unit = shown(name, value)
    return f"{float(f'{number:.{digits}g}'):g} {unit}"


def with_blind(rows: Sequence[Comparison], record: CaseRecord) -> tuple[Comparison, ...]:
    """Comparisons of a fitted case with the numbers of the case that was not fitted to them, where
    these ship next to it.
    """
    content = _library_file(record, "blind")

    def head(row: Comparison) -> str:
        return f"{_STATICS if row.engine_speed is None else _rpm(row.engine_speed)}, {row.origin}"

    return tuple(
        replace(row, blind=content[head(row)].get(row.quantity)) if head(row) in content else row
        for row in rows
    )


class Spread(NamedTuple):
    """Percentiles 5, 50 and 95 of one quantity (SI) at one engine speed (rpm)."""

    quantity: str
    engine_rpm: int
    low: float
    middle: float
    high: float


def load_spread(record: CaseRecord) -> tuple[Spread, ...]:
    """The calibration spread that ships with a library case; empty where there is none for exactly
    this case.
    """
    return tuple(
        Spread(quantity, int(speed.split()[0]), *map(float, values))
        for speed, table in _library_file(record, "spread").items()
        if speed != "case"
        for quantity, values in table.items()
    )


def spread_sentences(
    record: CaseRecord, engine_speeds: Sequence[float], quantities: Mapping[Quantity, float]
) -> tuple[str, ...]:
    """One sentence per engine speed that was run (rad/s): ranges of quantities, and whether they
    hold the published value.

    None for a speed at which ``quantities`` are not those that the spread was found with.
    """
    reproduced = {
        round(row.engine_speed / RPM)
        for row in rows_that_hold(record, quantities)
        if row.engine_speed is not None
    }
    run = {round(speed / RPM) for speed in engine_speeds}
    return spread_sentences_of(load_spread(record), record.published, run & reproduced)


def spread_sentences_of(
    spread: Sequence[Spread], published: Sequence[PublishedValue], engine_rpms: Collection[int]
) -> tuple[str, ...]:
    """One sentence per engine speed (rpm) of the spread that is among ``engine_rpms``."""
    sentences = []
    for rpm in sorted({one.engine_rpm for one in spread} & set(engine_rpms)):
        parts = [
            _range_text(one, published)
            for one in spread
            if one.engine_rpm == rpm and one.quantity in SPREAD_LABELS
        ]
        if parts:
            sentences.append(
                f"{rpm} rpm, what the calibration data leave open (5 to 95 %): {'; '.join(parts)}."
            )
    return tuple(sentences)


def _range_text(one: Spread, published: Sequence[PublishedValue]) -> str:
    scale, unit = (1e3, "mm") if unit_of(one.quantity) == "m" else (1.0, unit_of(one.quantity))
    low, high = (
        float(f"{value * scale:.3g}") for value in (one.low, one.high)
    )  # a round number, not 1.23e+03
    text = f"{SPREAD_LABELS[one.quantity]} {low:g} to {high:g} {unit}"
    for value in published:
        speed = None if value.engine_speed is None else round(value.engine_speed / RPM)
        if (value.quantity, speed, value.model) == (
            one.quantity,
            one.engine_rpm,
            "solid finite elements",
        ):
            position = "inside" if one.low <= value.value <= one.high else "outside"
            return f"{text} (published {value.value * scale:.4g}, {position})"
    return text
