"""Rules on a measured curve over a sweep (Y): whether model and test pass the limit at one engine speed."""

from __future__ import annotations

import math

from valvetrain.findings.engine import Condition, Hit, Hits, Rule
from valvetrain.findings.facts import Facts
from valvetrain.findings.rules_train import FLOAT
from valvetrain.findings.words import RPM, Amount, about
from valvetrain.solution.speed_curve import Passing, passing

#: What a spin rig measures -> its name, and the limit (m) where the case sets none.
LIMITED = {"bounce_height": ("bounce", math.nan), "loft_gap": ("loft", FLOAT)}
SPEED = "contact_loss_engine_speed"


def limit_of(facts: Facts, name: str) -> float:
    """The limit (m) of what a spin rig measures: that of the case, else the usual one."""
    limit = facts.value(facts.runs[0], f"permitted_{name}") if facts.runs else math.nan
    return limit if math.isfinite(limit) else LIMITED[name][1]


def compared(name: str, same: bool) -> Condition:
    """A condition on a measured quantity: test and model pass its limit between the same points, or neither does."""

    def hits(facts: Facts) -> Hits:
        test, runs = facts.study.measured, facts.of_label(facts.first_label)
        if test is None or name not in test.values or not runs:
            return
        first, last = runs[0].engine_speed, runs[-1].engine_speed
        pairs = zip(test.engine_speeds, test.values[name], strict=True)
        within = [
            (at, value) for at, value in pairs if first <= at <= last and math.isfinite(value)
        ]
        if len(within) < 2:
            return
        end, limit = within[-1][0], limit_of(facts, name)
        runs = [run for run in runs if run.engine_speed <= end]
        model = passing([run.engine_speed for run in runs], [facts.value(run, name) for run in runs], limit)  # fmt: skip
        rig = passing([at for at, _ in within], [value for _, value in within], limit)
        if _agree(model, rig) is same:
            apart = abs(model.engine_speed - rig.engine_speed) if model and rig else 0.0
            yield Hit(Amount(SPEED, apart), None, limit, {
                "bound": Amount(name, limit), "test": _said(rig, end), "model": _said(model, end),
                "apart": f"{apart / RPM:.0f} rpm" if apart else "",
            })  # fmt: skip

    where = "the same points, or neither does" if same else "different points"
    hits.__doc__ = f"Test and model pass the limit of {LIMITED[name][0]} between {where}."
    return hits


def _agree(model: Passing | None, test: Passing | None) -> bool:
    if model is None or test is None:
        return model is test
    return model.low <= test.high and test.low <= model.high


def _said(one: Passing | None, last: float) -> str:
    return (
        f"not to {about(last)} rpm" if one is None else f"from about {about(one.engine_speed)} rpm"
    )


BOTH = " above {bound}: test {test}, model {model}[, {apart} apart]"
RULES = (
    *(Rule(f"Y10{2 * place + 2}", "warns", f"test and model differ, {LIMITED[name][0]}{BOTH}", compared(name, False),
           step="valvetrain study --parts {case}") for place, name in enumerate(LIMITED)),
    *(Rule(f"Y10{2 * place + 1}", "notes", f"test and model agree, {LIMITED[name][0]}{BOTH}", compared(name, True))
      for place, name in enumerate(LIMITED)),
)  # fmt: skip
