"""The page of a search: the answer first, case against best, figures, bounds, what other models
say, then what was asked.
"""

from __future__ import annotations

import numpy as np

from valvetrain.report.optimum_charts import convergence_chart, front_chart, over_chart
from valvetrain.report.page import Block, Cell, Grid, Page, Section, figure_or_gap, text
from valvetrain.report.points_page import distribution_words
from valvetrain.report.words import number, percent, unit_words
from valvetrain.solution.definition import definition_of, shown
from valvetrain.studies.optimum.measure import Measure
from valvetrain.studies.optimum.result import Design, Optimum, bound_words
from valvetrain.studies.optimum.words import confirmed_words, sentences

#: Designs of a front and failed trials that are listed.
MOST_DESIGNS, MOST_FAILURES = 40, 8
METHODS = {
    "tpe": "tree of Parzen estimators (Optuna)",
    "nsga2": "NSGA-II (Optuna)",
    "cma-es": "CMA-ES (cmaes)",
}
ANSWER_HEADS = ("", "case", "best", "", "change")
BOUND_HEADS = ("bound", "case", "best", "", "to spare", "")
STEP_HEADS = ("step of", "by", "objective", "change", "bounds")


def optimum_page(found: Optimum) -> Page:
    """The whole page."""
    plan = found.plan
    told = sentences(found)
    answers: list[Block] = [text(told[0], "" if found.best else "alert")]
    if found.best:
        answers.append(_grid(ANSWER_HEADS, answer_rows(found), (1, 2, 4)))
    answers += [text(sentence) for sentence in told[1:]]
    figures: list[Block] = [
        *figure_or_gap("front", front_chart, found),
        *figure_or_gap("convergence", convergence_chart, found),
    ]
    for place in range(len(plan.objectives)):
        figures += figure_or_gap("objective", over_chart, found, place)
    sections = [
        Section("answer", "The answer", tuple(answers)),
        Section("figures", "The search", tuple(figures)),
    ]
    if len(plan.objectives) > 1 and found.front:
        sections.append(Section("front-designs", "Designs of the front", _front(found)))
    if plan.constraints and found.best:
        sections.append(
            Section(
                "bounds", "Bounds", (_grid(BOUND_HEADS, bound_rows(found, found.best), (1, 2, 4)),)
            )
        )
    if found.best and found.best.steps:
        caption = "One quantity alone, a hundredth of its range or to its next value; the rest stays as it is."
        table = _grid(STEP_HEADS, step_rows(found, found.best), (1, 2, 3))
        sections.append(Section("steps", "What small steps do", (table, text(caption, "note"))))
    if found.best and found.best.confirmed:
        sections.append(Section("confirmed", "By other models", _confirmed(found, found.best)))
    failed = [one for one in found.trials if one.failure]
    if failed:
        lines: list[Block] = [
            text(f"Trial {one.number}: {one.failure}", "note") for one in failed[:MOST_FAILURES]
        ]
        if len(failed) > MOST_FAILURES:
            lines.append(
                text(f"And {len(failed) - MOST_FAILURES} more; trials.csv has them all.", "note")
            )
        sections.append(Section("failed", "Trials that could not be computed", tuple(lines)))
    sections.append(Section("asked", "What was asked", _asked(found)))
    seeds = "" if len(found.seeds) == 1 else f", {len(found.seeds)} seeds"
    facts = (
        ("case", plan.case.name), ("trials", f"{len(found.trials)}, {found.feasible} feasible"),
        ("method", METHODS[plan.search.method] + f", seed {plan.search.seed}{seeds}"),
        ("computed now", f"{found.computed} points in {found.seconds:.0f} s"),
    )  # fmt: skip
    return Page(
        plan.title,
        "Optimisation",
        plan.description,
        facts,
        tuple(sections),
        "A design is feasible where it keeps every bound.",
    )


