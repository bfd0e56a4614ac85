"""The page of an identification: what was found, what the data determine, measured against
predicted.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.fit import REFUSED
from valvetrain.explore.identification_charts import (
    dots_chart,
    marginals_chart,
    pairs_chart,
    profiles_chart,
)
from valvetrain.explore.identification_summary import (
    CONFLICTS,
    FOUND,
    MEASURED,
    ODD,
    PREDICTED,
    conflict_cells,
    datum_label,
    facts,
    found_rows,
    is_odd,
    measured_cells,
    odd,
    prediction_cells,
    prior_text,
    share_rows,
)
from valvetrain.explore.identified import MET, Branch, Identified
from valvetrain.report.json import measured
from valvetrain.report.page import (
    Block,
    Cell,
    Details,
    Grid,
    Page,
    Section,
    figure_or_gap,
    render,
    text,
)
from valvetrain.report.study import StudyFiles, files_of
from valvetrain.report.text import unit_text
from valvetrain.report.verdict import verdict_of
from valvetrain.solution.atomic import closing_line, write_bytes, write_text
from valvetrain.solution.channels import ChannelArrays, Variable
from valvetrain.solution.definition import si_unit_text
from valvetrain.solution.netcdf import write_arrays
from valvetrain.units import dimension_of

_BROUGHT = (
    "Share of each measurement in what the data say of a quantity, the other quantities known (%)."
)
_CONFLICTS = (
    f"Measurements that the likeliest point misses by more than {MET:g} scatters, and how many computed points meet them. Cost: by how "
    "much the likeliest of those has the larger misfit, as far as the search went; what it misses instead contradicts the measurement, "
    "under this model and these priors."
)
_LOST = (
    "By how much less is left open of a quantity (its variance) than without the measurement (%)."
)


def identification_page(title: str, found: Identified) -> Page:
    """The whole page."""
    sections = [Section("found", "What was found", _found(found))]
    sections.append(Section("measured", "Measured against predicted", _measured(found)))
    picture = figure_or_gap("marginals", marginals_chart, found)
    pairs = figure_or_gap("pairs", pairs_chart, found)
    if pairs:
        sections.append(Section("pairs", "What depends on what", pairs))
    sections.append(Section("told", "What each measurement contributes", _reported(found)))
    profiles = figure_or_gap("profiles", profiles_chart, found)
    if profiles:
        sections.append(Section("profiles", "Profiles", profiles))
    priors = (_priors(found),)
    sections.append(Section("priors", "What was known before", priors, folded=True))
    lead = (
        "Intervals hold 95 % of what the measurements and the priors leave open, if the model is right and the stated scatter is; where "
        f"it cannot meet the data (p below {REFUSED:g}) they are those of a scatter as large as the misfit requires. A "
        "percentile gives the position of a measured value among those that would be measured: near 0 or 100 model and measurement disagree."
    )
    said = verdict_of(found)
    return Page(title, "Identification", lead, facts(found), tuple(sections), "", said, picture)


def identified_page(found: Identified) -> Page:
    """The page of an identification without a title of its own."""
    return identification_page("Identification", found)


def _found(found: Identified) -> tuple[Block, ...]:
    blocks: list[Block] = []
    if not found.whole:
        blocks.append(text("The search was stopped before its end; this is what it had.", "alert"))
    for number, branch in enumerate(found.branches):
        if len(found.branches) > 1:
            blocks.append(text(f"{found.branch_label(number).capitalize()}."))
        blocks.append(_found_grid(found, branch))
    return (
        *blocks,
        *(text(phrase[:1].upper() + phrase[1:] + ".", "alert") for phrase in found.warnings),
    )


def _found_grid(found: Identified, branch: Branch) -> Grid:
    tones = ("", "number", "number", "number", "", "quiet", "number")
    rows = tuple(
        (tuple(Cell(*cell) for cell in zip(row, tones, strict=True)), ())
        for row in found_rows(found, branch)
    )
    return Grid(
        FOUND, rows, caption="determined: share of the prior's variance that the data remove"
    )


def _measured(found: Identified) -> tuple[Block, ...]:
    tones = ("", "number", "number quiet", "number", "number", "number", "", "number")
    rows = []
    for one in found.predicted:
        phrase, role = measured_cells(one), "fitted" if one.datum.used else "compared"
        cells = [
            Cell(word, f"{tone} bad" if is_odd(one) and index == len(tones) - 1 else tone)
            for index, (word, tone) in enumerate(zip(phrase, tones, strict=True))
        ]
        rows.append(((*cells, Cell(role, "tag")), (role,)))
    grid = Grid(
        (*MEASURED, "use"),
        tuple(rows),
        ("use",),
        "computed: at the likeliest point; 2.5 and 97.5 % over what is left open",
    )
    far_off = odd(found)
    said = ", ".join(f"{datum_label(one.datum)} ({one.percentile:.1f})" for one in far_off[:8])
    reported = (
        (
            text(
                f"Outside {ODD[0]} to {ODD[1]} % of their predictions: {said}{' and more' if len(far_off) > 8 else ''}.",
                "alert",
            ),
        )
        if far_off
        else ()
    )
    return (
        *figure_or_gap("measured against predicted", dots_chart, found),
        *reported,
        grid,
        *_conflicts(found),
        *_predictions(found),
    )


def _conflicts(found: Identified) -> tuple[Block, ...]:
    """What meeting a missed measurement costs the others."""
    tones = ("", "number bad", "number", "number", "")
    rows = tuple((tuple(map(Cell, conflict_cells(one), tones)), ()) for one in found.conflicts)
    return (Grid(CONFLICTS, rows, caption=_CONFLICTS),) if rows else ()


def _predictions(found: Identified) -> tuple[Block, ...]:
    """What was computed and not measured."""
    tones = ("", "number", "number", "number", "number", "")
    rows = tuple((tuple(map(Cell, prediction_cells(one), tones)), ()) for one in found.predictions)
    return (
        (
            Grid(
                PREDICTED, rows, caption="computed values without a measurement, over the posterior"
            ),
        )
        if rows
        else ()
    )


def _reported(found: Identified) -> tuple[Block, ...]:
    heads = ("measurement", *(name.replace("_", " ") for name in found.names))
    blocks: list[Block] = []
    for number, branch in enumerate(found.branches, start=1):
        reported = branch.information
        grids = tuple(
            Grid(
                heads,
                tuple(
                    (tuple(Cell(word, "number" if at else "") for at, word in enumerate(row)), ())
                    for row in rows
                ),
                (),
                phrase,
            )
            for rows, phrase in (
                (share_rows(branch, reported.brought), _BROUGHT),
                (share_rows(branch, reported.lost), _LOST),
            )
        )
        blocks += grids if number == 1 else [Details(f"branch {number}", grids)]
    return tuple(blocks)


def _priors(found: Identified) -> Grid:
    rows = tuple(
        (
            (
                Cell(one.name.replace("_", " ")),
                Cell(one.prior.kind),
                Cell(prior_text(one.prior, one.unit)),
                Cell(unit_text(one.unit)),
                Cell(one.prior.source, "quiet"),
            ),
            (),
        )
        for one in found.unknowns
    )
    return Grid(("quantity", "prior", "", "", "source"), rows)


PAGE, DRAWS = "report.html", "draws.nc"


def identification_json(found: Identified) -> dict[str, Any]:
    """The JSON answer: every number that has a unit with its unit, SI."""
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
            "share": branch.share if found.weighed else None,
            "misfit": branch.misfit,
            "fit": _fit(branch),
            "quantities": {
                name: _each(one, spread, units[name]) for name, one in branch.quantities.items()
            },
            "correlation": branch.correlation,
            "told": dict(zip(found.names, branch.information.determined.tolist(), strict=True)),
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
            "missed_values": one.values,
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
        "kept_from_before": found.reused,
    }


def _fit(branch: Branch) -> dict[str, Any] | None:
    one = branch.fit
    if one is None:
        return None
    return {
        "chi_square": one.chi_square,
        "degrees_of_freedom": one.freedom,
        "p_value": one.p_value,
        "posterior_predictive_p_value": one.predictive,
        "met": not one.missed,
        "intervals_widened_for_scatter_times": one.widening,
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
    return si_unit_text(dimension) if dimension else "SI"


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

    def over(values: Any, phrase: str, unit: str = "1") -> Variable:
        return Variable(("draw",), np.asarray(values), {"units": unit, "long_name": phrase})

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


def report_identification(found: Identified, folder: Path) -> StudyFiles:
    """As :func:`write_identification`, under the name of the identification."""
    return files_of(folder, write_identification(found, folder, found.name or "identification"))
