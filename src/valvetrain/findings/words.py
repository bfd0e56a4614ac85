"""Numbers and templates as a person reads them: the one place for units, digits, error bars and language.

Findings hold SI numbers with the names of their quantities. What stands behind this file is text, so another
system of units or another language is a table here, and never a second set of rules.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Union

from valvetrain.solution.definition import definition_of
from valvetrain.units.reader import shown_system

#: Share of a value from which its error bar is printed, and from which the value is not resolved.
COARSE, UNRESOLVED = 0.05, 0.5
#: A number below this is zero: what rounding leaves.
NOTHING = 1e-9
#: One turn per minute (rad/s).
RPM = math.pi / 30
DEGREE = math.pi / 180


@dataclass(frozen=True, slots=True)
class Amount:
    """A number (SI) of the quantity ``name`` with its error ``bar`` (SI; 0: none is known). ``rests_on``: what
    nobody knows and decides the number, which is then not resolved; empty otherwise.

    >>> Amount("peak_spring_force", 1900.0, 1000.0).resolved
    False
    """

    name: str
    value: float
    bar: float = 0.0
    rests_on: str = ""

    @property
    def resolved(self) -> bool:
        """Whether the error bar is below half of the number, and nothing unknown decides it."""
        if self.rests_on:
            return False
        return self.bar == 0 or self.bar < UNRESOLVED * abs(self.value)


class Unit(NamedTuple):
    """A unit for values below ``upto`` (SI); ``size``: one of it in SI."""

    text: str
    size: float
    upto: float = math.inf


#: System -> dimension -> its units by rising size; a dimension that a system does not list is that of ``si``.
UNITS: dict[str, dict[str, tuple[Unit, ...]]] = {
    "si": {
        "length": (Unit("µm", 1e-6, 0.0995e-3), Unit("mm", 1e-3)),
        "force": (Unit("N", 1, 1e4), Unit("kN", 1e3)),
        "time": (Unit("µs", 1e-6, 0.0995e-3), Unit("ms", 1e-3, 1), Unit("s", 1)),
        "pressure": (Unit("MPa", 1e6),),
        "stiffness": (Unit("N/mm", 1e3),),
        "energy": (Unit("mJ", 1e-3, 1), Unit("J", 1)),
        "impulse": (Unit("mN s", 1e-3),),
        "velocity": (Unit("m/s", 1),),
        "acceleration": (Unit("m/s²", 1),),
        "moment": (Unit("N m", 1),),
        "power": (Unit("W", 1),),
        "mass": (Unit("g", 1e-3),),
        "frequency": (Unit("Hz", 1),),
        "angle": (Unit("deg", DEGREE),),
        "angular speed": (Unit("rpm", RPM),),
        "ratio": (Unit("", 1),),
        "strain": (Unit("µm/m", 1e-6),),
        "cam velocity": (Unit("mm/deg", 1e-3 / DEGREE),),
        "cam acceleration": (Unit("µm/deg²", 1e-6 / DEGREE**2),),
    },
    # small lengths in thousandths of an inch, as engine shops write them
    "imperial": {
        "length": (Unit("thou", 25.4e-6, 2.54e-3), Unit("in", 25.4e-3)),
        "force": (Unit("lbf", 4.4482216),),
        "pressure": (Unit("ksi", 6.894757e6),),
        "stiffness": (Unit("lbf/in", 175.12684),),
        "energy": (Unit("in lbf", 0.112984829),),
        "impulse": (Unit("lbf s", 4.4482216),),
        "velocity": (Unit("ft/s", 0.3048),),
        "acceleration": (Unit("g", 9.80665),),
        "moment": (Unit("lbf in", 0.112984829),),
        "cam velocity": (Unit("thou/deg", 25.4e-6 / DEGREE),),
        "cam acceleration": (Unit("thou/deg²", 25.4e-6 / DEGREE**2),),
        "power": (Unit("hp", 745.69987),),
    },
}
_TURNING = re.compile(r"(cam|crank)_angle(_range)?$")
_FIELD = re.compile(r"\{(\w+)(?:\.\.(\w+))?(?::(\d))?\}")
_OPTIONAL = re.compile(r"\[([^\[\]]*)\]")


def digits_text(value: float, bar: float = 0.0, digits: int = 3) -> str:
    """A number with at most ``digits`` significant digits, and none behind the first digit of its error bar.

    >>> digits_text(1957.4), digits_text(6729, 57), digits_text(0.03), digits_text(80.89, 12)
    ('1960', '6730', '0.03', '80')
    """
    if not math.isfinite(value):
        return "–"
    if abs(value) < NOTHING:
        return "0"
    places = digits - 1 - math.floor(math.log10(abs(value)))
    if bar > 0:
        places = min(places, -math.floor(math.log10(bar)))
    rounded = round(value, places)
    text = f"{rounded:.{max(places, 0)}f}"
    exact = "." in text and not bar and math.isclose(rounded, value, rel_tol=1e-9)
    return (text.rstrip("0").rstrip(".") if exact else text).replace("-", "−")


def percent(share: float) -> str:
    """A share with two digits: ``6.2 %``."""
    return f"{digits_text(100 * share, 0, 2)} %"


def speed_text(engine_speed: float, unit: str = " rpm") -> str:
    """An engine speed (rad/s) that was asked for: ``5600 rpm``."""
    return f"{round(engine_speed / RPM, 3):.0f}{unit}"


def about(engine_speed: float, half: float = 0.0) -> str:
    """An engine speed (rad/s) that was found, in rpm, without digits behind the first of ``half`` its range (rad/s).

    >>> about(6729 * RPM), about(6729 * RPM, 57 * RPM), about(11819 * RPM)
    ('6730', '6730', '11820')
    """
    speed = engine_speed / RPM
    return digits_text(speed, half / RPM, 3 if speed < 9999.5 else 4)


def speeds_text(engine_speeds: Sequence[float]) -> str:
    """Several engine speeds (rad/s): ``4200, 5600 and 8000 rpm``."""
    return f"{joined([speed_text(one, '') for one in engine_speeds])} rpm"


def joined(parts: Sequence[str], last: str = "and") -> str:
    """``a``, ``a and b``, ``a, b and c``; empty for none."""
    return f"{', '.join(parts[:-1])} {last} {parts[-1]}" if len(parts) > 1 else "".join(parts)


@dataclass(frozen=True, slots=True)
class Phrase:
    """A part of a sentence as data: a ``template`` with its ``fields``, so that it has units and a language too."""

    template: str
    fields: Mapping[str, Said] = field(default_factory=dict)


#: What a field of a template may hold.
Said = Union[Amount, str, Phrase, Sequence["Said"]]  # noqa: UP007


class MissingFieldError(KeyError):
    """A field that a template names outside brackets and a finding does not have."""


@dataclass(frozen=True)
class Words:
    """How numbers and templates become text.

    >>> Words("imperial").amount(Amount("loft_gap", 3.2e-4))
    '12.6 thou'

    Parameters
    ----------
    units : system of :data:`UNITS`, ``si`` or ``imperial``; without it that of the reader
    brief : in cells of tables a number that is not resolved is its range alone
    case : what a command is given to take the case again; empty: its name
    templates : rule code -> part (``text``, ``reason``, ``step``, ``remark``) -> template in another language
    """

    units: str = field(default_factory=shown_system)
    brief: bool = False
    case: str = ""
    templates: Mapping[str, Mapping[str, str]] = field(default_factory=dict)

    def unit(self, name: str, value: float) -> Unit:
        """The unit in which a ``value`` (SI) of the quantity ``name`` is read."""
        row = definition_of(name)
        dimension = row.dimension or ("strain" if name.endswith("strain") else "ratio")
        choice = UNITS[self.units].get(dimension) or UNITS["si"].get(dimension)
        if choice is None:
            return Unit(row.si_unit, 1.0)
        found = next(one for one in choice if abs(value) < one.upto)
        turning = _TURNING.search(name) if dimension == "angle" else None
        return found._replace(text=f"{turning[1]} deg") if turning else found

    def number(self, one: Amount, unit: Unit, digits: int = 3) -> str:
        """The number alone, in ``unit``."""
        return digits_text(one.value / unit.size, one.bar / unit.size, digits)

    def amount(self, one: Amount, digits: int = 3) -> str:
        """``81 N``, ``1130 ± 100 N``; for a number that is not resolved the range of its error bar.

        >>> Words().amount(Amount("peak_spring_force", 1900.0, 1000.0))
        'not resolved (900 to 2900 N)'
        """
        unit = self.unit(one.name, max(abs(one.value), one.bar))
        if one.rests_on:
            return "not resolved" if self.brief else f"not resolved ({one.rests_on})"
        if not one.resolved:
            least = one.value - one.bar
            ends = (max(0.0, least) if one.value >= 0 else least), one.value + one.bar
            low, high = (digits_text(end / unit.size, 0, 2) for end in ends)
            text = f"{low} to {high} {unit.text}".strip()
            return f"about {text}" if self.brief else f"not resolved ({text})"
        text = self.number(one, unit, digits)
        if one.bar > COARSE * abs(one.value):
            text += f" ± {digits_text(one.bar / unit.size, one.bar / unit.size)}"
        return f"{text} {unit.text}".strip()

    def between(self, one: Amount) -> str:
        """A number with its error bar, however small the bar; a range where it is not resolved.

        >>> Words().between(Amount("peak_spring_force", 1900.0, 1.6))
        '1900.0 ± 1.6 N'
        """
        if not (one.bar and one.resolved):
            return self.amount(one, 4)
        unit = self.unit(one.name, one.value)
        value, bar = one.value / unit.size, one.bar / unit.size
        return f"{digits_text(value, bar / 10, 9)} ± {digits_text(bar, 0, 2)} {unit.text}".strip()

    def span(self, least: Amount, most: Amount, digits: int = 3) -> str:
        """``436 to 1960 N``: two numbers with their unit once; only that which is resolved."""
        if not (least.resolved and most.resolved):
            if most.resolved:
                return f"up to {self.amount(most, digits)}"
            return f"from {self.amount(least, digits)}" if least.resolved else "not resolved"
        unit = self.unit(most.name, most.value)
        low, high = (self.number(one, unit, digits) for one in (least, most))
        return f"{low if low == high else f'{low} to {high}'} {unit.text}".strip()

    def fill(self, template: str, fields: Mapping[str, Said], digits: int = 3) -> str:
        """A template with its fields in place: ``{name}``, ``{least..most}`` for a range, ``{name:2}`` for two digits.

        What stands in ``[ ]`` is left out where a field of it is missing, empty, zero or not resolved.

        Raises
        ------
        MissingFieldError : a field outside brackets that is missing

        >>> Words().fill("{x}[ at {y}][, {z}]", {"x": "contact", "y": Amount("loft_cam_angle", 4.0)})
        'contact at 229 cam deg'
        """

        def value(found: re.Match[str], sure: bool = False) -> str:
            one, other = fields.get(found[1], ""), fields.get(found[2] or "")
            if one in ("", ()) or (found[2] and other is None):
                raise MissingFieldError(found[1])
            if sure and isinstance(one, Amount) and (abs(one.value) < NOTHING or not one.resolved):
                raise MissingFieldError(found[1])
            count = int(found[3] or digits)
            if isinstance(one, Amount) and isinstance(other, Amount):
                return self.span(one, other, count)
            return self.said(one, count)

        def optional(found: re.Match[str]) -> str:
            try:
                return _FIELD.sub(lambda one: value(one, sure=True), found[1])
            except MissingFieldError:
                return ""

        while _OPTIONAL.search(template):
            template = _OPTIONAL.sub(optional, template)
        return re.sub(r" ([,;:.])(?=\s|$)", r"\1", _FIELD.sub(value, template)).strip(" ,;:")

    def cell(self, template: str, fields: Mapping[str, Said]) -> str:
        """As :meth:`fill`; empty where a field is missing."""
        try:
            return self.fill(template, fields)
        except MissingFieldError:
            return ""

    def said(self, one: Said, digits: int = 3) -> str:
        """What a field holds, as text; several parts with commas."""
        if isinstance(one, Amount):
            return self.amount(one, digits)
        if isinstance(one, Phrase):
            return self.fill(one.template, one.fields, digits)
        return one if isinstance(one, str) else ", ".join(self.said(part, digits) for part in one)


def fields_of(template: str) -> tuple[str, ...]:
    """Names of the fields of a template, in order.

    >>> fields_of("{least..most}[ at {where:2}]")
    ('least', 'most', 'where')
    """
    return tuple(name for found in _FIELD.findall(template) for name in found[:2] if name)