def answer_rows(found: Optimum) -> list[tuple[str, ...]]:
    """Words, value of the case, of the best design, unit and difference: objectives first, then
    what is varied, then what is bounded.
    """
    assert found.best is not None
    best, case, rows = found.best.trial, found.case, list[tuple[str, ...]]()
    for goal, value, before in zip(
        found.plan.objectives, best.objectives, case.objectives, strict=True
    ):
        rows.append(_row(goal.measure, float(before), float(value)))
    for one, value, before in zip(found.plan.varied, best.values, case.values, strict=True):
        there, own = one.shown(float(value)), one.shown(float(before))
        apart = (
            ""
            if not np.isfinite(own)
            else number(there - own, 3)
            if one.operation != "value" or not own
            else percent(there / own - 1)
        )
        rows.append(
            (
                one.words,
                number(own if np.isfinite(own) else None, 5),
                number(there, 5),
                unit_words(one.unit),
                apart,
            )
        )
    seen = {goal.measure.quantity for goal in found.plan.objectives}
    for bound, value, before in zip(
        found.plan.constraints, best.constraints, case.constraints, strict=True
    ):
        if bound.measure.quantity not in seen:
            seen.add(bound.measure.quantity)
            rows.append(_row(bound.measure, float(before), float(value)))
    return [(f"{row[0][:1].upper()}{row[0][1:]}", *row[1:]) for row in rows]


def bound_rows(found: Optimum, design: Design) -> list[tuple[str, ...]]:
    """Every bound with what the case and a design have, and what is to spare."""
    rows = []
    active = found.active(design.trial)
    for place, bound in enumerate(found.plan.constraints):
        one = bound.measure
        values = (float(found.case.constraints[place]), float(design.trial.constraints[place]))
        miss = float(design.trial.missed[place])
        words = "missed" if miss > 0 else "active" if place in active else "kept"
        shown_values = (_shown(one, value) for value in values)
        rows.append(
            (
                bound_words(found.plan, place),
                *shown_values,
                unit_words(one.unit),
                percent(-miss),
                words,
            )
        )
    return rows


def step_rows(found: Optimum, design: Design) -> list[tuple[str, ...]]:
    """What a small step of each varied quantity does to the first objective, and whether the bounds
    are kept there.
    """
    one, rows = found.plan.objectives[0].measure, list[tuple[str, ...]]()
    for step in design.steps:
        varied = found.plan.varied[step.place]
        size = f"{varied.shown(step.size):+.3g} {unit_words(varied.unit)}".strip().replace("-", "−")
        value, before = float(step.objectives[0]), float(design.trial.objectives[0])
        unit = unit_words(one.unit)
        apart = (
            ""
            if not np.isfinite(value)
            else _difference(one.shown(value) - one.shown(before), unit)
        )
        words = (
            "cannot be computed"
            if step.failure
            else "kept, and better"
            if step.improves
            else "kept"
            if step.feasible
            else "missed"
        )
        rows.append((varied.words, size, f"{_shown(one, value)} {unit}".strip(), apart, words))
    return rows


def _difference(value: float, unit: str) -> str:
    return f"{value:+.4g} {unit}".strip().replace("-", "−") if value else f"0 {unit}".strip()


def _row(one: Measure, before: float, value: float) -> tuple[str, ...]:
    apart = (
        percent(value / before - 1) if np.isfinite(before) and before and np.isfinite(value) else ""
    )
    return one.label, _shown(one, before), _shown(one, value), unit_words(one.unit), apart


def _shown(one: Measure, value: float) -> str:
    return number(one.shown(value) if np.isfinite(value) else None, 5)


def _grid(heads: tuple[str, ...], rows: list[tuple[str, ...]], numbers: tuple[int, ...]) -> Grid:
    tones = {"missed": "bad", "active": "tag"}
    made = []
    for row in rows:
        cells = tuple(
            Cell(word, "number" if place in numbers else tones.get(word, ""))
            for place, word in enumerate(row)
        )
        made.append((cells, ()))
    return Grid(heads, tuple(made))


