"""A study as JSON: one shape for every command, numbers as value and unit, SI except the engine
speed (rpm of the crank).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.findings.engine import measured as measured
from valvetrain.parameters.summary import rpm
from valvetrain.quantities.limits import passed_limits
from valvetrain.solution.critical import CriticalSpeed, SpeedBracket
from valvetrain.solution.definition import definition_of
from valvetrain.solution.modes import TrainModes
from valvetrain.solution.quantity import unit_of
from valvetrain.solution.result import Solution
from valvetrain.solution.static import SpringAtRest, named
from valvetrain.solution.status import Fact, Status
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import Comparison

if TYPE_CHECKING:
    from valvetrain.solution.uncertainty import Uncertainty

#: Units of numbers whose names do not give them; an event's details, options and statistics of a
#: run, facts of a spring at rest.
_UNITS = {
    "impulse": "N s", "card_lift": "m", "coil_contact_stiffness": "N/m^2", "contact_stiffness": "N/m^2", "mass_damping": "1/s",
    "stiffness_damping": "s", "time_step": "s", "coil_contact_damping_time": "s", "output_step": "rad",
    "force_bandwidth": "Hz", "largest_velocity": "m/s",
}  # fmt: skip


def quantities_object(values: Mapping[str, float]) -> dict[str, Any]:
    """Named SI quantities by name."""
    return {name: measured(value, definition_of(name).si_unit) for name, value in values.items()}


def engine_speed_object(engine_speed: float | None) -> dict[str, Any] | None:
    """A crank speed (rad/s) as rpm, null where none applies."""
    return None if engine_speed is None else measured(rpm(engine_speed), "rpm")


def status_object(status: Status) -> dict[str, Any]:
    """Status of a run."""
    if status.completed:
        return {"code": status.code} | ({"message": status.message} if status.message else {})
    label = {"message": status.message, "where": status.where, "remedy": status.remedy}
    return {"code": status.code, "time": measured(status.time, "s"), **label}


def _comparison_object(row: Comparison) -> dict[str, Any]:
    unit = unit_of(row.quantity)
    names = ("published", "computed", "difference", "tolerance", "blind")
    values = {name: getattr(row, name) for name in names}
    return {
        "quantity": row.quantity,
        "engine_speed": engine_speed_object(row.engine_speed),
        "model": row.model,
        "published_by": row.origin,
        "role": row.role,
        **{
            name: None if value is None else measured(value, unit) for name, value in values.items()
        },
        **{
            name: getattr(row, name)
            for name in ("verdict", "source", "used_for", "doubt", "reading")
        },
        "samples": None
        if row.samples is None
        else {
            "low": measured(row.samples.low, unit),
            "high": measured(row.samples.high, unit),
            "share_at_or_above": row.samples.share,
            "phases": row.samples.phases,
        },
    }


def uncertainty_object(row: Uncertainty) -> dict[str, Any]:
    """A number with its error bar and its range over the contact constants."""
    unit, found = unit_of(row.quantity), row.contact_range
    label = {"label": row.label} if row.label else {}
    return {
        "quantity": row.quantity,
        **label,
        "engine_speed": engine_speed_object(row.engine_speed),
        "value": measured(row.value, unit),
        "numerical_uncertainty": measured(row.numerical, unit),
        "resolved": row.resolved,
        "observed_order": measured(row.observed_order, "1"),
        "extrapolated": measured(row.extrapolated, unit),
        "step_part": measured(row.step_part, unit),
        "range": None
        if found is None
        else {
            "low": measured(found.low, unit),
            "high": measured(found.high, unit),
            "by": list(found.by),
        },
        "rests_on_contact_constants": row.rests_on_contact_constants,
    }


def study_json(study: Study) -> dict[str, Any]:
    """The study as plain dictionaries and lists, keys as in docs/quantities.md; every number comes
    with its unit.

    Parameters
    ----------
    study : what ``simulate``, ``compare`` or ``sweep`` gave

    Returns
    -------
    dict that ``json.dumps`` takes

    Raises nothing.

    Examples
    --------
    >>> import valvetrain as vt
    >>> found = vt.views.study_json(vt.simulate("job-t", "2000 rpm", models=["massless"]))
    >>> found["runs"][0]["quantities"]["peak_spring_force"]["unit"]
    'N'
    """
    still = {label: quantities_object(values) for label, values in study.still.items()}
    return {
        "command": study.command,
        "case": study.record.name,
        "title": study.record.title,
        "digest": study.record.digest,
        "changed": list(study.record.changed),
        "completed": not study.failures,
        "failures": list(study.failures),
        "quantities": still.pop("", {}),
        "quantities_by_label": still,
        "springs_at_rest": [_rest_object(one) for one in study.rest],
        **(
            {"train_modes": [_train_object(one) for one in study.train_modes]}
            if study.train_modes
            else {}
        ),
        "runs": [_run_object(run) for run in study.solutions],
        "critical_speeds": [_critical_object(one) for one in study.critical_speeds.rows],
        "comparisons": [_comparison_object(row) for row in study.comparisons],
        "findings": [
            {name: getattr(one, name) for name in ("place", "statement", "computed", "verdict")}
            for one in study.findings
        ],
        "uncertainties": [uncertainty_object(row) for row in study.error_bars.rows],
        "without_error_bars": [
            {
                "label": one.label,
                "engine_speed": engine_speed_object(one.engine_speed),
                "code": one.reason,
            }
            for one in study.error_bars.missing
        ],
        "rests_on": [_fact_object(one) for one in (*study.facts, *study.error_bars.facts)],
        "notes": list(study.notes),
        "cite": list(
            dict.fromkeys(
                sum(
                    (run.provenance.citations for run in study.solutions),
                    (*study.record.citations, *study.provenance.citations),
                )
            )
        ),
    }


def _fact_object(fact: Fact) -> dict[str, Any]:
    """A fact that the study rests on: its code, and its fields with their units."""
    fields = {
        name: engine_speed_object(float(value))
        if name.endswith("engine_speed")
        else _with_unit(name, value)
        for name, value in fact.fields.items()
    }
    return {"code": fact.code, **fields}


def _train_object(modes: TrainModes) -> dict[str, Any]:
    """Modes of a train: SI, bodies and parts by name; which mode of the closed valve (from 1) each continues."""
    each = [
        {
            "mode": place + 1,
            "natural_frequency": measured(float(frequency), "Hz"),
            "shape": dict(zip(modes.bodies, modes.shape[place].tolist(), strict=True)),
            "energy_share": dict(zip(modes.parts, modes.energy_share[place].tolist(), strict=True)),
            **(
                {
                    "closed_mode": modes.closed_mode[place] + 1,
                    "overlap": measured(modes.overlap[place], "1"),
                }
                if modes.closed_mode
                else {}
            ),
        }
        for place, frequency in enumerate(modes.natural_frequency)
    ]
    return {
        "label": modes.label,
        "state": modes.state,
        "closed": modes.closed,
        "open": modes.open,
        "cam_angle": measured(modes.cam_angle, "rad"),
        "valve_lift": measured(modes.valve_lift, "m"),
        "modes": each,
    }


def _run_object(run: Solution) -> dict[str, Any]:
    passed = {
        name: {**quantities_object({name: one.limit})[name], "reason": one.reason}
        for name, one in passed_limits(run.quantities).items()
    }
    clashes = sum(event.kind == "clash" for event in run.events)
    events = [
        {
            "kind": event.kind, "where": event.where, "cam_angle": measured(event.cam_angle, "rad"), "time": measured(event.time, "s"),
            "duration": measured(event.duration, "s"), "size": measured(event.size, event.unit),
            "details": {name: _with_unit(name, value) for name, value in event.details.items()},
        }
        for event in run.events
    ]  # fmt: skip
    return {
        "label": run.label,
        "model": run.model,
        "spring_set": run.spring_set,
        "engine_speed": engine_speed_object(run.engine_speed),
        "status": status_object(run.status),
        "quantities": quantities_object(run.quantities),
        **({"passed_limits": passed} if passed else {}),
        "clash_count": measured(run.quantities.get("clash_count", clashes), "1"),
        "events": events,
        "options": {
            name: _with_unit(name, value) for name, value in run.provenance.options.items()
        },
        "statistics": {name: _with_unit(name, value) for name, value in run.statistics.items()},
    } | ({"gaps": list(run.gaps)} if run.gaps else {})


def _critical_object(one: CriticalSpeed) -> dict[str, Any]:
    """A critical speed; ``engine_speed`` is null where control is not lost within ``searched``."""

    def within(engine_speed: float) -> dict[str, Any] | None:
        return engine_speed_object(engine_speed if 0 < engine_speed < math.inf else None)

    def bracket(found: SpeedBracket) -> dict[str, Any]:
        """A range; an end beyond the speeds searched is null."""
        ends = {"lower": found.lower_engine_speed, "upper": found.upper_engine_speed}
        return {name: within(end) for name, end in ends.items()}

    return {
        "label": one.label,
        "kind": one.kind,
        "places": list(one.places),
        "limit": measured(one.limit, "N" if one.kind == "contact-loss" else "m"),
        "searched": bracket(SpeedBracket(one.first_engine_speed, one.last_engine_speed)),
        "engine_speed": engine_speed_object(one.engine_speed) if one.found else None,
        "range": one.span and bracket(one.span),
        "range_causes": list(one.causes),
        "members": [
            {
                "cause": each.cause,
                "change": each.change,
                "engine_speed": within(each.engine_speed),
                "lost_from_the_first": each.engine_speed <= 0,
                "pulled": [bracket(every) for every in each.pulled],
                "refusal": each.refusal,
            }
            for each in one.members
        ],
        "pulled": [bracket(each) for each in one.pulled],
        "silent": [bracket(each) for each in one.silent],
        "onset": one.onset,
        "cause": one.cause,
        "spring_force_loss": measured(one.spring_force_loss, "N"),
        "text": one.text,
        "ranges": [bracket(each) for each in one.ranges],
        "short_count": measured(one.short_count, "1"),
        "falling_engine_speed": engine_speed_object(one.falling_engine_speed)
        if one.both_motions
        else None,
        "passed": [bracket(each) for each in one.passed],
        "runs_count": measured(one.runs_count, "1"),
    }


def _rest_object(one: SpringAtRest) -> dict[str, Any]:
    found: dict[str, Any] = {
        "spring": one.spring,
        "model": one.model,
        "precompression": measured(one.precompression, "m"),
        "facts": {name: _with_unit(name, value) for name, value in one.facts.items()},
    }
    if one.curve is not None:
        curve = {
            "compression": (one.curve.compression, "m"),
            "force": (one.curve.force, "N"),
            "stiffness": (one.curve.stiffness, "N/m"),
        }
        found["static_curve"] = {"status": status_object(one.curve.status)} | {
            name: {"values": np.asarray(values, dtype=float).tolist(), "unit": unit}
            for name, (values, unit) in curve.items()
        }
    if one.installed is not None:
        found["installed"] = quantities_object(named(one.installed))
    if one.points:
        found["points"] = [quantities_object(named(point)) for point in one.points]
    if one.modes is not None:
        axial = {mode: place for place, mode in enumerate(one.modes.axial_modes, start=1)}
        found["modes"] = {
            "status": status_object(one.modes.status),
            "compression": measured(one.modes.compression, "m"),
            "attached_mass": None
            if one.modes.attached_mass is None
            else measured(one.modes.attached_mass, "kg"),
        } | {
            "modes": [
                {
                    "mode": place + 1,
                    "natural_frequency": measured(float(value), "Hz"),
                    "axial": axial.get(place),
                    "axial_transmission_ratio": measured(
                        float(one.modes.axial_transmission[place]), "1"
                    ),
                }
                for place, value in enumerate(one.modes.natural_frequency)
            ]
        }
    return found


def _with_unit(name: str, value: object) -> Any:
    """A number with the SI unit of its name (``1`` for counts and shares); text and booleans unchanged."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return value
    try:
        return measured(value, _UNITS.get(name) or unit_of(name))
    except InputError:
        return measured(value, "1")
