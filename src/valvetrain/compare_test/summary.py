"""Model against test in words: the rows that terminal and page both show, in units of the field."""

from __future__ import annotations

import math

from valvetrain.compare_test.adequacy import AdequacyTest, chance_words, p_words
from valvetrain.compare_test.compare import ModelAgainstTest
from valvetrain.compare_test.comparison import RunAgainstTest
from valvetrain.compare_test.events import EventRow
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.measured.value_table import ValueTable
from valvetrain.report.text import number, quantity_label, rpm, speed_text, unit_text
from valvetrain.solution.display import SHOWN_UNITS
from valvetrain.units import unit_factor

Row = tuple[str, ...]
SYNTHETIC = (
    "The test is synthetic: it was computed, not measured. Nothing here speaks of a real engine."
)


def unit_of_test(found: ModelAgainstTest) -> tuple[str, float]:
    """Unit in which the curve, or the values of one unit, are shown, and the factor from SI; of a
    table of several units nothing.
    """
    if isinstance(found.test, ValueTable):
        units = {one.unit for one in found.test.values}
        unit = next(iter(units))
        return (
            (unit_text(unit), 1 / unit_factor(unit))
            if len(units) == 1 and found.test.repeats > 1
            else ("", 1.0)
        )
    unit, factor = SHOWN_UNITS.get(found.test.unit, (found.test.unit, 1.0))
    return unit_text(unit), factor


def text_of_test(found: ModelAgainstTest) -> str:
    """What the test is, in one line."""
    test = found.test
    made = "synthetic, not measured: " if test.synthetic else ""
    if isinstance(test, ValueTable):
        return f"{made}{len(test.values)} values of {test.source or 'a table'}, {_repeats(test.repeats)}"
    speed = f" at {rpm(2 * test.cam_speed):.6g} rpm of the crank" if test.cam_speed else ""
    return (
        f"{made}{quantity_label(test.quantity).lower()}, {len(test.values)} cycles of {len(test.cam_angle)} angles{speed}"
        + (f", {test.source}" if test.source else "")
    )


def _repeats(repeats: int) -> str:
    return f"{repeats} repeats" if repeats > 1 else "with stated scatter"


def verdict_sentences(found: ModelAgainstTest) -> list[str]:
    """The verdict on every run, what the test could have refuted, and which run is nearer."""
    told = (
        [one.sentence for one in found.runs]
        if any(one.adequacy for one in found.runs)
        else [one.sentence for one in found.runs[:1]]
    )
    best = found.best
    if best.adequacy is not None:
        unit, factor = unit_of_test(found)
        reach = number(best.adequacy.refutable * (factor if best.adequacy.repeats else 1.0), 3)
        of_what = unit if best.adequacy.repeats else "standard deviations"
        told.append(
            f"the test detects errors above {reach} {of_what}".rstrip() + " (root mean square)"
        )
        if not best.adequacy.repeats and not best.adequacy.adequate:
            times = number(math.sqrt(best.adequacy.ratio / best.adequacy.critical), 3)
            told.append(f"{best.label} would pass only with {times} times the assumed error")
    told += [one.sentence for one in found.closer]
    return [f"{one[:1].upper()}{one[1:]}." for one in told]


def agreement_rows(found: ModelAgainstTest) -> list[Row]:
    """Run, bias, root mean square, what is left without bias and shift, correlation, shift with its
    interval.
    """
    _, factor = unit_of_test(found)
    rows: list[Row] = []
    for one in found.runs:
        if one.agreement is None:
            continue
        near = one.agreement
        bias = near.bias if abs(near.bias) > 1e-9 * near.rms else 0.0
        reach = (
            f"±{number(math.degrees(near.shift_reach), 2)}"
            if math.isfinite(near.shift_reach)
            else ""
        )
        rows.append(
            (
                one.label,
                number(bias * factor, 3),
                number(near.rms * factor, 3),
                number(near.rest * factor, 3),
                f"{near.correlation:.5f}",
                number(math.degrees(near.shift), 3),
                reach,
            )
        )
    return rows


def agreement_heads(found: ModelAgainstTest) -> Row:
    """Headings of :func:`agreement_rows`."""
    unit, _ = unit_of_test(found)
    return (
        "model",
        f"bias ({unit})",
        f"rms ({unit})",
        f"rest ({unit})",
        "correlation",
        "later (deg)",
        "95 %",
    )


def adequacy_rows(found: ModelAgainstTest) -> list[Row]:
    """Run, adequacy, reproducibility, ratio, degrees of freedom, critical ratio, chance, and the
    chance if every angle counted.
    """
    _, factor = unit_of_test(found)
    rows: list[Row] = []
    for one in found.runs:
        test = one.adequacy
        if test is None:
            continue
        square = factor**2 if test.repeats else 1.0
        rows.append(
            (
                one.label,
                number(test.adequacy * square, 3),
                number(test.reproducibility * square, 3),
                number(test.ratio, 3),
                degrees_words(test),
                number(test.critical, 3),
                chance_words(test.p_value),
                "not refuted" if test.adequate else "refuted",
            )
        )
    return rows


def adequacy_heads(found: ModelAgainstTest) -> Row:
    """Headings of :func:`adequacy_rows`; variances carry the square of the unit."""
    unit, _ = unit_of_test(found)
    squared = f"({unit})²" if "/" in unit else f"{unit}²"
    square = f" ({squared})" if unit else ""
    return (
        "model",
        f"adequacy{square}",
        f"reproducibility{square}",
        "F",
        "degrees of freedom",
        "critical F",
        "p",
        "verdict",
    )


