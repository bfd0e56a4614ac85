"""Rules on a ranking of parts (W3): which part gains most control, and what leaves that open."""

from __future__ import annotations

from dataclasses import dataclass

from valvetrain.findings.engine import Fields, Hit, Hits, Rule, Subject
from valvetrain.findings.words import Amount, about, speed_text
from valvetrain.solution.critical import RPM
from valvetrain.solution.part_ranking import PartChange, PartRanking


@dataclass(frozen=True)
class PartFacts(Subject):
    """Ranked parts of a train as rules read them."""

    ranking: PartRanking

    @property
    def case(self) -> str:
        """What a command takes for the case."""
        return self.ranking.case


def gain_text(change: PartChange) -> str:
    """What a part gains (rpm), with a sign."""
    return _signed(change.gain)


def range_text(change: PartChange) -> str:
    """The least and largest gain (rpm) where they differ: ``+450 to +500``."""
    ends = [_signed(one) for one in (change.least_gain, change.largest_gain)]
    return "" if ends[0] == ends[1] else " to ".join(ends)


def _signed(engine_speed: float) -> str:
    return f"{round(engine_speed / RPM):+d}".replace("-", "−")


def reached_text(engine_speed: float, ranking: PartRanking) -> str:
    """Up to which speed (rpm) a train is controlled, among those searched."""
    if engine_speed <= 0:
        return f"< {speed_text(ranking.first_engine_speed, '')}"
    if engine_speed > ranking.last_engine_speed:
        return f"> {speed_text(ranking.last_engine_speed, '')}"
    return about(engine_speed)


def _best(facts: PartFacts, reaches: bool) -> Hits:
    ranking, best = facts.ranking, facts.ranking.best
    if best is None or best.sign <= 0:
        return
    red_line = ranking.red_line
    if (red_line is None or red_line <= best.engine_speed) is reaches:
        rivals = [
            one for one in ranking.choices if one is not best and one.largest_gain > best.least_gain
        ]
        fields: Fields = {
            "set": best.setting, "put": "" if best.setting else PUT,
            "part": best.part, "gain": gain_text(best), "range": "" if rivals else range_text(best),
            "rival": max(rivals, key=lambda one: one.largest_gain).part if rivals else "",
            "left": Amount("coil_bind_clearance", best.bind_clearance) if best.near_bind else "",
            "reached": reached_text(best.engine_speed, ranking), "red": "" if red_line is None else speed_text(red_line, ""),
        }  # fmt: skip
        yield Hit(fields=fields)


def enough(facts: PartFacts) -> Hits:
    """The part that gains most reaches the red line, or none is stated."""
    return _best(facts, reaches=True)


def not_enough(facts: PartFacts) -> Hits:
    """The part that gains most leaves control short of the red line."""
    return _best(facts, reaches=False)


def no_gain(facts: PartFacts) -> Hits:
    """The whole range of no gain is above zero."""
    best = facts.ranking.best
    if best is not None and best.sign <= 0:
        yield Hit(fields={
            "part": best.part, "range": range_text(best) or gain_text(best),
            "set": best.setting, "put": "" if best.setting else PUT,
        })  # fmt: skip


def held(facts: PartFacts) -> Hits:
    """The train as it is is controlled at every speed searched."""
    first, last = facts.ranking.first_engine_speed, facts.ranking.last_engine_speed
    if facts.ranking.engine_speed > last:
        beyond = f"{round(first / RPM)}:{round(1.25 * last / RPM, -2):.0f}:250"
        yield Hit(fields={"speed": speed_text(last), "beyond": beyond})


def never_held(facts: PartFacts) -> Hits:
    """The train as it is is not controlled at the lowest speed searched."""
    if facts.ranking.engine_speed <= 0:
        yield Hit(fields={"speed": speed_text(facts.ranking.first_engine_speed)})


def unknown(facts: PartFacts) -> Hits:
    """What nobody knows, damping or a rigid rocker, moves control by more than the best part does."""
    best = facts.ranking.best
    for one in facts.ranking.changes:
        if best is not None and not one.chosen and abs(one.gain) > max(best.gain, 0.0):
            fields: Fields = {"part": one.part, "gain": gain_text(one)}
            yield Hit(fields=fields, severity=abs(one.gain))


def flex(facts: PartFacts) -> Hits:
    """Flex takes lift, and how much of it the stiffest part leaves of those that surely gain: a softer spring bends less too."""
    ranking = facts.ranking
    if ranking.lift_loss > 0:
        gaining = (one for one in ranking.choices if one.sign > 0)
        stiffer = [one for one in gaining if one.lift_loss < LESS * ranking.lift_loss]
        best = min(stiffer, key=lambda one: one.lift_loss, default=None)
        fields: Fields = {
            "time": Amount(LOST[1], ranking.time_lost), "speed": speed_text(ranking.first_engine_speed),
            "part": "" if best is None else best.part, "gain": "" if best is None else gain_text(best),
            "less": "" if best is None else Amount(LOST[0], best.lift_loss), "shorter": "" if best is None else Amount(LOST[1], best.time_lost),
        }  # fmt: skip
        yield Hit(Amount(LOST[0], ranking.lift_loss), fields=fields)


def assumed_retainer(facts: PartFacts) -> Hits:
    """The mass of the retainer is part of that of the valve, and its share is assumed."""
    if any(one.part == "titanium retainer" for one in facts.ranking.changes):
        yield Hit()


GAINS = "{part} gains most, {gain} rpm[ ({range})][; {rival} may gain as much]"
REACHED = "in control to {reached} rpm[, red line {red}][, with only {left} left to coil bind]"
#: What flex takes of lift and open time, and the share of it that a part leaves at most to be called stiffer.
LOST, LESS = ("lift_loss_displacement", "valve_50_thou_lost_crank_angle_range"), 0.97
FLEXES = (
    "flex takes {value:2} of lift at low speed and {time:2} of the time above 0.050 in at {speed}"
    "[; {part} leaves {less:2} and {shorter:2}, and gains {gain} rpm]"
)
#: Where no option of a command makes the change, the case file has to.
PUT = "put it into the case file"
STEP = "[{put}, then ]valvetrain sweep {case}[ {set}]"

RULES = (
    Rule("W301", "decides", GAINS, enough, reason=REACHED, step=STEP, mark="ok"),
    Rule("W302", "decides", GAINS, not_enough, reason=REACHED, step=STEP, mark="warn"),
    Rule("W303", "decides", "no part surely gains control: the best, {part}, {range} rpm", no_gain, step=STEP, mark="warn"),
    Rule("W304", "decides", "no part needs a change: in control up to {speed}, the highest searched", held,
         step="valvetrain sweep {case} --rpm {beyond}", mark="ok"),
    Rule("W305", "decides", "no part can be ranked: not in control already at {speed}", never_held,
         step="valvetrain sweep {case}"),
    Rule("W312", "notes", FLEXES,
         flex, guide="how-to/08-flex.md"),
    Rule("W311", "warns", "what nobody knows moves control more than any part: {part} {gain} rpm", unknown,
         remark="nobody knows it, and it moves control more than any part"),
    Rule("A120", "notes", "a steel retainer is taken as 16 % of what moves with the valve, titanium as 44 % lighter",
         assumed_retainer, remark="share of the retainer"),
)  # fmt: skip
