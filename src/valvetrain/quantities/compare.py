"""Comparison of computed with published values: one row and verdict per published value."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from valvetrain.arrays import Array
from valvetrain.solution.provenance import PublishedValue
from valvetrain.solution.quantity import Quantity, same_speed, unit_of
from valvetrain.solution.uncertainty import Comparison, SampleRange

#: A whole turn (rad).
TURN = 2 * np.pi
#: Named numbers of each run by its label and engine speed.
Runs = Mapping[tuple[str, float | None], Mapping[str, float]]


def compare(
    published: Iterable[PublishedValue],
    quantities: Mapping[Quantity, float],
    counterparts: Mapping[str, str] | None,
    counted: Sequence[str] = (),
    by_phase: Mapping[Quantity, Array] = {},
) -> tuple[Comparison, ...]:
    """One row per published value, in their order.

    A published value meets the computed one of the same name and engine speed in the run that
    ``counterparts`` names for what produced it (label of ours; values at rest have no label); in a
    case that re-runs no study (None) what produced it is the label itself. ``counted``: words of
    angles that are counted through a cycle, such as ``clash`` for ``clash_3_cam_angle``; an extra
    one early on would shift the count of all that follow, so they meet one to one in their order.
    ``by_phase``: what the source could have read of a quantity, one value for each phase of its samples.
    """
    rows, listed = [], tuple(published)
    runs: dict[tuple[str, float | None], dict[str, float]] = {}
    for key, number in quantities.items():
        runs.setdefault((key.label, key.engine_speed), {})[key.name] = number
    pattern = (
        re.compile(rf"({'|'.join(map(re.escape, counted))})_\d+_cam_angle")
        if counted
        else re.compile(r"(?!)")
    )
    partners = _counted(listed, runs, counterparts, pattern)
    for value in listed:
        label = _label(value, counterparts)
        computed = (
            partners[id(value)]
            if id(value) in partners
            else _of_run(value, label, runs).get(value.quantity)
        )
        difference = None if computed is None else computed - value.value
        if (
            difference is not None
            and value.quantity.endswith("_cam_angle")
            and "interval" not in value.quantity
        ):
            difference = _turn_difference(difference)
        read = next(
            (
                found
                for key, found in by_phase.items()
                if key.name == value.quantity
                and key.label == label
                and same_speed(key.engine_speed, value.engine_speed)
            ),
            None,
        )
        samples = (
            None
            if read is None
            else SampleRange(
                float(read.min()), float(read.max()), float(np.mean(read >= value.value)), len(read)
            )
        )
        rows.append(
            Comparison(
                quantity=value.quantity,
                engine_speed=value.engine_speed,
                model=label,
                origin=value.model,
                unit=value.unit,
                published=value.value,
                computed=computed,
                difference=difference,
                role=value.role,
                tolerance=value.tolerance,
                verdict=verdict(value, difference) + _over_phases(value, samples),
                source=value.source,
                used_for=value.used_for,
                doubt=value.doubt,
                reading=value.reading,
                samples=samples,
            )
        )
    return tuple(rows)


def _label(value: PublishedValue, counterparts: Mapping[str, str] | None) -> str:
    """Label of the run that a published value is compared with."""
    return (
        ""
        if value.engine_speed is None
        else value.model
        if counterparts is None
        else counterparts.get(value.model, "")
    )


def _of_run(value: PublishedValue, label: str, runs: Runs) -> Mapping[str, float]:
    return next(
        (
            names
            for (mine, speed), names in runs.items()
            if mine == label and same_speed(speed, value.engine_speed)
        ),
        {},
    )


def _counted(
    published: tuple[PublishedValue, ...],
    runs: Runs,
    counterparts: Mapping[str, str] | None,
    pattern: re.Pattern[str],
) -> dict[int, float | None]:
    """Computed partner of every counted published angle, by ``id``."""
    series: dict[tuple[str, float | None, str], list[PublishedValue]] = {}
    for value in published:
        match = pattern.fullmatch(value.quantity)
        if match:
            series.setdefault((value.model, value.engine_speed, match[1]), []).append(value)
    partners: dict[int, float | None] = {}
    for (_, _, kind), values in series.items():
        values.sort(key=lambda value: value.value)
        mine = _of_run(values[0], _label(values[0], counterparts), runs)
        computed = [
            number
            for name, number in mine.items()
            if (match := pattern.fullmatch(name)) and match[1] == kind
        ]
        found = pair_angles([value.value for value in values], computed)
        partners |= {id(value): partner for value, partner in zip(values, found, strict=True)}
    return partners


def pair_angles(published: Sequence[float], computed: Sequence[float]) -> list[float | None]:
    """For each of the ascending ``published`` angles (rad) a ``computed`` one, in order round the
    circle, each at most once, or None.

    Least sum of distances, where a published angle without a partner counts as much as the median
    step between published ones: a collision that did not come must not shift all that follow. A
    single published angle meets the nearest.
    """
    alone = float(np.median(np.diff(published))) if len(published) > 1 else TURN
    ordered = sorted(computed)
    turned = (ordered[start:] + ordered[:start] for start in range(max(1, len(ordered))))
    return min(
        (_pair_in_order(published, angles, alone) for angles in turned), key=lambda found: found[0]
    )[1]


def _pair_in_order(
    published: Sequence[float], computed: Sequence[float], alone: float
) -> tuple[float, list[float | None]]:
    """Minimum cost and the partners, both lists in ascending order."""
    # best[j]: cost and partners of the published angles so far with the first j computed ones.
    best: list[tuple[float, list[float | None]]] = [(0.0, [])] * (len(computed) + 1)
    for angle in published:
        row: list[tuple[float, list[float | None]]] = []
        for count, (cost, partners) in enumerate(best):
            choices = [(cost + alone, [*partners, None])]
            if count:
                before, other = best[count - 1], computed[count - 1]
                choices += [
                    row[-1],
                    (before[0] + abs(_turn_difference(other - angle)), [*before[1], other]),
                ]
            row.append(min(choices, key=lambda choice: choice[0]))
        best = row
    return best[-1]


def _turn_difference(difference: float) -> float:
    return float((difference + np.pi) % (2 * np.pi) - np.pi)


def verdict(value: PublishedValue, difference: float | None) -> str:
    """Verdict of one row: within or outside its tolerance, or without a tolerance the difference.

    A bound ("spikes up to 620 N") is no tolerance: staying below it is not agreement, so the
    distance is given there too.
    """
    if difference is None:
        return "not computed"
    if value.relation in ("at-most", "at-least"):
        beyond = difference if value.relation == "at-most" else -difference
        limit = value.relation.replace("-", " ")
        return f"stated as {limit}: " + (
            f"beyond by {_size(value, beyond)}"
            if beyond > 0
            else _size(value, difference, signed=True)
        )
    if value.doubt:
        return f"in doubt, {value.doubt}: differs by {_size(value, difference, signed=True)}"
    if value.tolerance is None:
        return f"differs by {_size(value, difference, signed=True)}"
    if abs(difference) <= value.tolerance * (1 + 1e-12):
        return "within tolerance"
    return f"misses by {_size(value, difference, signed=True)}, tolerance {_size(value, value.tolerance)}"


def _over_phases(value: PublishedValue, samples: SampleRange | None) -> str:
    """The range over the phases of samples, where these decide more than a hundredth of a value or a degree."""
    if samples is None:
        return ""
    turned = unit_of(value.quantity) == "rad"
    if samples.high - samples.low <= (np.radians(1.0) if turned else abs(value.value) / 100):
        return ""
    from valvetrain.units import to_unit

    low, high = (float(to_unit(end, value.unit)) for end in (samples.low, samples.high))
    share = "" if turned else f", {100 * samples.share:.0f} % at or above"
    return f"; {low:.4g} to {high:.4g} {value.unit} over {samples.phases} phases of samples{share}"


def _size(value: PublishedValue, difference: float, signed: bool = False) -> str:
    from valvetrain.units import unit_factor

    sign = "+" if signed else ""
    if unit_of(value.quantity) == "rad":
        degrees = round(float(np.degrees(difference)), 1) + 0.0  # no minus nought
        return f"{degrees:{sign}.1f} deg"
    if value.value == 0:
        return f"{difference / unit_factor(value.unit):{sign}.3g} {value.unit}"
    return f"{100 * difference / abs(value.value):{sign}.1f} %"
