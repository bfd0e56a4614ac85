"""The uncertainty that ships with a library case: written once by a script, told with every run of
that case.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from typing import TYPE_CHECKING, Any

import numpy as np

from valvetrain.parameters.loading import library_names
from valvetrain.runs.error_bars import Uncertainty
from valvetrain.solution.definition import shown
from valvetrain.solution.provenance import CaseRecord, PublishedValue
from valvetrain.solution.quantity import Quantity, same_speed, unit_of

if TYPE_CHECKING:
    from valvetrain.runs.error_bars import UncertaintyStudy
    from valvetrain.solution.study import Study


_STILL = "statics"
#: Between engine speed and variant in the heading of a train's rows.
_OF = ", of "
#: Share of a value beyond which its bar is explained.
COARSE = 0.05
#: What is told of a train in a sentence, with how people call it.
_TOLD = (
    ("peak_spring_force", "peak spring force"), ("peak_cam_contact_force", "peak cam force"),
    ("peak_seat_contact_force", "peak seat force"), ("seating_velocity", "seating velocity"),
)  # fmt: skip
#: A stored row belongs to a computed value that differs from it by less than this share, or by less
#: than its own uncertainty.
SAME = 1e-3


def load_uncertainty(record: CaseRecord) -> tuple[Uncertainty, ...]:
    """Rows that ship with a library case; empty when there is none or the case is not word for word
    the one that was refined.
    """
    return rows_of(_content(record))


def rows_of(content: Mapping[str, Mapping[str, Any]]) -> tuple[Uncertainty, ...]:
    """Rows of a file's tables, whatever case they belong to."""
    return tuple(
        _row(name, label, numbers)
        for label, table in content.items()
        if label != "case"
        for name, numbers in table.items()
    )


def meshes_of(record: CaseRecord) -> tuple[int, ...]:
    """Elements per coil of the meshes behind :func:`load_uncertainty`; empty where that has no
    rows.
    """
    return tuple(_content(record).get("case", {}).get("elements_per_coil", ()))


def _content(record: CaseRecord) -> dict[str, Any]:
    file = resources.files("valvetrain") / "parameters" / "library" / f"{record.name}.uncertainty"
    if record.name not in library_names() or not file.is_file():
        return {}
    content = tomllib.loads(file.read_text(encoding="utf-8"))
    return content if content.get("case", {}).get("digest") == record.digest else {}


def uncertainty_text(study: UncertaintyStudy) -> str:
    """The file's content."""
    meshes = ", ".join(map(str, study.elements_per_coil))
    (soft, stiff), (least, most) = study.stiffness_factors, study.damping_factors
    lines = [
        f"# Uncertainty of the headline numbers of {study.record.name}; written by scripts/write_uncertainty.py. SI units.",
        "# value, numerical uncertainty, observed order (nan: not monotonic), extrapolated value, part of the step,",
        f"# least and largest over contact stiffness x {soft:g} to x {stiff:g}, least and largest over contact damping x {least:g} to "
        f"x {most:g}.",
        "", "[case]", f'digest = "{study.record.digest}"', f"elements_per_coil = [{meshes}]",
    ]  # fmt: skip
    for speed, label in dict.fromkeys((row.engine_speed, row.label) for row in study.rows):
        lines += [
            "",
            f'["{_STILL if speed is None else _rpm(speed)}{_OF + label if label else ""}"]',
        ]
        here = [row for row in study.rows if (row.engine_speed, row.label) == (speed, label)]
        lines += [
            f"{row.quantity} = [{', '.join(f'{number:.7g}' for number in _numbers(row))}]"
            for row in here
        ]
    return "\n".join(lines) + "\n"


def belongs(row: Uncertainty, quantities: Mapping[Quantity, float]) -> bool:
    """Whether a stored row is about a number of this study: the same within its own uncertainty."""
    labels = (row.label,) if row.label else ("", "finite-element")
    for key, value in quantities.items():
        if (
            key.name == row.quantity
            and key.label in labels
            and same_speed(key.engine_speed, row.engine_speed)
        ):
            return abs(value - row.value) <= max(SAME * abs(row.value), row.numerical)
    return False


