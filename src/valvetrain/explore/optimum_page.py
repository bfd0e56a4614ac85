"""The page of a search: the answer first, case against best, figures, bounds, what other models
say, then the request.
"""

from __future__ import annotations

import csv
import io
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.explore.measure import LimitFound, Measure
from valvetrain.explore.optimum import (
    Confirmed,
    Design,
    Optimum,
    bound_label,
    case_text,
    write_optuna,
)
from valvetrain.explore.optimum_charts import convergence_chart, front_chart, over_chart
from valvetrain.explore.optimum_summary import confirmed_text, same_as_varied, sentences
from valvetrain.explore.study_page import distribution_text
from valvetrain.explore.trial import Trial
from valvetrain.explore.valley import ALIKE
from valvetrain.report.json import uncertainty_object
from valvetrain.report.page import Block, Cell, Grid, Page, Section, figure_or_gap, render, text
from valvetrain.report.study import StudyFiles, files_of
from valvetrain.report.text import number, percent, unit_text
from valvetrain.report.verdict import verdict_of
from valvetrain.solution.atomic import write_text
from valvetrain.solution.definition import definition_of, shown
from valvetrain.solution.partial_failures import PartialFailures

#: Designs of a front and failed trials that are listed.
MAX_DESIGNS, MAX_FAILURES = 40, 8
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
    reported = sentences(found)
    answers: list[Block] = [text(reported[0], "" if found.best else "alert")]
    if found.best:
        answers.append(_grid(ANSWER_HEADS, answer_rows(found), (1, 2, 4)))
    answers += [text(sentence) for sentence in reported[1:]]
    front, search = (
        figure_or_gap("front", front_chart, found),
        figure_or_gap("convergence", convergence_chart, found),
    )
    picture = (front or search)[:1]
    figures: list[Block] = [*(search if front else ())]
    for index in range(len(plan.objectives)):
        figures += figure_or_gap("objective", over_chart, found, index)
    sections = [Section("answer", "The answer", tuple(answers))]
    if figures:
        sections.append(Section("figures", "The search", tuple(figures)))
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
            text(f"Trial {one.number}: {one.failure}", "note") for one in failed[:MAX_FAILURES]
        ]
        if len(failed) > MAX_FAILURES:
            lines.append(
                text(f"And {len(failed) - MAX_FAILURES} more; trials.csv has them all.", "note")
            )
        sections.append(Section("failed", "Trials that could not be computed", tuple(lines)))
    sections.append(Section("asked", "The request", _requested(found), folded=True))
    seeds = "" if len(found.seeds) == 1 else f", {len(found.seeds)} seeds"
    facts = (
        ("case", plan.case_name), ("trials", f"{len(found.trials) - 1} and the case, {found.feasible} feasible"),
        ("method", METHODS[plan.search.method] + f", seed {plan.search.seed}{seeds}"),
        ("computed", f"{found.computed} runs, {found.seconds:.0f} s"),
    )  # fmt: skip
    return Page(
        plan.title,
        "Optimisation",
        plan.description,
        facts,
        tuple(sections),
        "A design is feasible where it meets every bound.",
        verdict=verdict_of(found),
        picture=picture,
    )


def answer_rows(found: Optimum) -> list[tuple[str, ...]]:
    """Name (of what is varied as the file has it), value of the case, of the best design, unit and
    difference: objectives first, then what is varied, then what is bounded.
    """
    assert found.best is not None
    best, case, rows = found.best.trial, found.case, list[tuple[str, ...]]()
    for index, goal in enumerate(found.plan.objectives):
        if same_as_varied(found, index) is None:  # else it is listed as varied
            value, before = float(best.objectives[index]), float(case.objectives[index])
            rows.append(_row(goal.measure, before, value))
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
                one.shown_name,
                number(own if np.isfinite(own) else None, 4),
                number(there, 4),
                unit_text(one.unit),
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
    return rows


