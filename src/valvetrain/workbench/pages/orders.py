"""The form of what may be run of a case, made from the fields of each request."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from valvetrain import registry
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.runs.request_fields import Option
from valvetrain.solution.definition import definition_of, label_of, names_for
from valvetrain.springs.spec import SpringModelSpec, spring_model
from valvetrain.system.build import default_models
from valvetrain.workbench.form_fields import words_of
from valvetrain.workbench.requests import REQUESTS, JobRequest, fields_of

#: The model that a first run of a spring alone uses: seconds, and it moves.
FIRST_MODEL = "multi-mass"
#: Labels of fields, where the words of their names are not enough.
LABELS = {
    "engine_speeds": "Engine speeds (crank)", "models": "Spring models", "first_engine_speed": "From", "last_engine_speed": "To",
    "implausible": "Accept implausible values",
}  # fmt: skip
#: What holds where a field without a default is empty.
USUAL = {"engine_speeds": "as the case says"}
#: Kind of a job -> what it does.
KINDS = {
    "run": "Run at engine speeds", "sweep": "Sweep over engine speed", "branches": "Branches of motion",
    "study": "Study of a quantity", "run-up": "Run-up", "static": "Static curve", "modes": "Modes", "refine": "Error bars",
}  # fmt: skip

#: Numbers of one revolution that branches show, the first by default.
OF_A_REVOLUTION = ("loft_gap", "seating_velocity", "float_excess_lift", "peak_valve_lift")

Choice = dict[str, Any]


def orders_for(
    case: Case, quantities: Sequence[Mapping[str, Any]], earlier: Iterable[JobRequest] = ()
) -> dict[str, Any]:
    """What the page offers: the ``kinds`` of jobs, each with its ``fields``, and what is ``given`` to each of them at first.

    Parameters
    ----------
    case : the case
    quantities : of the form, which a study may vary
    earlier : requests of the case, the newest first
    """
    choices: dict[str, list[Choice]] = {
        "models": models_for(case),
        "spring_sets": sets_for(case),
        "quantity": [{"value": "", "label": "choose …"}, *map(_varied, quantities)],
        "result": outputs_for(case),
    }
    kinds, given = [], {}
    for kind in KINDS:
        if (kind in ("run-up", "branches") and case.train is None) or (
            case.lift_law is None and kind in ("sweep", "study", "refine")
        ):
            continue
        of_kind = choices | ({"quantity": _labelled(OF_A_REVOLUTION)} if kind == "branches" else {})
        fields = [
            _field(name, one, of_kind.get(name))
            for name, one in fields_of(REQUESTS[kind]).items()
            if name not in of_kind or of_kind[name]
        ]
        kinds.append({"kind": kind, "label": KINDS[kind], "fields": fields})
        given[kind] = {one["name"]: one["value"] for one in fields}
    for job in reversed(tuple(earlier)):
        given.setdefault(job.kind, {}).update(job.given)
    return {"kinds": kinds, "given": given}


def _field(name: str, asked: Option, choices: list[Choice] | None) -> dict[str, Any]:
    """A field as its script takes it, with the ``value`` that it has at first."""
    kind: str = "text"
    value: Any = ""
    if choices is not None and asked.repeatable:
        kind, value = "many", [one["value"] for one in choices if one["chosen"]]
    elif choices is not None:
        kind, value = "choice", choices[0]["value"]
    elif not asked.metavar:
        kind, value = "flag", "/" in asked.flag
    return {
        "name": name,
        "label": LABELS.get(name, words_of(name).capitalize()),
        "help": asked.meaning,
        "kind": kind,
        "choices": choices or [],
        "usual": asked.default or USUAL.get(name, ""),
        "value": value,
    }


def _varied(quantity: Mapping[str, Any]) -> Choice:
    """A quantity of the form that a study varies, a fifth either way: farther away most points may be no engine."""
    value, low, high = (float(quantity[name]) for name in ("value", "low", "high"))
    ends = sorted((0.8 * value, 1.2 * value)) if value else (low, high)
    first, last = max(low, ends[0]), min(high, ends[1])
    sets = {
        "lowest": f"{first:.4g} {quantity['unit']}",
        "highest": f"{last:.4g} {quantity['unit']}",
    }
    return {
        "value": quantity["key"],
        "label": quantity["label"],
        "sets": {name: text.strip() for name, text in sets.items()},
    }


def springs_of(case: Case) -> tuple[InstalledSpring, ...]:
    """Every spring of a case, of a train those of the set in use: a card in another set runs by fewer models."""
    if case.train is None:
        return case.springs
    sets = case.train.springs
    return tuple(sets[case.train.spring_set or next(iter(sets))]) if sets else ()


def models_for(case: Case) -> list[Choice]:
    """Spring models that can run the case, with what they know; the default first one is chosen."""
    springs = springs_of(case)
    fit = [spec for spec in map(spring_model, registry.names("springs")) if _fits(spec, case)]
    names = [spec.word for spec in fit]
    first = FIRST_MODEL if case.train is None else case.train.model_of()
    chosen = [word for word in (first, *default_models(springs)) if word in names][:1]
    return [
        {
            "value": spec.word,
            "label": spec.label,
            "hint": f"knows {spec.knows}; leaves out {spec.leaves_out}",
            "chosen": spec.word in chosen,
        }
        for spec in fit
    ]


def _fits(spec: SpringModelSpec, case: Case) -> bool:
    springs = springs_of(case)
    moves = not spec.no_motion and not (case.train is not None and spec.alone and not spec.driver)
    return moves and bool(springs) and not any(spec.why_not(spring) for spring in springs)


def sets_for(case: Case) -> list[Choice]:
    """Spring sets to choose from, where a train has more than one; that in use is chosen."""
    if case.train is None or len(case.train.springs) < 2:
        return []
    names = list(case.train.springs)
    in_use = case.train.spring_set or names[0]
    return [{"value": name, "label": name, "chosen": name == in_use} for name in names]


def outputs_for(case: Case) -> list[Choice]:
    """Quantities that a study can have as outputs."""
    return _labelled(names_for("study", "spring" if case.train is None else "train"))


def _labelled(names: Iterable[str]) -> list[Choice]:
    """Quantities with their labels."""
    return [
        {"value": name, "label": ", ".join(filter(None, (label_of(name), definition_of(name).remark)))}
        for name in names
    ]  # fmt: skip
