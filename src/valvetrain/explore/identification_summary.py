"""An identification in words: rows of its tables in the units of the trade, for terminal and page
alike.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from valvetrain.explore.identified import Branch, Conflict, Identified, Predicted, Prediction
from valvetrain.explore.posterior import Datum, Unknown
from valvetrain.explore.space import Prior
from valvetrain.report.text import number, unit_text
from valvetrain.units import unit_factor

#: Heads of the tables whose rows the functions below give.
FOUND = ("quantity", "likeliest", "2.5 %", "97.5 %", "", "prior", "learned from data")
MEASURED = ("measurement", "measured", "±", "computed", "2.5 %", "97.5 %", "", "percentile")
CONFLICTS = ("missed", "scatters", "met by", "cost", "missed instead")
PREDICTED = ("not measured", "likeliest", "2.5 %", "50 %", "97.5 %", "")
#: Percentiles outside these are worth a look.
ODD = (2.5, 97.5)


def shown(value: float, unit: str, digits: int = 5) -> str:
    """A value (SI) in a unit."""
    return number(float(value) / unit_factor(unit), digits)


def prior_text(prior: Prior, unit: str) -> str:
    """A prior in one phrase."""
    low, high = (shown(end, unit, 4) for end in (prior.low, prior.high))
    if prior.flat:
        return f"{low} to {high}{', even in its logarithm' if prior.logarithmic else ''}"
    spread = (
        f"× {np.exp(prior.spread):.3g}"
        if prior.logarithmic
        else f"± {shown(prior.spread, unit, 3)}"
    )
    bounds = (
        "" if not (np.isfinite(prior.low) or np.isfinite(prior.high)) else f" ({low} to {high})"
    )
    return f"{shown(prior.centre, unit, 4)} {spread}{bounds}"


def found_rows(found: Identified, branch: Branch) -> list[tuple[str, ...]]:
    """Cells under :data:`FOUND`: each quantity, its interval, its prior and how much of the prior's
    variance the data remove.
    """
    rows = []
    for index, one in enumerate(found.unknowns):
        interval, reported = branch.quantities[one.name], branch.information.determined[index]
        ends = (shown(value, one.unit) for value in (interval.best, interval.low, interval.high))
        rows.append(
            (
                _plain_name(one.name),
                *ends,
                unit_text(one.unit),
                prior_text(one.prior, one.unit),
                f"{100 * reported:.0f} %",
            )
        )
    return rows


def measured_cells(one: Predicted) -> tuple[str, ...]:
    """Cells under :data:`MEASURED`."""
    datum = one.datum
    values = (
        shown(value, datum.unit)
        for value in (datum.value, datum.scatter, one.best, one.low, one.high)
    )
    return (
        datum_label(datum),
        *values,
        unit_text(datum.unit),
        "–" if np.isnan(one.percentile) else f"{one.percentile:.1f}",
    )


def conflict_cells(one: Conflict) -> tuple[str, ...]:
    """Cells under :data:`CONFLICTS`."""
    instead = ", ".join(f"{datum_label(datum)} ({off:+.1f})" for datum, off in one.instead) or (
        "nothing more" if one.meeting else "–"
    )
    several = f" (worst of {one.values} missed)" if one.values > 1 else ""
    return (
        f"{datum_label(one.datum)}{several}",
        f"{one.off:+.1f}",
        f"{one.meeting} points",
        f"{one.cost:.3g}" if one.meeting else "–",
        instead,
    )


def prediction_cells(one: Prediction) -> tuple[str, ...]:
    """Cells under :data:`PREDICTED`."""
    return (
        _plain_name(one.key),
        *(shown(value, one.unit) for value in (one.best, one.low, one.middle, one.high)),
        unit_text(one.unit),
    )


def datum_label(datum: Datum) -> str:
    """A measurement as a line begins with it; its key where the name does not show which of several
    values it is.
    """
    phrase, key = _plain_name(datum.measurement or datum.key), datum.key.replace("_", " ")
    return phrase if datum.measurement in ("", datum.key) else f"{phrase}: {key}"


def share_rows(branch: Branch, shares: NDArray[np.float64]) -> list[tuple[str, ...]]:
    """Measurement by quantity: shares in per cent, a dot for none."""
    return [
        (_plain_name(name), *(f"{100 * share:.0f}" if share >= 0.005 else "·" for share in row))
        for name, row in zip(branch.information.measurements, shares, strict=True)
    ]


def facts(found: Identified) -> tuple[tuple[str, str], ...]:
    """The most important results."""
    before = f" and {found.reused} before" if found.reused else ""
    rows = [
        ("method", found.method),
        ("branches", str(len(found.branches))),
        ("points computed", f"{found.evaluations}{before}"),
    ]
    if np.isfinite(found.log_evidence):
        error = (
            f" ± {found.evidence_error:.2f}"
            if np.isfinite(found.evidence_error)
            else f" ({found.evidence_kind})"
        )
        rows.append(("log evidence", f"{found.log_evidence:.2f}{error}"))
    if found.fit is not None:
        rows.append(("goodness of fit", found.fit.phrase))
    used = [one for one in found.predicted if one.datum.used]
    rows.append(("data fitted, compared", f"{len(used)}, {len(found.predicted) - len(used)}"))
    return tuple(rows)


def is_odd(one: Predicted) -> bool:
    """Whether a measurement is outside :data:`ODD` of its prediction; one that has no percentile
    does not.
    """
    return one.percentile < ODD[0] or one.percentile > ODD[1]


def odd(found: Identified) -> list[Predicted]:
    """Measurements that are outside :data:`ODD` of their predictions."""
    return [one for one in found.predicted if is_odd(one)]


#: Quantities that the verdict gives, and share of the prior's variance below which the data have not
#: determined one.
MAX_NAMED, LEARNED = 3, 0.5


def identified_verdict(found: Identified) -> str:
    """The likeliest values with their intervals, those that the data do not determine, and the
    measurements that are missed, in one sentence.
    """
    branch = found.branches[0]
    order = np.argsort(-branch.information.determined, kind="stable").tolist()
    known = [k for k in order if branch.information.determined[k] >= LEARNED]
    open_ = [_inner_name(found.unknowns[k].name) for k in order if k not in known]
    parts = []
    for index in known[:MAX_NAMED]:
        one = found.unknowns[index]
        interval = branch.quantities[one.name]
        low, best, high = (
            shown(value, one.unit, 4) for value in (interval.low, interval.best, interval.high)
        )
        parts.append(
            f"{_inner_name(one.name)} {best} {unit_text(one.unit)}".rstrip()
            + f" (95 % {low} to {high}{f'; {meaning}' if (meaning := found.meanings.get(one.name)) else ''})"
        )
    if len(known) > MAX_NAMED:
        parts.append(f"{len(known) - MAX_NAMED} more")
    said = ", ".join(parts) or "the data determine nothing"
    said = f"{said[:1].upper()}{said[1:]}"
    if parts and open_:
        said += f"; not determined: {', '.join(open_[:MAX_NAMED])}"
    # fitted values as the table of conflicts counts them; those compared by their percentile
    compared = [one.datum for one in odd(found) if not one.datum.used]
    missed = [*(one.datum for one in found.conflicts), *compared]
    count, values = sum(one.values for one in found.conflicts) + len(compared), len(found.predicted)
    if missed:
        verb = "is" if count == 1 else "are"
        said += f"; {count} of {values} measured values {verb} missed, most {_lower(datum_label(missed[0]))}"
    elif values and not (found.fit and found.fit.missed):
        said += (
            f"; every one of {values} measured values is met"
            if values > 1
            else "; the measurement is met"
        )
    lead = "" if found.whole else "Stopped before its end: "
    if found.fit and found.fit.missed:
        lead = (
            f"{found.fit.sentence}: intervals are those of {found.fit.widening:.2g} times the stated scatter and hold the truth "
            "only where that was stated too small, not where the model is wrong. "
        )
    branches = f"; {len(found.branches)} branches fit" if len(found.branches) > 1 else ""
    return f"{lead}{said}{branches}."


def title_of(one: Unknown) -> str:
    """A quantity with its unit, as an axis has it."""
    return f"{_plain_name(one.name)}{f' ({unit_text(one.unit)})' if one.unit else ''}"


def density_label(one: Unknown) -> str:
    """Axis of a probability density of a quantity, with its unit."""
    return f"density (1/{unit_text(one.unit)})" if one.unit else "density"


def _lower(phrase: str) -> str:
    """A phrase within a sentence; what begins with a sign or an abbreviation stays."""
    return phrase if phrase[1:2].isupper() else f"{phrase[:1].lower()}{phrase[1:]}"


def _inner_name(name: str) -> str:
    return _lower(_plain_name(name))


def _plain_name(name: str) -> str:
    phrase = name.replace("_", " ")
    return phrase[:1].upper() + phrase[1:]