def bound_rows(found: Optimum, design: Design) -> list[tuple[str, ...]]:
    """Every bound with what the case and a design have, and what is to spare."""
    rows = []
    active = found.active(design.trial)
    for index, bound in enumerate(found.plan.constraints):
        one = bound.measure
        values = (float(found.case.constraints[index]), float(design.trial.constraints[index]))
        miss = float(design.trial.missed[index])
        phrase = "missed" if miss > 0 else "active" if index in active else "met"
        shown_values = (_shown(one, value) for value in values)
        rows.append(
            (
                bound_label(found.plan, index),
                *shown_values,
                unit_text(one.unit),
                percent(-miss),
                phrase,
            )
        )
    return rows


def step_rows(found: Optimum, design: Design) -> list[tuple[str, ...]]:
    """What a small step of each varied quantity does to the first objective, and whether the bounds
    are met there.
    """
    one, rows = found.plan.objectives[0].measure, list[tuple[str, ...]]()
    for step in design.steps:
        varied = found.plan.varied[step.index]
        size = f"{varied.shown(step.size):+.3g} {unit_text(varied.unit)}".strip().replace("-", "−")
        value, before = float(step.objectives[0]), float(design.trial.objectives[0])
        unit = unit_text(one.unit)
        apart = (
            ""
            if not np.isfinite(value)
            else _difference(one.shown(value) - one.shown(before), unit)
        )
        phrase = (
            "cannot be computed"
            if step.failure
            else "met, and better"
            if step.improves
            else "met"
            if step.feasible
            else "missed"
        )
        rows.append(
            (varied.shown_name, size, f"{_shown(one, value)} {unit}".strip(), apart, phrase)
        )
    return rows


def _difference(value: float, unit: str) -> str:
    return f"{value:+.4g} {unit}".strip().replace("-", "−") if value else f"0 {unit}".strip()


def _row(one: Measure, before: float, value: float) -> tuple[str, ...]:
    apart = (
        percent(value / before - 1) if np.isfinite(before) and before and np.isfinite(value) else ""
    )
    label = f"{one.label[:1].upper()}{one.label[1:]}"
    return label, _shown(one, before), _shown(one, value), unit_text(one.unit), apart


def _shown(one: Measure, value: float) -> str:
    return number(one.shown(value) if np.isfinite(value) else None, 4)


def _grid(heads: tuple[str, ...], rows: list[tuple[str, ...]], numbers: tuple[int, ...]) -> Grid:
    tones = {"missed": "bad", "active": "tag"}
    made = []
    for row in rows:
        cells = tuple(
            Cell(word, "number" if index in numbers else tones.get(word, ""))
            for index, word in enumerate(row)
        )
        made.append((cells, ()))
    return Grid(heads, tuple(made))


