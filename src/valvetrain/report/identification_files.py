"""Files of an identification: the JSON answer, draws as NetCDF with a checksum, and the page."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.identification.result import Branch, Identified
from valvetrain.report.identification_page import identification_page
from valvetrain.report.json import measured
from valvetrain.report.page import render
from valvetrain.solution.atomic import closing_line, write_bytes, write_text
from valvetrain.solution.channels import ChannelArrays, Variable
from valvetrain.solution.definition import si_words
from valvetrain.solution.netcdf import write_arrays
from valvetrain.units import dimension_of

PAGE, DRAWS = "report.html", "draws.nc"


def identification_json(found: Identified) -> dict[str, Any]:
    """The JSON answer: every number that has a unit beside its unit, SI."""
    units = {one.name: si_unit(one.unit) for one in found.unknowns}
    spread = {
        "best": "best",
        "mean": "mean",
        "standard_deviation": "deviation",
        "low": "low",
        "high": "high",
    }
    quantities = [
        {
            "share": branch.share,
            "misfit": branch.misfit,
            "quantities": {
                name: _each(one, spread, units[name]) for name, one in branch.quantities.items()
            },
            "correlation": branch.correlation,
            "told": dict(zip(found.names, branch.information.told.tolist(), strict=True)),
            "brought_by": _by_measurement(found, branch, branch.information.brought),
            "lost_without": _by_measurement(found, branch, branch.information.lost),
        }
        for branch in found.branches
    ]
    computed = {"computed": "best", "low": "low", "middle": "middle", "high": "high"}
    measurements = [
        {
            "measurement": one.datum.name,
            "key": one.datum.key,
            **_each(
                one.datum, {"measured": "value", "scatter": "scatter"}, si_unit(one.datum.unit)
            ),
            "fitted": one.datum.used,
            **_each(one, computed, si_unit(one.datum.unit)),
            "percentile": one.percentile,
            "source": one.datum.source,
        }
        for one in found.predicted
    ]
    conflicts = [
        {
            "measurement": one.datum.name,
            "key": one.datum.key,
            "scatters": one.off,
            "points_that_meet_it": one.meeting,
            "cost": one.cost,
            "missed_instead": [
                {"measurement": datum.name, "key": datum.key, "scatters": off}
                for datum, off in one.instead
            ],
        }
        for one in found.conflicts
    ]
    evidence = {
        "log": found.log_evidence,
        "error": found.evidence_error,
        "kind": found.evidence_kind,
    }
    profiles = {
        one.name: {
            "values": [measured(value, units[one.name]) for value in one.values],
            "misfit": one.misfit,
        }
        for one in found.profiles
    }
    return {
        "method": found.method,
        "whole": found.whole,
        "branches": quantities,
        "measurements": measurements,
        "conflicts": conflicts,
        "predictions": {
            one.key: _each(one, computed, si_unit(one.unit)) for one in found.predictions
        },
        "evidence": evidence,
        "profiles": profiles,
        "warnings": list(found.warnings),
        "evaluations": found.evaluations,
        "kept_from_before": found.kept,
    }


def _each(one: object, fields: Mapping[str, str], unit: str) -> dict[str, Any]:
    """Some fields of an object under their names in the answer, each with its unit."""
    return {name: measured(getattr(one, field), unit) for name, field in fields.items()}


def si_unit(unit: str) -> str:
    """SI unit of what is shown in ``unit``; ``SI`` where a number came without one.

    >>> si_unit("N/mm"), si_unit("deg"), si_unit("%"), si_unit("")
    ('N/m', 'rad', '1', 'SI')
    """
    dimension = dimension_of(unit) if unit else None
    return si_words(dimension) if dimension else "SI"


def _by_measurement(
    found: Identified, branch: Branch, shares: NDArray[np.float64]
) -> dict[str, dict[str, float]]:
    return {
        name: dict(zip(found.names, row.tolist(), strict=True))
        for name, row in zip(branch.information.measurements, shares, strict=True)
    }


def write_identification(found: Identified, folder: Path, title: str) -> list[Path]:
    """Write draws and page to ``folder``, each whole or not at all; the paths, the page last."""
    page = write_text(folder / PAGE, render(identification_page(title, found)))
    return [write_bytes(folder / DRAWS, draws_image(found)), page]


def draws_image(found: Identified) -> bytes:
    """Bytes of the NetCDF file: quantities, weights, branches and every computed number over the
    draws; ends in a checksum.
    """

    def over(values: Any, words: str, unit: str = "1") -> Variable:
        return Variable(("draw",), np.asarray(values), {"units": unit, "long_name": words})

    units = {one.name: si_unit(one.unit) for one in found.unknowns} | {
        one.datum.key: si_unit(one.datum.unit) for one in found.predicted
    }
    units |= {one.key: si_unit(one.unit) for one in found.predictions}
    variables = {
        "weight": over(found.weights, "weight of the draw"),
        "branch": over(found.branch_of, "branch of the draw"),
    }
    taken = {"weight", "branch"}
    for group, columns in (
        ("quantity", dict(zip(found.names, found.values.T, strict=True))),
        ("computed", dict(found.computed)),
    ):
        for name, values in columns.items():
            label = _label(f"{group}_{name}", taken)
            taken.add(label)
            variables[label] = over(values, name, units.get(name, "SI"))
    with io.BytesIO() as memory:
        write_arrays(
            memory, ChannelArrays(variables, {}, {"method": found.method, "title": found.name}), {}
        )
        image = memory.getvalue()
    return image + closing_line(image)


def _label(name: str, taken: set[str]) -> str:
    """A name as NetCDF takes it, each once."""
    plain = "".join(char if char.isalnum() and char.isascii() else "_" for char in name)
    return next(
        label
        for number in range(len(taken) + 2)
        if (label := plain if number == 0 else f"{plain}_{number}") not in taken
    )
