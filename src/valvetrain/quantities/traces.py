"""Curves over the cam angle by the name of what was measured: channels of a run, and what a sensor
on a coil sees.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.measured.sensor import Sensor
from valvetrain.quantities.cycle import is_closed, reported_cycle
from valvetrain.quantities.forces import END_FORCES, fine_of_cycle
from valvetrain.solution.result import Solution

_TURN = 2 * np.pi
#: Name -> channel of the same curve under the name that quantities have.
ALIASES = {word: channel for channel, word in END_FORCES.items()}
#: What is measured on a coil -> channel along the wire or over the coil pairs, and the sign that
#: counts towards the seat as positive.
ON_COILS = {
    "displacement": ("axial_displacement", -1.0), "velocity": ("axial_velocity", -1.0), "acceleration": ("axial_acceleration", -1.0),
    "gap": ("coil_gap", 1.0), "contact_force": ("coil_contact_force", 1.0), "shear_stress": ("inner_fibre_shear_stress", 1.0),
}  # fmt: skip
_COIL = re.compile(
    r"(?:(?P<spring>[a-z][a-z0-9]*)_)?(?P<by>coil|section)_(?P<coil>\d{1,3}(?:[._]\d{1,3})?)_(?P<what>[a-z_]+)"
)
#: Springs known by their card number their places from 0 to 1; a wire has more turns than this.
CARD_LENGTH = 1.5
#: Spring -> first and last coil number of its active wire.
Active = Mapping[str, tuple[float, float]]
#: Where nothing is known of inactive coils.
WHOLE: Active = MappingProxyType({})
#: A wire has a point, and a pair of coils a place, within this many turns of the coil requested.
REACH = 0.3


@dataclass(frozen=True, eq=False)
class Trace:
    """A curve over one cam revolution: ``cam_angle`` (rad, from 0, rising, shape (samples,)),
    ``values`` and their SI ``unit``.

    ``time`` (s) that the turn takes; ``closed``: the end follows on the beginning.

    >>> trace = Trace(np.array([0.0, 2.0, 4.0]), np.array([1.0, 3.0, 2.0]), "N", 0.02, True)
    >>> trace.at(np.array([1.0, 2.0]))
    array([2., 3.])
    """

    cam_angle: Array
    values: Array
    unit: str
    time: float
    closed: bool

    def at(self, cam_angle: Array) -> Array:
        """Values at cam angles (rad, any turn), straight between samples."""
        return np.interp(cam_angle % _TURN, self.cam_angle, self.values, period=_TURN)

    def through(self, sensor: Sensor) -> Trace:
        """What a gauge shows of it, turn after turn."""
        angle = np.append(self.cam_angle, self.cam_angle[0] + _TURN)
        seen = sensor.response(angle * self.time / _TURN, np.append(self.values, self.values[0]))
        return Trace(self.cam_angle, seen[:-1], self.unit, self.time, self.closed)


def trace_of(solution: Solution, name: str, active: Active = WHOLE) -> Trace:
    """The curve ``name`` of the reported cycle of a run: a channel, ``spring_force``,
    ``coil_2_displacement``, ``outer_coil_3.5_gap``.

    ``section_0.5`` represents a share of the active wire from the seat, for springs known by their
    card have no coils; ``active``: spring -> coil numbers between which its wire is active, where
    not all of it is. Displacement, velocity and acceleration of a coil count towards the seat, as
    it moves when the valve opens. Raises :class:`InputError`, listing the names there are, for a
    name that the run does not give.
    """
    cycle = reported_cycle(solution)
    channel = ALIASES.get(name, name)
    if channel in END_FORCES and solution.has(channel):
        angle, values = fine_of_cycle(cycle, channel)
        return _trace(solution, angle, values, channel)
    if solution.has(channel) and solution.channel(channel).ndim == 1:
        return _trace(solution, cycle.cam_angle, cycle.channel(channel), channel)
    found = _COIL.fullmatch(name)
    if found is not None and found["what"] in ON_COILS:
        first, sign = ON_COILS[found["what"]]
        channel = f"{found['spring']}_{first}" if found["spring"] else first
        values_at = cycle.at_coil(channel, _coil_of(solution, channel, found, active), REACH)
        if values_at is not None:
            return _trace(solution, cycle.cam_angle, sign * values_at, channel)
    known = trace_names(solution)
    raise InputError(
        f"the {solution.label or solution.model} run has no curve '{name[:60]}'; it has {', '.join(known) if known else 'none'}",
        "quantity",
    )


def _coil_of(solution: Solution, channel: str, match: re.Match[str], active: Active) -> float:
    """Coil number that a channel knows a place on the wire by."""
    place = float(match["coil"].replace("_", "."))
    places = (
        solution.arrays.along(channel)
        if match["by"] == "section" and solution.has(channel)
        else None
    )
    if places is None or not len(places):
        return place
    first, last = float(np.min(places)), float(np.max(places))
    if last > CARD_LENGTH:
        first, last = active.get(match["spring"] or next(iter(solution.springs), ""), (first, last))
    return first + place * (last - first) if place <= 1 else np.inf


def _trace(solution: Solution, cam_angle: Array, values: Array, channel: str) -> Trace:
    seconds = (
        _TURN / (solution.engine_speed / 2)
        if solution.engine_speed
        else float(solution.time[-1] - solution.time[0])
    )
    unit = {"m/s2": "m/s^2"}.get(solution.unit(channel), solution.unit(channel))
    return Trace(
        np.asarray(cam_angle, dtype=float),
        np.asarray(values, dtype=float),
        unit,
        seconds,
        is_closed(solution),
    )


def trace_names(solution: Solution) -> tuple[str, ...]:
    """Names that :func:`trace_of` takes for a run; coils are given as a range, ``coil_{0.5 to
    6.5}_gap``.
    """
    arrays = solution.arrays.variables
    names = [word for word, channel in ALIASES.items() if channel in arrays]
    names += [
        name
        for name, one in arrays.items()
        if len(one.dims) == 1 and not name.endswith(("_time", "_highest", "_lowest"))
    ]
    for what, (channel, _) in ON_COILS.items():
        for name in arrays:
            places = (
                solution.arrays.along(name)
                if name.endswith(channel) and len(arrays[name].dims) == 2
                else None
            )
            first = name.removesuffix(channel)
            if places is not None and len(places) and (not first or first.endswith("_")):
                names += [
                    f"{first}coil_{{{np.min(places):.3g} to {np.max(places):.3g}}}_{what}",
                    f"{first}section_{{0 to 1}}_{what}",
                ]
    return tuple(dict.fromkeys(names))