def _front(found: Optimum) -> tuple[Block, ...]:
    plan = found.plan
    heads = (
        "trial",
        *(
            f"{one.measure.label} ({unit_text(one.measure.unit)})".replace(" ()", "")
            for one in plan.objectives
        ),
        *(one.axis_label for one in plan.varied),
        "",
    )
    chosen = {id(one.trial): one.chosen.partition(":")[0] for one in found.designs}
    few = found.front[:: max(1, -(-len(found.front) // MAX_DESIGNS))]
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
        for index, goal in enumerate(one.plan.objectives):
            rows.append(
                _row(
                    goal.measure,
                    float(one.case.objectives[index]),
                    float(one.design.objectives[index]),
                )
            )
        for index, bound in enumerate(one.plan.constraints):
            row = _row(
                bound.measure,
                float(one.case.constraints[index]),
                float(one.design.constraints[index]),
            )
            rows.append((bound_label(one.plan, index), *row[1:]))
        blocks += [
            text(confirmed_text(one, found)),
            _grid((one.label, *ANSWER_HEADS[1:]), rows, (1, 2, 4)),
        ]
    return tuple(blocks)


def _requested(found: Optimum) -> tuple[Block, ...]:
    rows: list[tuple[str, ...]] = []
    for varied in found.plan.varied:
        how = "its value" if varied.operation == "value" else varied.operation
        rows.append((varied.shown_name, varied.key, how, distribution_text(varied)))
    goals: list[tuple[str, ...]] = []
    for goal in found.plan.objectives:
        most = "most" if goal.maximise else "least"
        goals.append((f"{most} {goal.measure.label}", goal.measure.quantity, _where(goal.measure)))
    for index, bound in enumerate(found.plan.constraints):
        goals.append(
            (bound_label(found.plan, index), bound.measure.quantity, _where(bound.measure))
        )
    return (
        _grid(("quantity", "key of the case", "varied by", "over"), rows, ()),
        _grid(("objective or bound", "quantity", "at"), goals, ()),
    )


def _where(one: Measure) -> str:
    """Speeds, models and sets of a measure in words."""
    if one.varied is not None:
        return "its own value"
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
        retained = f"{'at most' if one.limit.upper else 'at least'} {bounds} {unit_text(definition_of(one.quantity).unit_word)}{of_case}"
        phrase = f"{retained}, from {first:.6g} to {last:.6g} rpm, to {one.shown(one.limit.resolution):.3g} rpm"
    else:
        speeds = dict.fromkeys(run[0] for run in one.runs if run[0] is not None)
        phrase = ", ".join(f"{speed * 30 / np.pi:.6g}" for speed in speeds) + " rpm"
        if not speeds:
            return "rest"
    several = f", the {one.over} of them" if len(one.runs) > 1 else ""
    return ", ".join([phrase, *models]) + several


#: Trials that the JSON answer holds whole; more are in trials.csv.
MAX_TRIALS = 2000
TRIALS, OPTUNA, BEST = "trials.csv", "optuna.db", "best.toml"


def optimum_json(found: Optimum) -> dict[str, Any]:
    """The JSON answer, SI."""
    plan = found.plan
    data: dict[str, Any] = {
        "case": plan.case_name, "title": plan.title, "method": plan.search.method, "seeds": list(found.seeds),
        "trials": len(found.trials), "feasible_trials": found.feasible, "computed_now": found.computed,
        "varied": [
            {"name": one.name, "key": one.key, "as": one.operation, "unit": one.si_unit or "1", "label": one.shown_name} for one in plan.varied
        ],
        "objectives": [{**_of(one.measure), "direction": "maximise" if one.maximise else "minimise"} for one in plan.objectives],
        "constraints": [
            {**_of(one.measure), "sense": "at_most" if one.upper else "at_least", "bound": one.bound, "share_of_case": one.share,
             "words": bound_label(plan, index)} for index, one in enumerate(plan.constraints)
        ],
        "of_case": _trial(found.case), "designs": [_design(found, one) for one in found.designs],
        "front": [one.number for one in found.front], "history": found.history() if len(plan.objectives) == 1 else None,
        "best_by_seed": {str(seed): value for seed, value in found.best_by_seed.items()}, "sentences": list(sentences(found)),
        "completed": found.finished and found.best is not None,
    }  # fmt: skip
    data["uncertainties"] = [uncertainty_object(one) for one in found.error_bars]
    if len(found.trials) <= MAX_TRIALS:
        data["rows"] = [_trial(one) for one in found.trials]
    return data


def _of(one: Measure) -> dict[str, Any]:
    speeds = [run[0] for run in one.runs if run[0] is not None]
    reported: dict[str, Any] = {"quantity": one.quantity, "unit": one.si_unit, "label": one.label}
    if one.limit is not None:
        sense = "at_most" if one.limit.upper else "at_least"
        reported["limit_speed"] = {
            sense: one.limit.bound,
            "engine_speeds": list(one.limit.engine_speeds),
            "resolution": one.limit.resolution,
        }
    return reported | (
        {"engine_speeds": list(dict.fromkeys(speeds)), "over": one.over} if speeds else {}
    )


def _trial(one: Trial) -> dict[str, Any]:
    return {
        "number": one.number,
        "seed": None if one.number == 0 else one.seed,
        "values": one.values,
        "objectives": one.objectives,
        "constraints": one.constraints,
        "missed": one.missed if not one.failure else None,
        "state": one.state,
        "failure": one.failure,
        "limits": [
            _bracket(bracket) for brackets in one.measured.limits.values() for bracket in brackets
        ],
    }


def _bracket(one: LimitFound) -> dict[str, Any]:
    return {"kind": one.kind, "low": one.low, "high": one.high}


def _design(found: Optimum, one: Design) -> dict[str, Any]:
    return {
        **_trial(one.trial),
        "chosen": one.chosen,
        "active": list(found.active(one.trial)),
        "at_ends": [
            {"quantity": found.plan.varied[index].name, "end": end}
            for index, end in found.at_ends(one.trial)
        ],
        "steps": [
            {
                "quantity": found.plan.varied[step.index].name,
                "step": step.size,
                "objectives": step.objectives,
                "feasible": step.feasible,
                "improves": step.improves,
                "failure": step.failure,
            }
            for step in one.steps
        ],
        "confirmed": [_confirmed_optimum_files(other) for other in one.confirmed],
        "valley": _valley(found, one),
    }


def _valley(found: Optimum, one: Design) -> dict[str, Any] | None:
    """Designs as good as the best: least and most of each quantity, and which are left open."""
    if one.valley is None:
        return None
    names = [varied.name for varied in found.plan.varied]
    ends = zip(one.valley.values.min(axis=0), one.valley.values.max(axis=0), strict=True)
    return {
        "within": ALIKE,
        "designs": len(one.valley.values),
        "quantities": {
            name: {"low": low, "high": high} for name, (low, high) in zip(names, ends, strict=True)
        },
        "open": [names[place] for place in one.valley.open],
    }


def _confirmed_optimum_files(one: Confirmed) -> dict[str, Any]:
    return {
        "by": one.label,
        "of_case": _trial(one.case),
        "design": _trial(one.design),
        "keeps_every_bound": one.design.feasible,
    }


def trials_csv(found: Optimum) -> str:
    """Every trial with all digits, SI; the head gives the units."""
    plan, stream = found.plan, io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    heads = [f"{one.name} [{one.si_unit or '1'}]" for one in plan.varied]
    heads += [
        f"objective {index + 1}: {one.measure.label} [{one.measure.si_unit}]"
        for index, one in enumerate(plan.objectives)
    ]
    heads += [
        f"constraint {index + 1}: {one.measure.label} [{one.measure.si_unit}]"
        for index, one in enumerate(plan.constraints)
    ]
    heads += [f"missed {index + 1} [1]" for index in range(len(plan.constraints))]
    writer.writerow(["trial", "seed", *heads, "state", "sentence"])
    for one in found.trials:
        missed = one.missed[: len(plan.constraints)]
        cells = [
            "" if np.isnan(value) else repr(float(value))
            for value in (*one.values, *one.objectives, *one.constraints, *missed)
        ]
        writer.writerow(
            [one.number, "" if one.number == 0 else one.seed, *cells, one.state, one.failure]
        )
    return stream.getvalue()


def _write_case(found: Optimum, design: Design, path: Path) -> Path:
    return write_text(path, case_text(found, design))


def write_optimum(
    found: Optimum, folder: Path, gaps: PartialFailures
) -> tuple[list[Path], Path | None]:
    """Write trials, Optuna study, case files and page into ``folder``; what could not be written
    is in ``gaps``. Files, and page.
    """
    made = [
        gaps.part(f"file '{TRIALS}'", None, lambda: write_text(folder / TRIALS, trials_csv(found))),
        gaps.part(f"file '{OPTUNA}'", None, lambda: write_optuna(found, folder / OPTUNA)),
    ]
    for index, design in enumerate(found.designs):
        name = BEST if index == 0 else f"design-{index + 1}.toml"
        made.append(
            gaps.part(f"file '{name}'", None, partial(_write_case, found, design, folder / name))
        )
    page = gaps.part(
        "report page",
        None,
        lambda: write_text(folder / "report.html", render(optimum_page(found), gaps)),
    )
    return [path for path in (*made, page) if path is not None], page


def report_optimum(found: Optimum, folder: Path) -> StudyFiles:
    """As :func:`write_optimum`. Raises :class:`RunFailedError` where a part could not be written."""
    failures = PartialFailures()
    files, _ = write_optimum(found, folder, failures)
    return files_of(folder, files, failures.sentences)
