"""Rules on a model against a test (T2): whether it agrees within the scatter of the test, and where it is worst."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from valvetrain.compare_test.compare import ModelAgainstTest
from valvetrain.compare_test.comparison import RunAgainstTest, ValueRow
from valvetrain.compare_test.reader import FEW, SAME_SPEED
from valvetrain.compare_test.tables import value_name, value_quantity
from valvetrain.findings.engine import Condition, Fields, Hit, Hits, Rule, Subject
from valvetrain.findings.words import Amount, Phrase, digits_text, joined, speed_text
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.quantities.signal import WINDOWS

#: Scatters beyond which a value is off.
OFF = 2.0
#: Stretches of the turn in words.
PHASES: dict[str, str] = dict(
    zip(WINDOWS, ("before the lift", "during the lift", "after the lift"), strict=True)
)
#: Models that no other refines.
FINEST = {"finite-element", "solid"}
FINER = "valvetrain compare-test {case} {test} --model finite-element"
FIT = "fit what was not measured to another test (docs/identification.md)"


@dataclass(frozen=True)
class AgainstTest(Subject):
    """A comparison as rules and figures read it; ``name`` and ``test``: case and options of the test, as the command
    line has them.
    """

    result: ModelAgainstTest
    name: str = ""
    test: str = "--test FILE"

    @property
    def case(self) -> str:
        """What a command takes for its case."""
        return self.name or self.result.study.record.name

    @property
    def cycles(self) -> MeasuredCycles | None:
        """The measured cycles; None of a table of values."""
        return self.result.test if isinstance(self.result.test, MeasuredCycles) else None

    def amount(self, value: float, bar: float = 0.0) -> Amount:
        """A number (SI) of the measured curve."""
        return Amount(self.result.quantity, value, bar)

    def worst(self, run: RunAgainstTest) -> tuple[Amount, Amount]:
        """The largest difference of the curves with two standard errors of the mean, and its cam angle."""
        assert self.cycles is not None and run.curve is not None
        off = run.curve - self.cycles.mean
        place = int(np.argmax(np.abs(off)))
        single = self.cycles.values[:, place]
        bar = 2 * float(np.std(single, ddof=1)) / math.sqrt(len(single)) if len(single) > 1 else 0.0
        angle = Amount("cam_angle", float(self.cycles.cam_angle[place]))
        return self.amount(float(off[place]), bar), angle

    @property
    def step(self) -> Phrase:
        """What to do about a model that does not agree: a finer one, or a fit."""
        study = self.result.study
        coarse = not FINEST & {one.model for one in study.solutions}
        wire = all(one.code != "card-alone" for one in study.facts)
        return Phrase(FINER if coarse and wire else FIT, {"case": self.case, "test": self.test})


def phase(stage: str) -> str:
    """A stretch of the turn as a phase of the lift; names of a source stay."""
    return PHASES.get(stage, stage)


def furthest(run: RunAgainstTest) -> list[ValueRow]:
    """Measured values that a run has too, the furthest off first."""
    rows = [row for row in run.values if math.isfinite(row.model)]
    return sorted(rows, key=lambda row: -abs(row.in_scatters))


def _place(facts: AgainstTest, run: RunAgainstTest) -> Fields:
    """Where a run is furthest off, and how far it is as a whole."""
    if run.agreement is not None:
        off, angle = facts.worst(run)
        stage = next(
            (phase(one.name) for one in run.stages if one.first <= angle.value < one.last), ""
        )
        reach = facts.amount(math.nan if run.adequacy is None else run.adequacy.refutable)
        rms = facts.amount(run.agreement.rms)
        fields: Fields = {
            "off": facts.amount(abs(off.value), off.bar),
            "side": "too high" if off.value > 0 else "too low",
            "angle": angle,
            "stage": stage,
        }
        allowed = Phrase("{rms} rms, the scatter allows {reach}", {"rms": rms, "reach": reach})
        return {
            "where": Phrase("[{off} {side} ]at {angle}[, {stage}]", fields),
            "whole": allowed,
            "rms": rms,
        }
    rows = furthest(run)
    off_count = sum(abs(one.in_scatters) > OFF for one in rows)
    whole = f"{off_count} of {len(rows)} values are off by more than two scatters"
    if not rows:
        return {"whole": whole}
    worst, name = rows[0], value_quantity(rows[0])
    several = len({one.engine_speed for one in run.values}) > 1
    at = speed_text(worst.engine_speed) if several else ""
    values: Fields = {
        "model": Amount(name, worst.model),
        "test": Amount(name, worst.test),
        "name": value_name(worst),
        "at": at,
    }
    return {"where": Phrase("{name}[ at {at}] is {model:4}, test {test:4}", values), "whole": whole}


def judged(verdict: bool | None, doc: str) -> Condition:
    """A condition on the nearest run: whether the test does not refute it; None: there is no F-test."""

    def hits(facts: AgainstTest) -> Hits:
        for run in facts.result.runs[:1]:
            if (run.adequacy.adequate if run.adequacy else None) is verdict:
                why, _, advice = run.without.rpartition("; ")
                said: Fields = {
                    "model": run.label,
                    "step": facts.step,
                    "why": why or advice,
                    "advice": advice,
                }
                yield Hit(fields={**said, **_place(facts, run)})

    hits.__doc__ = doc
    return hits


def shifted(facts: AgainstTest) -> Hits:
    """A shift along the cam angle, alone or with an offset, is all that the test refutes."""
    for run in facts.result.runs[:1]:
        test, near = run.adequacy, run.agreement
        if (
            test
            and near
            and not test.adequate
            and near.rest <= test.refutable
            and abs(near.shift) > 2 * near.shift_reach
        ):
            late = "late" if near.shift > 0 else "early"
            yield Hit(fields={
                "model": run.label, "shift": Amount("cam_angle", abs(near.shift), near.shift_reach), "late": late,
                "rest": facts.amount(near.rest), "reach": facts.amount(test.refutable)
            })  # fmt: skip


def nothing(facts: AgainstTest) -> Hits:
    """No run ended, so nothing can be compared."""
    if not facts.result.runs:
        yield Hit()


def failed(facts: AgainstTest) -> Hits:
    """Runs that did not end."""
    first, *others = facts.result.failures or ("",)
    if first:
        yield Hit(fields={"said": first, "more": f"{len(others)} more" if others else ""})


def synthetic(facts: AgainstTest) -> Hits:
    """The test was computed, not measured."""
    if facts.result.test.synthetic:
        yield Hit()


def left_out(facts: AgainstTest) -> Hits:
    """Models without the measured curve or a speed of the table, and values that no run computes."""
    runs = facts.result.runs
    ended = {run.label for run in facts.result.study.solutions if run.status.completed}
    lost = sorted(ended - {run.label for run in runs}) if runs else []
    lost += dict.fromkeys(
        value_name(one) for run in runs for one in run.values if math.isnan(one.model)
    )
    if lost:
        yield Hit(
            fields={
                "names": joined(lost[:3]),
                "more": f"{len(lost) - 3} more" if len(lost) > 3 else "",
            }
        )


def other_speed(facts: AgainstTest) -> Hits:
    """The model ran at another speed than the test."""
    ran = facts.result.study.engine_speeds
    stated = 0.0 if facts.cycles is None else 2 * facts.cycles.cam_speed
    if stated and ran and abs(stated / ran[0] - 1) > SAME_SPEED:
        yield Hit(fields={"test": speed_text(stated), "model": speed_text(ran[0])})


def few(facts: AgainstTest) -> Hits:
    """Two or three repeats, which hardly show how the scatter varies along the angle and how values move together."""
    test = facts.result.test
    count = len(test.values) if isinstance(test, MeasuredCycles) else test.repeats
    if 1 < count < FEW:
        yield Hit(fields={"count": str(count)})


def alike(facts: AgainstTest) -> Hits:
    """Cycles that resemble the one before them, so that they are fewer repeats than they seem."""
    if facts.cycles is not None and math.isfinite(fewer := facts.result.separate):
        yield Hit(
            fields={"count": str(len(facts.cycles.values)), "fewer": digits_text(fewer, 0, 2)}
        )


def no_common_error(facts: AgainstTest) -> Hits:
    """No error is stated that all cycles, or all values of a table, share."""
    for run in facts.result.runs[:1]:
        test = run.adequacy
        if test and not test.shared and (facts.cycles is not None or not test.repeats):
            yield Hit()


GUIDE = "model-against-test.md"
NO = "{model} does not agree with the test"
RULES = (
    Rule("T201", "decides", "nothing can be compared: no run ended", nothing, step="valvetrain run {case}", guide=GUIDE),
    Rule("T202", "decides", f"{NO}: it comes {{shift}} {{late}}", shifted, (),
         "without that {rest} rms, the scatter allows {reach}",
         "check the mark of the cam angle, or state the gauge: --bandwidth '8 kHz'", guide=GUIDE),
    Rule("T203", "decides", f"{NO}[: {{where}}]", judged(False, "The test refutes the nearest model."), (), "{whole}", "{step}",
         unless=("T202",), guide=GUIDE),
    Rule("T204", "decides", "{model} agrees with the test within its scatter", judged(True, "The test does not refute the nearest model."), (),
         "{whole}", "valvetrain sweep {case}", mark="ok", guide=GUIDE),
    Rule("T205", "decides", "whether {model} agrees is not judged[: {rms} rms off the test]",
         judged(None, "The test shows no scatter, or none that can be used."), (), "{why}", "{advice}", mark="warn", guide=GUIDE),
    Rule("T210", "warns", "not every run ended: {said}[; {more}]", failed),
    Rule("T211", "warns", "the test is synthetic: it was computed, not measured",
         synthetic),
    Rule("T212", "warns", "left out, for model and test do not both have it: {names}[ and {more}]", left_out),
    Rule("T213", "warns", "the test ran at {test}, the model at {model}: the speed is part of the difference", other_speed),
    Rule("T214", "warns", "{count} repeats hardly show the scatter, so the test refutes too readily; give four or more", few),
    Rule("T215", "warns", "successive cycles are alike: {count} count as {fewer}, so the test refutes too readily", alike,
         step="give cycles further apart"),
    Rule("T291", "notes", "no error is stated that all share, of zero, calibration or angle", no_common_error,
         step="--shared '2 N, 0.5 %, 0.1 deg' states it", remark="no error of calibration", guide=GUIDE)
)  # fmt: skip
