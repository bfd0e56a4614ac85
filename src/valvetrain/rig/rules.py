"""Rules on a recording (T1): whether it can be used, doubts first."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from valvetrain.findings.engine import Fields, Hit, Hits, Rule, Subject
from valvetrain.findings.words import Amount, Phrase, joined, speed_text
from valvetrain.rig.result import RigChannelCycles, RigResult, peaks_of
from valvetrain.solution.definition import label_of

#: Share of the cycles that are alike at least; relative range of their speeds; share of its swing by which a channel drifts.
ALIKE, SPEED_RANGE, DRIFT = 0.5, 0.05, 0.02
#: Angle between both flanks (rad of cam), and share by which the measured lift is off that of the case, above which it is said.
FLANKS, GAIN = np.radians(0.5), 0.03


@dataclass(frozen=True)
class RigFacts(Subject):
    """A recording as rules and figures read it; ``name``: the case on the command line; ``folder``: of its files."""

    result: RigResult
    name: str = ""
    folder: Path = Path()

    @property
    def case(self) -> str:
        """What a command takes for the case."""
        return self.name or "CASE"

    @property
    def speeds(self) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """Cam speeds of the cycles that are retained (rad/s)."""
        return self.result.grid.cam_speeds[list(self.result.retained)]

    @property
    def test(self) -> str:
        """The cycles as compare-test takes them, of the first channel that does not drift; empty without a case."""
        result, drifting = self.result, self.drifting()
        if not (self.name and result.placed):
            return ""
        steady = [one for one in result.channels if one not in drifting] or result.channels
        return f"{self.folder / steady[0].cycles.quantity}.csv"

    def step(self, advice: str, quantity: str = "") -> Phrase:
        """Comparing a model with the cycles; the ``advice`` without a case."""
        said = {"case": self.name, "test": self.test, "quantity": quantity}
        return Phrase(AGAINST if said["test"] else advice, said)

    def drifting(self) -> list[RigChannelCycles]:
        """Channels whose mean drifts by more than a small share of their swing."""
        return [
            one for one in self.result.channels if abs(one.drift) > DRIFT * np.ptp(one.cycles.mean)
        ]


def clipped(facts: RigFacts) -> Hits:
    """A channel stays at the end of its range, so that its peaks are cut."""
    cut = [one.cycles.quantity for one in facts.result.channels if one.clipped]
    if cut:
        yield Hit(fields={"channels": joined([label_of(one) for one in cut])})


def unlike(facts: RigFacts) -> Hits:
    """Half of the cycles or more are outliers or have gaps."""
    result = facts.result
    if len(result.retained) <= ALIKE * result.grid.cycles:
        yield Hit(fields=_count(result) | {"why": result.outliers[0][1]})


def _count(result: RigResult) -> dict[str, str]:
    count, every = len(result.retained), result.grid.cycles
    return {
        "count": f"{every} cycle{'s' * (every != 1)}"
        if count == every
        else f"{count} of {every} cycles"
    }


def drift(facts: RigFacts) -> Hits:
    """The mean of a channel drifts over the recording, and no zero is taken off."""
    for one in facts.drifting():
        name, swing = one.cycles.quantity, float(np.ptp(one.cycles.mean))
        share = abs(one.drift) / swing
        fields: Fields = {
            "channel": label_of(name),
            "drift": Amount(name, abs(one.drift)),
            "swing": Amount(name, swing),
            "quantity": name,
            "step": facts.step(ZERO, name),
        }
        yield Hit(fields=fields, severity=share)


def uneven(facts: RigFacts) -> Hits:
    """The cam speed differs between the cycles, so that their mean is none of one speed."""
    low, high = float(facts.speeds.min()), float(facts.speeds.max())
    if high - low > SPEED_RANGE * float(facts.speeds.mean()):
        yield Hit(
            fields={"low": speed_text(low, ""), "high": speed_text(high), "step": facts.step(SPAN)}
        )


def usable(facts: RigFacts) -> Hits:
    """The cycles are alike and nothing speaks against them."""
    channel, result = facts.result.channels[0], facts.result
    name, scatter = channel.cycles.quantity, peaks_of(channel)[0].scatter
    fields: Fields = {
        "speed": speed_text(float(facts.speeds.mean())), "channel": label_of(name), "peak": Amount(name, channel.top[0]),
        "scatter": Amount(name, scatter) if scatter > 0 else "", "step": facts.step(COMPARE)
    }  # fmt: skip
    yield Hit(fields={**_count(result), **fields})


def left_out(facts: RigFacts) -> Hits:
    """Cycles that are outliers or have gaps."""
    for cycle, why in facts.result.outliers[:1]:
        more = len(facts.result.outliers) - 1
        yield Hit(
            fields={"cycle": str(cycle + 1), "why": why, "more": f"{more} more" if more else ""}
        )


def unplaced(facts: RigFacts) -> Hits:
    """Neither a case with a lift nor an offset relates the angle of the rig to the cam."""
    if not facts.result.placed:
        yield Hit()


def other_lift(facts: RigFacts) -> Hits:
    """The measured lift is not that of the case: its flanks are apart from them, or it is higher or lower."""
    fit = facts.result.alignment
    apart, off = (0.0, 0.0) if fit is None else (abs(fit.opening - fit.closing), abs(fit.gain - 1))
    if fit is not None and (apart > FLANKS or off > GAIN):
        share = f"it is {100 * fit.gain:.1f} % high" if off > GAIN else ""
        yield Hit(
            fields={"apart": Amount("cam_angle", apart) if apart > FLANKS else "", "share": share}
        )


def synthetic(facts: RigFacts) -> Hits:
    """The recording was computed, not measured."""
    if facts.result.synthetic:
        yield Hit()


AGAINST = "valvetrain compare-test {case} --test {test}"
SPAN = "cut the recording to the part that is steady: --span '2, 5 s'"
COMPARE = "add --case CASE, then compare a model with the cycles"
ZERO = "state its value with the valve shut: --zero '{quantity}=VALUE'"
GUIDE = "rig-data.md"
RULES = (
    Rule("T101", "decides", "not usable: {channels} is clipped", clipped, (), "it stays at the end of its range, so its peaks are cut",
         "record it again with a wider range", guide=GUIDE),
    Rule("T102", "decides", "not usable: only {count} are alike", unlike, (), "the first that differs {why}",
         SPAN, guide=GUIDE),
    Rule("T103", "decides", "usable but for the zero: {channel} drifts by {drift}", drift, (),
         "its swing is {swing}; --zero '{quantity}=VALUE' takes its zero off",
         "{step}", mark="warn", guide=GUIDE),
    Rule("T104", "decides", "usable, but not as one speed: {low} to {high} of the cam", uneven, (),
         "a mean over all cycles mixes speeds; --span '2, 5 s' cuts the recording",
         "{step}", mark="warn", guide=GUIDE),
    Rule("T105", "decides", "usable: {count} at {speed} of the cam", usable, (), "{channel} reaches {peak}[, ± {scatter:2} from cycle to cycle]",
         "{step}", mark="ok", unless=("T10",), guide=GUIDE),
    Rule("T110", "warns", "cycle {cycle} differs: it {why}[; {more}]", left_out, guide=GUIDE),
    Rule("T111", "warns", "cam angles count from the mark of the rig, not from the cam", unplaced,
         step="add --case CASE, whose lift places the mark, or --offset '12 deg'", remark="not related to the cam", guide=GUIDE),
    Rule("T112", "warns", "the lift is not that of the case[: its flanks are {apart} apart][, {share}]", other_lift,
         step="check calibration, lash and cam, or whether the valve leaves the cam"),
    Rule("T113", "warns", "the recording is synthetic: it was computed, not measured", synthetic)
)  # fmt: skip