def _front(found: Optimum) -> tuple[Block, ...]:
    plan = found.plan
    heads = (
        "trial",
        *(
            f"{one.measure.label} ({unit_words(one.measure.unit)})".replace(" ()", "")
            for one in plan.objectives
        ),
        *(f"{one.words} ({unit_words(one.unit)})".replace(" ()", "") for one in plan.varied),
        "",
    )
    chosen = {id(one.trial): one.chosen.partition(":")[0] for one in found.designs}
    few = found.front[:: max(1, -(-len(found.front) // MOST_DESIGNS))]
    rows = []
    for trial in few:
        values = [
            number(one.measure.shown(float(value)), 5)
            for one, value in zip(plan.objectives, trial.objectives, strict=True)
        ]
        values += [
            number(one.shown(float(value)), 5)
            for one, value in zip(plan.varied, trial.values, strict=True)
        ]
        rows.append((str(trial.number), *values, chosen.get(id(trial), "")))
    return (_grid(heads, rows, tuple(range(len(heads) - 1))),)


def _confirmed(found: Optimum, design: Design) -> tuple[Block, ...]:
    blocks: list[Block] = []
    for one in design.confirmed:
        rows = []
        for place, goal in enumerate(one.plan.objectives):
            rows.append(
                _row(
                    goal.measure,
                    float(one.case.objectives[place]),
                    float(one.design.objectives[place]),
                )
            )
        for place, bound in enumerate(one.plan.constraints):
            row = _row(
                bound.measure,
                float(one.case.constraints[place]),
                float(one.design.constraints[place]),
            )
            rows.append((bound_words(one.plan, place), *row[1:]))
        blocks += [
            text(confirmed_words(one, found)),
            _grid((one.label, *ANSWER_HEADS[1:]), rows, (1, 2, 4)),
        ]
    return tuple(blocks)


def _asked(found: Optimum) -> tuple[Block, ...]:
    rows: list[tuple[str, ...]] = []
    for varied in found.plan.varied:
        how = "its value" if varied.operation == "value" else varied.operation
        rows.append((varied.words, varied.key, how, distribution_words(varied)))
    goals: list[tuple[str, ...]] = []
    for goal in found.plan.objectives:
        most = "most" if goal.maximise else "least"
        goals.append((f"{most} {goal.measure.label}", goal.measure.quantity, _where(goal.measure)))
    for place, bound in enumerate(found.plan.constraints):
        goals.append(
            (bound_words(found.plan, place), bound.measure.quantity, _where(bound.measure))
        )
    return (
        _grid(("quantity", "key of the case", "varied by", "over"), rows, ()),
        _grid(("asked for", "quantity", "at"), goals, ()),
    )


def _where(one: Measure) -> str:
    """Speeds, models and sets of a measure in words."""
    models = dict.fromkeys(word for run in one.runs for word in (run[1], run[2]) if word)
    if one.limit is not None:
        first, last = (
            one.shown(speed) for speed in (one.limit.engine_speeds[0], one.limit.engine_speeds[-1])
        )
        bounds = ", ".join(
            number(float(shown(one.quantity, bound)[0]), 4)
            for bound in one.bounds or (one.limit.bound,)
        )
        of_case = (
            "" if one.limit.share is None else f" ({one.limit.share:g} x case at {first:.6g} rpm)"
        )
        kept = f"{'at most' if one.limit.upper else 'at least'} {bounds} {unit_words(definition_of(one.quantity).shown_unit)}{of_case}"
        words = f"{kept}, from {first:.6g} to {last:.6g} rpm, to {one.shown(one.limit.resolution):.3g} rpm"
    else:
        speeds = dict.fromkeys(run[0] for run in one.runs if run[0] is not None)
        words = ", ".join(f"{speed * 30 / np.pi:.6g}" for speed in speeds) + " rpm"
        if not speeds:
            return "rest"
    several = f", the {one.over} of them" if len(one.runs) > 1 else ""
    return ", ".join([words, *models]) + several
