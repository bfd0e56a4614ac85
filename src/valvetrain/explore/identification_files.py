"""Files of an identification: its JSON answer, the draws, the case with the likeliest values, and the page."""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.explore.identification_answer import IdentificationAnswer
from valvetrain.explore.identified import Array, Branch, Identified
from valvetrain.explore.posterior import Datum
from valvetrain.findings.words import Words
from valvetrain.solution.atomic import closing_line, write_bytes, write_text
from valvetrain.solution.channels import ChannelArrays, Variable
from valvetrain.solution.definition import si_unit_text
from valvetrain.solution.netcdf import write_arrays
from valvetrain.solution.partial_failures import PartialFailures
from valvetrain.units import dimension_of
from valvetrain.views.json import measured
from valvetrain.views.results import write_page
from valvetrain.views.study_files import StudyFiles, files_of

DRAWS, CASE = "draws.nc", "identified.toml"


#: Name in the answer -> field, of an interval, of what is computed, and of the goodness of fit.
INTERVAL = {
    "best": "best", "mean": "mean", "standard_deviation": "deviation", "low": "low", "high": "high",
}  # fmt: skip
COMPUTED = {"computed": "best", "low": "low", "middle": "middle", "high": "high"}
FIT = {
    "chi_square": "chi_square", "degrees_of_freedom": "freedom", "p_value": "p_value", "posterior_predictive_p_value": "predictive",
    "intervals_widened_for_scatter_times": "widening",
}  # fmt: skip


def identification_json(found: Identified) -> dict[str, Any]:
    """The JSON answer: every number that has a unit with its unit, SI."""
    units = {one.name: one.unit for one in found.unknowns}
    measurements = [
        {
            **_named(one.datum), **_each(one.datum, {"measured": "value", "scatter": "scatter"}, one.datum.unit), "fitted": one.datum.used,
            **_each(one, COMPUTED | {"at_start": "start"}, one.datum.unit), "percentile": one.percentile, "source": one.datum.source,
        }
        for one in found.predicted
    ]  # fmt: skip
    conflicts = [
        {
            **_named(one.datum), "scatters": one.off, "missed_values": one.values, "points_that_meet_it": one.meeting, "cost": one.cost,
            "missed_instead": [{**_named(datum), "scatters": off} for datum, off in one.instead],
        }
        for one in found.conflicts
    ]  # fmt: skip
    profiles = {
        one.name: {"values": [_measured(value, units[one.name]) for value in one.values], "misfit": one.misfit}
        for one in found.profiles
    }  # fmt: skip
    return {
        "method": found.method, "whole": found.whole,
        "start": {name: _measured(value, units[name]) for name, value in found.start.items()},
        "branches": [_branch(found, one) for one in found.branches], "measurements": measurements, "conflicts": conflicts,
        "predictions": {one.key: _each(one, COMPUTED, one.unit) for one in found.predictions},
        "evidence": {"log": found.log_evidence, "kind": found.evidence_kind},
        "profiles": profiles, "notes": [found.note] if found.note else [],
        "findings": [one.to_dict() for one in IdentificationAnswer(found, Words()).findings],
        "evaluations": found.evaluations, "kept_from_before": found.reused,
    }  # fmt: skip


def _branch(found: Identified, branch: Branch) -> dict[str, Any]:
    def by_name(row: Array) -> dict[str, float]:
        return dict(zip(found.names, row.tolist(), strict=True))

    told, fit = branch.information, branch.fit
    shares = {
        key: {name: by_name(row) for name, row in zip(told.measurements, rows, strict=True)}
        for key, rows in (("brought_by", told.brought), ("lost_without", told.lost))
    }
    met = {} if fit is None else {key: getattr(fit, name) for key, name in FIT.items()}
    return {
        "share": branch.share, "misfit": branch.misfit, "fit": met | {"met": not fit.missed} if fit else None,
        "quantities": {one.name: _each(branch.quantities[one.name], INTERVAL, one.unit) for one in found.unknowns},
        "correlation": branch.correlation, "told": by_name(told.determined), **shares,
    }  # fmt: skip


def _named(datum: Datum) -> dict[str, str]:
    return {"measurement": datum.name, "key": datum.key}


def _measured(value: float, unit: str) -> dict[str, Any]:
    return measured(value, si_unit(unit))


def _each(one: object, fields: Mapping[str, str], unit: str) -> dict[str, Any]:
    """Some fields of an object under their names in the answer, each with its unit."""
    return {name: _measured(getattr(one, field), unit) for name, field in fields.items()}


def si_unit(unit: str) -> str:
    """SI unit of what is shown in ``unit``; ``SI`` where a number came without one.

    >>> si_unit("N/mm"), si_unit("deg"), si_unit("%"), si_unit("")
    ('N/m', 'rad', '1', 'SI')
    """
    dimension = dimension_of(unit) if unit else None
    return si_unit_text(dimension) if dimension else "SI"


def write_identification(found: Identified, folder: Path, gaps: PartialFailures) -> list[Path]:
    """Write draws, case file and page to ``folder``, each whole or not at all; the paths, the page last."""
    files: list[Path | None] = [
        gaps.part(f"file '{DRAWS}'", None, lambda: write_bytes(folder / DRAWS, draws_image(found)))
    ]
    if found.case_file:
        files.append(
            gaps.part(f"file '{CASE}'", None, lambda: write_text(folder / CASE, found.case_file))
        )
    page = write_page(IdentificationAnswer(found, Words(case=str(folder / CASE))), folder, gaps)
    return [one for one in (*files, page) if one is not None]


def draws_image(found: Identified) -> bytes:
    """Bytes of the NetCDF file: quantities, weights, branches and every computed number over the
    draws; ends in a checksum.
    """
    units = {one.key: one.unit for one in found.predictions}
    units |= {one.datum.key: one.datum.unit for one in found.predicted}
    units |= {one.name: one.unit for one in found.unknowns}
    names = [("weight", "weight of the draw", "1"), ("branch", "branch of the draw", "1")]
    names += [(f"quantity_{one}", one, si_unit(units[one])) for one in found.names]
    names += [(f"computed_{one}", one, si_unit(units.get(one, ""))) for one in found.computed]
    columns = (found.weights, found.branch_of, *found.values.T, *found.computed.values())
    variables = dict[str, Variable]()
    for (label, phrase, unit), values in zip(names, columns, strict=True):
        plain = re.sub(r"\W", "_", label, flags=re.ASCII)
        while plain in variables:
            plain += "_"
        described = {"units": unit, "long_name": phrase}
        variables[plain] = Variable(("draw",), np.asarray(values), described)
    with io.BytesIO() as memory:
        write_arrays(
            memory, ChannelArrays(variables, {}, {"method": found.method, "title": found.name}), {}
        )
        image = memory.getvalue()
    return image + closing_line(image)


def report_identification(found: Identified, folder: Path) -> StudyFiles:
    """As :func:`write_identification`. Raises :class:`RunFailedError` where a part could not be written."""
    gaps = PartialFailures()
    return files_of(folder, write_identification(found, folder, gaps), gaps.sentences)
