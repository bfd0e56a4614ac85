"""What a case's calibration data leave open: percentiles of its results over the posterior of its
identification.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources

import numpy as np

from valvetrain.parameters.loading import library_names
from valvetrain.solution.quantity import Quantity, unit_of
from valvetrain.solution.record import CaseRecord, PublishedValue
from valvetrain.studies.uncertainty_file import rows_that_hold

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
