"""What a case's calibration data leave open: percentiles of its results over the posterior of its identification."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources

import numpy as np

from valvetrain.parameters.case import Case, PublishedValue
from valvetrain.solution.quantity import unit_of

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


def load_spread(case: Case) -> tuple[Spread, ...]:
    """The spread that ships with a library case; empty when there is none or the spring is not the identified one."""
    file = resources.files("valvetrain") / "parameters" / "library" / f"{case.name}.spread"
    if case.spring is None or not file.is_file():
        return ()
    content = tomllib.loads(file.read_text(encoding="utf-8"))
    if not _same_spring(case, content.pop("identified", {})):
        return ()
    return tuple(
        Spread(quantity, int(speed.split()[0]), *map(float, values))
        for speed, table in content.items()
        for quantity, values in table.items()
    )


def _same_spring(case: Case, identified: Mapping[str, float]) -> bool:
    assert case.spring is not None
    here = {"wire_diameter": case.spring.wire_diameter.value(0.0), "mean_diameter": case.spring.mean_diameter.value(0.0)}
    return all(name in identified and abs(float(value) / identified[name] - 1) < 1e-4 for name, value in here.items())


def spread_sentences(case: Case, spread: tuple[Spread, ...]) -> tuple[str, ...]:
    """One sentence per engine speed: range of the told quantities, and whether the published value lies inside."""
    sentences = []
    for rpm in sorted({one.engine_rpm for one in spread}):
        parts = [_part(one, case.published) for one in spread if one.engine_rpm == rpm and one.quantity in TOLD]
        if parts:
            sentences.append(f"{rpm} rpm, what the calibration data leave open (5 to 95 %): {'; '.join(parts)}.")
    return tuple(sentences)


def _part(one: Spread, published: tuple[PublishedValue, ...]) -> str:
    scale, unit = (1e3, "mm") if unit_of(one.quantity) == "m" else (1.0, unit_of(one.quantity))
    words = f"{TOLD[one.quantity]} {one.low * scale:.3g} to {one.high * scale:.3g} {unit}"
    for value in published:
        speed = None if value.engine_speed is None else round(value.engine_speed * 30 / np.pi)
        if value.quantity == one.quantity and speed == one.engine_rpm and value.model == "solid finite elements":
            place = "inside" if one.low <= value.value <= one.high else "outside"
            return f"{words} (published {value.value * scale:.4g}, {place})"
    return words