def fresh_uncertainty(study: Study) -> tuple[Uncertainty, ...]:
    """Stored rows of the study's case that are about numbers it computed; none over speeds, nor
    where only statics agree with a run.
    """
    if study.over_speed:
        return ()
    rows = load_uncertainty(study.record)
    found = study.quantities if rows else {}
    fresh = tuple(row for row in rows if belongs(row, found))
    return () if study.solutions and all(row.engine_speed is None for row in fresh) else fresh


def rows_that_hold(
    record: CaseRecord, quantities: Mapping[Quantity, float]
) -> tuple[Uncertainty, ...]:
    """Rows of :func:`load_uncertainty` of every engine speed and variant at which all stored
    numbers come out again among
    ``quantities``."""
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
    """One sentence per engine speed that was run (rad/s), and per variant of a train: how firm its
    numbers are.

    Nothing of a speed at which other values came out (``quantities``) than those that were refined.
    """
    rows, sentences = rows_that_hold(record, quantities), []
    meshes = ", ".join(map(str, meshes_of(record)))
    run = {round(speed * 30 / math.pi) for speed in engine_speeds}
    for speed, label in dict.fromkeys((row.engine_speed, row.label) for row in rows):
        here = {
            row.quantity: row for row in rows if (row.engine_speed, row.label) == (speed, label)
        }
        if speed is None or round(speed * 30 / math.pi) not in run:
            continue
        if label:
            parts = [f"{words} {_firm(here[name])}" for name, words in _TOLD if name in here]
            sentences.append(
                f"{_rpm(speed)}, {label}, with numerical uncertainty: {'; '.join(parts)}.{_of_division(here)}"
            )
        elif "main_clash_below_10_khz_peak_force" in here:
            sentences.append(_clash_sentence(speed, here, meshes))
    return tuple(sentences)


def _of_division(here: Mapping[str, Uncertainty]) -> str:
    """Where large bars come from, when it is not the step."""
    large = [words for name, words in _TOLD if name in here and _is_coarse(here[name])]
    if not large:
        return ""
    return (
        f" More than {100 * COARSE:.0f} % of {', '.join(large)} depends on how finely the springs are divided (elements or masses), next "
        "to nothing on the step: surge of few elements runs at other frequencies and meets the seating in another phase."
    )


def _is_coarse(row: Uncertainty) -> bool:
    return row.numerical > COARSE * abs(row.value) and row.step_part < 0.1 * row.numerical


def _firm(row: Uncertainty) -> str:
    return f"{_with_unit(row.value, row.quantity)} ± {_with_unit(row.numerical, row.quantity, 2)}"


def _clash_sentence(speed: float, here: Mapping[str, Uncertainty], meshes: str) -> str:
    parts = [
        f"{words} {_firm(here[name])}"
        for name, words in (
            ("main_clash_below_10_khz_peak_force", "height below 10 kHz"),
            ("main_clash_below_20_khz_peak_force", "below 20 kHz"),
            ("main_clash_peak_force", "raw"),
            ("main_clash_cam_angle", "at"),
            ("main_clash_impulse", "impulse"),
        )
        if name in here
    ]
    raw, slow = (
        here["main_clash_peak_force"].contact_stiffness,
        here["main_clash_below_10_khz_peak_force"].contact_stiffness,
    )
    return (
        f"{_rpm(speed)}, main clash of coils 1 and 2, numerical uncertainty from {meshes} elements per coil: "
        f"{'; '.join(parts)}. Contact stiffness from 0.35 to 2.5 times the case's moves the height from "
        f"{slow[0]:.4g} to {slow[1]:.4g} N below 10 kHz and from {raw[0]:.4g} to {raw[1]:.4g} N raw."
    )


