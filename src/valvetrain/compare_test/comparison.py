"""Compares one run with a test: its curve with measured cycles, its numbers with measured values."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from valvetrain.arrays import Array, Flags
from valvetrain.compare_test.adequacy import (
    MIN_REPEATS,
    AdequacyTest,
    DifferenceBand,
    adequacy_test,
    difference_band,
    ring_weights,
)
from valvetrain.compare_test.agreement import Agreement, agreement
from valvetrain.errors import InputError
from valvetrain.measured.cycles import MeasuredCycles
from valvetrain.measured.sensor import Sensor
from valvetrain.measured.value_table import MeasuredValue, ValueTable
from valvetrain.quantities.compare import pair_angles
from valvetrain.quantities.traces import WHOLE, Active, trace_of
from valvetrain.solution.definition import angle_name
from valvetrain.solution.result import Solution
from valvetrain.units import dimension_of, dimension_powers, parse_quantity
from valvetrain.units.text import split_quantity


@dataclass(frozen=True, slots=True)
class SharedErrors:
    """Standard deviations of what all cycles share: ``offset`` (unit of the quantity, SI), ``gain``
    (a share), ``cam_angle`` (rad).

    >>> SharedErrors(offset=2.0, gain=0.01).text("N")
    'offset 2 N, gain 1 %'
    """

    offset: float = 0.0
    gain: float = 0.0
    cam_angle: float = 0.0

    def __bool__(self) -> bool:
        return max(self.offset, self.gain, self.cam_angle) > 0

    def shapes(self, cam_angle: Array, curve: Array) -> Array:
        """Standard deviation of each error along the turn, (errors, angles): level, in step with
        ``curve`` and with its slope.
        """
        around = np.concatenate([cam_angle[-1:] - 2 * np.pi, cam_angle, cam_angle[:1] + 2 * np.pi])
        slope = np.gradient(np.concatenate([curve[-1:], curve, curve[:1]]), around)[1:-1]
        rows = [self.offset * np.ones(len(curve)), self.gain * curve, self.cam_angle * slope]
        return np.array([row for row in rows if np.any(row)]).reshape(-1, len(curve))

    def text(self, unit: str) -> str:
        """The errors as text, the offset in its SI ``unit``."""
        parts = [
            f"offset {self.offset:.3g} {unit}" if self.offset else "", f"gain {100 * self.gain:.3g} %" if self.gain else "",
            f"angle {math.degrees(self.cam_angle):.3g} cam deg" if self.cam_angle else ""
        ]  # fmt: skip
        return ", ".join(filter(None, parts))


def read_shared(texts: Sequence[str], unit: str) -> SharedErrors:
    """Errors from texts such as ``("2 N", "0.5 %", "0.1 deg")``; ``unit``: SI unit of the quantity.

    Raises :class:`InputError` for an amount that is neither of the quantity, nor a share, nor an
    angle, or given twice.
    """
    found: dict[str, float] = {}
    for part in texts:
        _, own = split_quantity(part, None, "shared")
        if own == "%":
            key = "gain"
        elif dimension_powers(f"1 {own}".strip()) == dimension_powers(
            f"1 {'' if unit == '1' else unit}".strip()
        ):
            key = "offset"
        elif own and dimension_of(own) == "angle":
            key = "cam_angle"
        else:
            raise InputError(
                f"'{part[:40]}' is no error of a quantity in {unit or 'no unit'}; give an offset, a share in %, an angle",
                "shared",
            )
        if key in found:
            raise InputError(
                f"'{part[:40]}' is the second {key.replace('_', ' ')}; give one standard deviation of each kind",
                "shared",
            )
        found[key] = parse_quantity(part, None, "shared")
        if not found[key] > 0:
            raise InputError(
                f"'{part[:40]}' is no standard deviation; give it above zero", "shared"
            )
    return SharedErrors(**found)


@dataclass(frozen=True)
class ComparisonRequest:
    """A ``test`` and how runs are judged by it.

    Parameters
    ----------
    test : measured cycles or values
    engine_speeds : of the crank at which the case runs, rad/s
    notes : what was found or assumed, a sentence each
    shared : errors that all cycles share
    sensor : gauge through which the model is seen
    fitted : parameters of the model that were found from this test

    Raises
    ------
    InputError : a gauge or shared errors of a table
    """

    test: MeasuredCycles | ValueTable
    engine_speeds: tuple[float, ...] = ()
    notes: tuple[str, ...] = ()
    shared: SharedErrors = SharedErrors()
    sensor: Sensor | None = None
    fitted: int = 0

    def __post_init__(self) -> None:
        if isinstance(self.test, MeasuredCycles):
            return
        if self.shared:
            raise InputError(
                "a table states the scatter of each value; put what they share into it, or leave it out",
                "shared",
            )
        if self.sensor is not None:
            raise InputError(
                "a table holds named quantities; give the bandwidth of the load cell as [operation] force_bandwidth of the case",
                "sensor",
            )


#: Begin and end (cam rad) of a stretch of the turn, and its name.
Stage = tuple[str, float, float]
_TURN = 2 * math.pi
#: A cam angle that is counted through a cycle.
_COUNTED = re.compile(r"(.+)_\d+_cam_angle")


@dataclass(frozen=True, slots=True)
class StageRow:
    """Errors within a stretch of the turn, SI: ``bias``, ``rms`` of model less test, ``bias_standard_error``
    its standard error over the repeats (NaN for one), and the ``share_outside`` of its angles at
    which the band leaves no difference out.
    """

    name: str
    first: float
    last: float
    bias: float
    rms: float
    bias_standard_error: float
    share_outside: float


@dataclass(frozen=True, slots=True)
class ValueRow:
    """One measured value next to the model's, SI, shown in ``unit``. ``scatter``: standard
    deviation of the test's value (of the mean, where it has repeats); ``model`` is NaN where the
    run does not have it; ``kind`` says whether it is an angle of a value.
    """

    quantity: str
    unit: str
    engine_speed: float
    model: float
    test: float
    scatter: float
    kind: Literal["value", "angle"] = "value"

    @property
    def difference(self) -> float:
        """Model less test; angles the short way round."""
        off = self.model - self.test
        return (off + math.pi) % _TURN - math.pi if self.unit == "deg" else off

    @property
    def in_scatters(self) -> float:
        """Difference in units of the scatter."""
        return self.difference / self.scatter


@dataclass(frozen=True, eq=False)
class RunAgainstTest:
    """One run against the test. ``curve`` at the angles of the test, ``agreement``, ``band``
    and ``stages`` belong to measured cycles, ``values`` to a table; ``adequacy`` is None
    where ``without`` says why there is no F-test.
    """

    label: str
    model: str
    adequacy: AdequacyTest | None
    without: str = ""
    curve: Array | None = None
    agreement: Agreement | None = None
    band: DifferenceBand | None = None
    stages: tuple[StageRow, ...] = ()
    values: tuple[ValueRow, ...] = ()


def against_cycles(
    run: Solution,
    cycles: MeasuredCycles,
    request: ComparisonRequest,
    stages: Sequence[Stage],
    active: Active = WHOLE,
) -> RunAgainstTest:
    """A run against whole ``cycles`` (no value missing). Raises :class:`InputError` for a curve
    that the run does not have.
    """
    trace = trace_of(run, cycles.quantity, active)
    if request.sensor is not None:
        trace = trace.through(request.sensor)
    curve, values, angle = trace.at(cycles.cam_angle), cycles.values, cycles.cam_angle
    weights, even = ring_weights(angle)
    common = request.shared.shapes(angle, curve)
    band = difference_band(values, curve, common) if len(values) >= MIN_REPEATS else None
    adequacy, without = None, ""
    try:
        adequacy = adequacy_test(
            values,
            curve,
            weights,
            ring=even,
            fitted=request.fitted,
            shared=tuple((common**2 @ weights).tolist()),
        )
    except InputError as error:
        without = error.reason
    rows = []
    for name, first, last in stages:
        inside = (angle % _TURN >= first) & (angle % _TURN < last)
        if inside.sum() > 2:
            rows.append(_stage(name, first, last, curve, values, weights, inside, band))
    agreed = agreement(angle, values, curve, weights, even)
    return RunAgainstTest(run.label, run.model, adequacy, without, curve, agreed, band, tuple(rows))


def _stage(
    name: str,
    first: float,
    last: float,
    curve: Array,
    values: Array,
    weights: Array,
    inside: Flags,
    band: DifferenceBand | None,
) -> StageRow:
    shares = weights[inside] / weights[inside].sum()
    off = curve[inside] - values[:, inside].mean(axis=0)
    single = (curve[inside] - values[:, inside]) @ shares
    error = float(np.std(single, ddof=1)) / math.sqrt(len(single)) if len(single) > 1 else math.nan
    outside = math.nan if band is None else float(shares @ band.outside[inside])
    return StageRow(
        name, first, last, float(shares @ off), math.sqrt(float(shares @ off**2)), error, outside
    )


def against_values(
    runs: Mapping[float, Solution],
    still: Mapping[str, float],
    request: ComparisonRequest,
    values: Sequence[MeasuredValue],
    active: Active = WHOLE,
) -> RunAgainstTest:
    """Runs of one label, by crank speed (rad/s, as in ``values``), against a table."""
    first = next(iter(runs.values()))
    modelled = [
        _model_of(runs[measured.engine_speed], still, measured, active) for measured in values
    ]
    partners = counted_partners(values, {speed: run.quantities for speed, run in runs.items()})
    modelled = [
        (partners.get(place, model), angle) for place, (model, angle) in enumerate(modelled)
    ]
    rows: list[ValueRow] = []
    for measured, (model, place) in zip(values, modelled, strict=True):
        rows.append(
            ValueRow(
                measured.quantity,
                measured.unit,
                measured.engine_speed,
                model,
                measured.value,
                _error(measured),
            )
        )
        if math.isfinite(measured.angle_scatter) and math.isfinite(measured.cam_angle):
            rows.append(
                ValueRow(
                    measured.quantity,
                    "deg",
                    measured.engine_speed,
                    place,
                    measured.cam_angle,
                    measured.angle_scatter,
                    "angle",
                )
            )
    adequacy, without = None, ""
    try:
        adequacy = _adequacy(values, [model for model, _ in modelled], rows, request)
    except InputError as error:
        without = error.reason
    return RunAgainstTest(first.label, first.model, adequacy, without, values=tuple(rows))


def counted_partners(
    values: Sequence[MeasuredValue], named: Mapping[float, Mapping[str, float]]
) -> dict[int, float]:
    """Place of every measured angle that is counted through a cycle, ``clash_3_cam_angle``, and the
    model's that meets it: one more early on would shift the count of all that follow, so they meet
    in their order round the circle.
    """
    families: dict[tuple[float, str], list[int]] = {}
    for place, one in enumerate(values):
        if (counted := _COUNTED.fullmatch(one.quantity)) is not None:
            families.setdefault((one.engine_speed, counted[1]), []).append(place)
    partners: dict[int, float] = {}
    for (speed, word), places in families.items():
        places.sort(key=lambda place: values[place].value)
        mine = [
            value
            for name, value in named[speed].items()
            if (counted := _COUNTED.fullmatch(name)) and counted[1] == word
        ]
        met = pair_angles([values[place].value for place in places], mine)
        partners |= {
            place: math.nan if one is None else one for place, one in zip(places, met, strict=True)
        }
    return partners


def _error(measured: MeasuredValue) -> float:
    """Standard deviation of the value: stated, or of the mean of its repeats."""
    count = len(measured.repeats)
    return (
        measured.scatter
        if count < 2
        else float(np.std(measured.repeats, ddof=1)) / math.sqrt(count)
    )


def _adequacy(
    values: Sequence[MeasuredValue],
    modelled: Sequence[float],
    rows: Sequence[ValueRow],
    request: ComparisonRequest,
) -> AdequacyTest:
    """With repeats Fisher's test over values of one unit; with stated scatters the mean square of
    what the rows are off by in these.
    """
    if len(values[0].repeats) > 1:
        both = np.isfinite(modelled)
        if not both.any():
            raise InputError(
                "the run has none of these values, so there is no F-test; `valvetrain quantities` lists the names"
            )
        if len({measured.unit for measured in values}) > 1:
            raise InputError(
                "values in several units have no common variance, so there is no F-test; give a table per unit"
            )
        matrix = np.array([measured.repeats for measured in values])[both].T
        return adequacy_test(matrix, np.array(modelled)[both], fitted=request.fitted)
    off = np.array([row.in_scatters for row in rows if math.isfinite(row.model)])
    if not len(off):
        raise InputError(
            "the run has none of these values, so there is no test; `valvetrain quantities` lists the names"
        )
    count = len(off)
    return AdequacyTest(float(np.mean(off**2)), 1.0, 0, count, float(count), request.fitted)


def _model_of(
    run: Solution, still: Mapping[str, float], measured: MeasuredValue, active: Active
) -> tuple[float, float]:
    """Value of the run for a measured one and the cam angle of it; NaN where it gives none."""
    named = {**still, **run.quantities}
    kind, _, rest = measured.quantity.partition("_")
    extreme = kind in ("peak", "least") and bool(rest)
    try:
        if measured.quantity in named:
            at = angle_name(measured.quantity) if math.isfinite(measured.cam_angle) else ""
            return named[measured.quantity], named.get(at, math.nan)
        trace = trace_of(run, rest if extreme else measured.quantity, active)
    except InputError:
        return named.get(measured.quantity, math.nan), math.nan
    if extreme:
        top = int(np.argmax(trace.values) if kind == "peak" else np.argmin(trace.values))
        return float(trace.values[top]), float(trace.cam_angle[top])
    if not math.isfinite(measured.cam_angle):
        return math.nan, math.nan
    return float(trace.at(np.array([measured.cam_angle]))[0]), math.nan
