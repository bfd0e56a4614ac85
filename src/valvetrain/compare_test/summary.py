"""Sentences on a model against a test, and the unit in which it is shown."""

from __future__ import annotations

import math

from valvetrain.compare_test.adequacy import AdequacyTest, p_text
from valvetrain.compare_test.compare import ModelAgainstTest
from valvetrain.compare_test.comparison import RunAgainstTest
from valvetrain.compare_test.tables import value_label
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.measured.value_table import ValueTable
from valvetrain.report.text import number, quantity_label, rpm, speed_text, unit_text
from valvetrain.solution.display import SHOWN_UNITS
from valvetrain.units import unit_factor

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
    return f"{repeats} repeats" if repeats > 1 else "each with a scatter"


def verdict_sentences(found: ModelAgainstTest) -> list[str]:
    """The verdict on every run, what the test could have refuted, and which run is nearer."""
    sentences = (
        [one.sentence for one in found.runs]
        if any(one.adequacy for one in found.runs)
        else [one.sentence for one in found.runs[:1]]
    )
    best = found.best
    if best.adequacy is not None:
        unit, factor = unit_of_test(found)
        reach = number(best.adequacy.refutable * (factor if best.adequacy.repeats else 1.0), 3)
        of_what = (
            f"{unit} from the mean of the repeats".strip() if best.adequacy.repeats else "scatters"
        )
        sentences.append(
            f"a root mean square difference of more than {reach} {of_what} is refuted by this test"
        )
        if not best.adequacy.repeats and not best.adequacy.adequate:
            times = number(math.sqrt(best.adequacy.ratio / best.adequacy.critical), 3)
            sentences.append(f"scatters {times} times as large would not refute {best.label}")
    sentences += [one.sentence for one in found.closer]
    return [f"{one[:1].upper()}{one[1:]}." for one in sentences]


def counting_sentence(test: AdequacyTest) -> str:
    """How many independent angles there are, and what the test would say if every angle counted."""
    what = "places" if test.repeats else "values"
    sentence = f"{test.places} {what} hold about {number(test.independent, 3)} independent ones; the degrees of freedom count these"
    if test.repeats and test.independent < 0.95 * test.places:
        sentence += f" (if every one counted, {p_text(test.counted_p_value)} would follow, and sampling more densely would change the verdict)"
    return f"{sentence}."


def events_sentence(run: RunAgainstTest) -> str:
    """How many events are outside their interval, and how many would by chance."""
    judged = [one.outside for one in run.events if one.outside is not None]
    missing = sum(math.isnan(one.model) and one.dimension == "value" for one in run.events)
    lost = f"; {missing} spikes of the test are not in the model" if missing else ""
    if not judged:
        return f"One cycle shows no scatter, so no event is judged{lost}."
    return (
        f"{sum(judged)} of {len(judged)} numbers of events are outside what the model would show in 95 of 100 such tests, where chance "
        f"alone would put about {number(0.05 * len(judged), 2)}{lost}."
    )


def outside_sentence(run: RunAgainstTest) -> str:
    """How many values are further than two scatters off, and which is the furthest."""
    rows = [one for one in run.values if math.isfinite(one.model)]
    far = [one for one in rows if abs(one.in_scatters) > 2]
    if not rows:
        return "The run has none of these values."
    if not far:
        return f"All {len(rows)} values are within two scatters of the model."
    worst = max(far, key=lambda one: abs(one.in_scatters))
    return (
        f"{len(far)} of {len(rows)} values are more than two scatters off {run.label}; the furthest is {value_label(worst)} at "
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