def _row(name: str, label: str, numbers: list[float]) -> Uncertainty:
    place, _, variant = label.partition(_OF)
    speed = None if place == _STILL else float(place.split()[0]) * math.pi / 30
    value, numerical, order, extrapolated, step, *ranges = map(float, numbers)
    stiffness, damping = (ranges[0], ranges[1]), (ranges[2], ranges[3])
    return Uncertainty(
        name,
        speed,
        value,
        numerical,
        None if math.isnan(order) else order,
        extrapolated,
        step,
        stiffness,
        damping,
        variant,
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
        *row.contact_damping,
    )


def _rpm(engine_speed: float) -> str:
    return f"{engine_speed * 30 / math.pi:g} rpm"


def _with_unit(value: float, name: str, digits: int = 4) -> str:
    number, word = shown(name, value)
    return f"{float(f'{number:.{digits}g}'):g} {word}"


#: The quantities that are told in words on the page, with how people call them.
TOLD = {
    "stage_2_peak_force": "Stage II peak force",
    "stage_2_first_peak_force": "first Stage II peak",
    "stage_2_second_peak_force": "second Stage II peak",
    "stage_3_peak_force": "Stage III spike",
    "node_2_maximum_displacement": "largest displacement of node 2",
}


@dataclass(frozen=True, slots=True)
class Spread:
    """Percentiles 5, 50 and 95 of one quantity (SI) at one engine speed (rpm)."""

    quantity: str
    engine_rpm: int
    low: float
    middle: float
    high: float


def load_spread(record: CaseRecord) -> tuple[Spread, ...]:
    """The spread that ships with a library case; empty when there is none or the case is not word
    for word the one it belongs to.
    """
    file = resources.files("valvetrain") / "parameters" / "library" / f"{record.name}.spread"
    if record.name not in library_names() or not file.is_file():
        return ()
    content = tomllib.loads(file.read_text(encoding="utf-8"))
    if content.pop("case", {}).get("digest") != record.digest:
        return ()
    return tuple(
        Spread(quantity, int(speed.split()[0]), *map(float, values))
        for speed, table in content.items()
        for quantity, values in table.items()
    )


def spread_sentences(
    record: CaseRecord, engine_speeds: Sequence[float], quantities: Mapping[Quantity, float]
) -> tuple[str, ...]:
    """One sentence per engine speed that was run (rad/s): range of the told quantities, and whether
    the published value lies inside.

    Nothing of a speed at which this version computes other values (``quantities``) than the one
    that the spread was found with.
    """
    spread, sentences = load_spread(record), []
    held = {
        round(row.engine_speed * 30 / np.pi)
        for row in rows_that_hold(record, quantities)
        if row.engine_speed is not None
    }
    for rpm in sorted(
        {one.engine_rpm for one in spread}
        & {round(speed * 30 / np.pi) for speed in engine_speeds}
        & held
    ):
        parts = [
            _part(one, record.published)
            for one in spread
            if one.engine_rpm == rpm and one.quantity in TOLD
        ]
        if parts:
            sentences.append(
                f"{rpm} rpm, what the calibration data leave open (5 to 95 %): {'; '.join(parts)}."
            )
    return tuple(sentences)


def _part(one: Spread, published: tuple[PublishedValue, ...]) -> str:
    scale, unit = (1e3, "mm") if unit_of(one.quantity) == "m" else (1.0, unit_of(one.quantity))
    low, high = (
        float(f"{value * scale:.3g}") for value in (one.low, one.high)
    )  # a round number, not 1.23e+03
    words = f"{TOLD[one.quantity]} {low:g} to {high:g} {unit}"
    for value in published:
        speed = None if value.engine_speed is None else round(value.engine_speed * 30 / np.pi)
        if (
            value.quantity == one.quantity
            and speed == one.engine_rpm
            and value.model == "solid finite elements"
        ):
            place = "inside" if one.low <= value.value <= one.high else "outside"
            return f"{words} (published {value.value * scale:.4g}, {place})"
    return words