def degrees_words(test: AdequacyTest) -> str:
    """Both degrees of freedom."""
    return ", ".join("∞" if math.isinf(one) else number(one, 3) for one in test.degrees)


def counting_sentence(test: AdequacyTest) -> str:
    """How many independent angles there are, and what the test would say if every angle counted."""
    what = "places" if test.repeats else "values"
    words = f"{test.places} {what} hold about {number(test.independent, 3)} independent ones; the degrees of freedom count these"
    if test.repeats and test.independent < 0.95 * test.places:
        words += f" (if every one counted, {p_words(test.counted_p_value)} would follow, and sampling more densely would change the verdict)"
    return f"{words}."


EVENT_HEADS = ("event", "model", "seen", "test", "difference", "", "scatter", "in s.e.", "95 %")


def event_rows(run: RunAgainstTest, unit: str, factor: float, spikes: bool) -> list[Row]:
    """Events of one run, spikes and their distances or the others, with their difference in units
    of scatter.
    """
    rows: list[Row] = []
    for one in run.events:
        if one.name.startswith(("spike", "interval")) is not spikes:
            continue
        scale, words = (
            (math.degrees(1.0), "cam deg") if one.dimension == "angle" else (factor, unit)
        )
        rows.append(
            (
                f"{one.name[:1].upper()}{one.name[1:]}{', angle' if one.dimension == 'angle' and 'interval' not in one.name else ''}",
                number(one.model * scale),
                number(one.seen * scale),
                number(one.test * scale),
                number(one.difference * scale, 3),
                words,
                number(one.scatter * scale, 2),
                number(one.in_errors, 2),
                _inside(one),
            )
        )
    return rows


def events_sentence(run: RunAgainstTest) -> str:
    """How many events lie outside their interval, beside how many would by chance."""
    judged = [one.outside for one in run.events if one.outside is not None]
    missing = sum(math.isnan(one.model) and one.dimension == "value" for one in run.events)
    lost = f"; {missing} spikes of the test are not in the model" if missing else ""
    if not judged:
        return f"One cycle shows no scatter, so no event is judged{lost}."
    return (
        f"{sum(judged)} of {len(judged)} numbers of events lie outside what the model would show in 95 of 100 such tests, where chance "
        f"alone would put about {number(0.05 * len(judged), 2)}{lost}."
    )


def _inside(one: EventRow) -> str:
    if math.isnan(one.model):
        return "not in the model"
    return "" if one.outside is None else "outside" if one.outside else "inside"


STAGE_HEADS = (
    "stretch",
    "from (cam deg)",
    "to (cam deg)",
    "bias",
    "± (95 %)",
    "rms",
    "zero left out",
)


def stage_rows(run: RunAgainstTest, factor: float, student: float) -> list[Row]:
    """Errors by stretch of the turn; ``student``: half width of a 95 % interval in standard errors."""
    return [
        (
            one.name[:1].upper() + one.name[1:],
            number(math.degrees(one.first)),
            number(math.degrees(one.last)),
            number(one.bias * factor, 3),
            number(student * one.bias_error * factor, 2),
            number(one.rms * factor, 3),
            "–" if math.isnan(one.share_outside) else f"{100 * one.share_outside:.0f} % of angles",
        )
        for one in run.stages
    ]


VALUE_HEADS = (
    "quantity",
    "crank speed",
    "model",
    "test",
    "",
    "scatter",
    "difference",
    "in scatters",
)


def value_rows(run: RunAgainstTest) -> list[Row]:
    """Measured values beside the model's, with the difference in units of their scatter."""
    rows: list[Row] = []
    for one in run.values:
        factor = 1 / unit_factor(one.unit)
        words = quantity_label(one.quantity) + (", angle" if one.kind == "angle" else "")
        rows.append(
            (
                words,
                speed_text(one.engine_speed),
                number(one.model * factor),
                number(one.test * factor),
                unit_text(one.unit),
                number(one.scatter * factor, 2),
                number(one.difference * factor, 3),
                number(one.in_scatters, 2),
            )
        )
    return rows


def outside_sentence(run: RunAgainstTest) -> str:
    """How many values lie further than two scatters off, and which is the furthest."""
    told = [one for one in run.values if math.isfinite(one.model)]
    far = [one for one in told if abs(one.in_scatters) > 2]
    if not told:
        return "The run has none of these values."
    if not far:
        return f"All {len(told)} values lie within two scatters of the model."
    worst = max(far, key=lambda one: abs(one.in_scatters))
    name = quantity_label(worst.quantity) + (", angle" if worst.kind == "angle" else "")
    return (
        f"{len(far)} of {len(told)} values lie more than two scatters off {run.label}; the furthest is {name} at "
        f"{speed_text(worst.engine_speed)}, by {number(abs(worst.in_scatters), 2)}."
    )


def band_sentence(run: RunAgainstTest, cycles: MeasuredCycles) -> str:
    """At how much of the turn the band leaves zero out, and how wide it is."""
    if run.band is None:
        return f"{len(cycles.values)} repeats give no band."
    share = float(run.band.outside.mean())
    width = f"it is {number(run.band.factor, 3)} standard errors wide on either side"
    if share == 0:
        return f"The band of {run.label} holds zero all over the turn; {width}."
    shown = f"{100 * share:.0f} %" if share >= 0.005 else "less than 1 %"
    return f"The band of {run.label} leaves zero out at {shown} of the angles; {width}."
