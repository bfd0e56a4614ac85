"""One field of a form from one field of a typed table: what may be written there, in which unit,
within which bounds.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any, Literal, get_args, get_origin

from annotated_types import Ge, Le
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.parameters.curves import Curve
from valvetrain.parameters.material import MATERIALS, Material
from valvetrain.parameters.schema_types import Quantity, Table
from valvetrain.parameters.summary import number
from valvetrain.parameters.toml_text import inline
from valvetrain.parameters.winding import EndCoil, EndKind
from valvetrain.units import DIMENSIONS, parse_quantity, to_unit, unit_factor

#: Last part of a key -> label, where the key's own words are not those of the field.
LABELS = {
    "youngs_modulus": "Young's modulus", "poisson_ratio": "Poisson's ratio", "lift_of": "Lift measured at", "zero_of_angle": "Zero of the cam angle",
    "law": "Contact law", "ends": "Both ends",
}  # fmt: skip
#: Last part of a key -> what it means, where the table that reads it does not say.
HELP = {
    "title": "one line above results", "description": "what the case is, on top of its page",
    "wire_diameter": "diameter of the wire; over the coils where it changes", "mean_diameter": "diameter of the helix of the wire's axis",
    "outer_diameter": "over the coils, in place of the mean diameter", "pitch": "rise of the wire's axis per turn",
    "height": "height of the wire's axis over the coil number, in place of the pitch", "total_coils": "all turns, tip to tip",
    "material": "name of a wire, or a table of its moduli and density", "lower_end": "end at the cylinder head",
    "upper_end": "end at the retainer", "installed_height": "seat to retainer with the valve closed", "name": "word for the spring",
    "preload": "force with the valve closed", "rate": "force per compression", "open_load": "force at the open valve",
    "open_lift": "lift between the two loads", "engine_speeds": "speeds of the crank, twice those of the cam: '4200, 5600 rpm'",
    "cam_speeds": "speeds of the cam, in place of those of the crank", "kind": "which law or train",
    "maximum_lift": "largest lift", "opening_start": "where the lift begins", "opening_end": "where the largest lift is reached",
    "closing_start": "where it is left", "closing_end": "where the valve is closed", "cam_angles": "angles of the stations",
    "lifts": "lifts at the stations", "file": "table next to the case", "base_radius": "radius of the base circle",
    "pivot": "point the lever turns about, from the cam centre", "drive_arm": "pivot to the point that the cam or pushrod moves",
    "inertia": "moment of inertia about the pivot", "mass": "moving mass", "stiffness": "force per way",
    "law": "how a contact presses", "radius": "of the crank", "rod_length": "of the connecting rod",
    "clearance": "piston to cylinder head at top dead centre", "top_dead_centre": "cam angle of it",
    "forces": "gas force on the valve head", "label": "word for the variant",
}  # fmt: skip
#: Key -> kind of the registry whose words it takes.
REGISTERED = {
    "lift_law.kind": "lifts", "train.kind": "mechanisms", "train.*spring_model": "springs", "train.contacts.*.law": "contacts",
    "*.contact.law": "coil_contacts",
}  # fmt: skip
#: Types that are written as text -> words to suggest.
SUGGESTED = {EndCoil: get_args(EndKind), Material: tuple(MATERIALS)}
#: One number with its unit.
_AMOUNT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\D.*?)?\s*")
#: A slider reaches this far on both sides of the value, in this many steps.
_REACH, _STEPS = 0.5, 50
Kind = Literal["text", "choice", "flag"]
#: Lowest and highest value, None for none.
Limits = tuple[float | None, float | None]


@dataclass(frozen=True, slots=True)
class Field:
    """One value of a case, as the script of the form takes it.

    Parameters
    ----------
    key : key path, as ``--set`` takes it
    label : words of the key
    kind : ``text``, ``choice`` (one of ``choices``) or ``flag`` (true, false)
    text : as written in the file, empty where it is left out
    unit : the unit in which it is written, else the default one
    limits : lowest and highest value in ``unit``, in words
    help : what it means
    source : where the value comes from (status and source of its note)
    required : the case cannot be read without it
    usual : what holds where it is left out
    choices : words of a ``choice``; of a ``text``, suggestions
    number : the value in ``unit``, None where it is no single number
    slider : lowest value, highest value and step of a slider in ``unit``, None where it makes no sense
    """

    key: str
    label: str
    kind: Kind
    text: str
    unit: str = ""
    limits: str = ""
    help: str = ""
    source: str = ""
    required: bool = False
    usual: str = ""
    choices: tuple[str, ...] = ()
    number: float | None = None
    slider: tuple[float, float, float] | None = None


def parts_of(annotation: Any) -> Iterator[Any]:
    """An annotation, and what it is made of: members of unions, marks, items of rows."""
    yield annotation
    for part in get_args(annotation):
        yield from parts_of(part)


def field_of(key: str, info: FieldInfo, value: Any, source: str) -> Field:
    """The field of the form at ``key``, whose bare ``value`` in the file is None where it is left out."""
    name, text = key.rpartition(".")[2], written(value)
    parts = [*parts_of(info.annotation), *info.metadata]
    mark = next((part for part in parts if isinstance(part, Quantity)), None)
    dimension = "length" if Curve in parts else mark.dimension if mark is not None else None
    unit = DIMENSIONS[dimension].default_unit if dimension else ""
    amount = None
    is_row = any(get_origin(part) is tuple for part in parts)
    if value is not None and not is_row and any(one in parts for one in (float, int, Curve)):
        amount, unit = _number(value, dimension, unit)
    limits = _limits(parts, unit) if dimension or not unit else (None, None)
    kind, choices = _choices(key, parts)
    return Field(
        key=key,
        label=LABELS.get(name, words_of(name).capitalize()),
        kind=kind,
        text=text,
        unit=unit,
        limits=_limits_text(limits),
        help=info.description or HELP.get(name, ""),
        source=source if text else "",
        required=info.is_required(),
        usual=usual_text(info),
        choices=choices,
        number=amount,
        slider=_slider(amount, limits, int in parts),
    )


def words_of(name: str) -> str:
    """Words of a key: ``wire_diameter`` -> wire diameter.

    >>> words_of("wire_diameter")
    'wire diameter'
    """
    return name.replace("_", " ")


def written(value: Any) -> str:
    """A value as ``--set`` takes it; empty for None.

    >>> written("4 mm"), written(["1 mm", "2 mm"]), written(True)
    ('4 mm', '["1 mm", "2 mm"]', 'true')
    """
    return "" if value is None else value if isinstance(value, str) else inline(value)


def _choices(key: str, parts: Sequence[Any]) -> tuple[Kind, tuple[str, ...]]:
    """How a value is given, and the words to choose from."""
    if bool in parts:
        return "flag", ("true", "false")
    for pattern, kind in REGISTERED.items():
        if fnmatchcase(key, pattern):
            return "choice", registry.names(kind)
    for part in parts:
        if get_origin(part) is Literal:
            return "choice", tuple(map(str, get_args(part)))
    return "text", next((words for kind, words in SUGGESTED.items() if kind in parts), ())


def _number(value: Any, dimension: str | None, unit: str) -> tuple[float | None, str]:
    """A value and its unit: the one it is written in, else the default one; None where it is no
    single number or refused.
    """
    try:
        si_value = float(parse_quantity(value, dimension))
    except (InputError, ValueError, TypeError):
        return None, unit
    amount = _AMOUNT.fullmatch(value) if isinstance(value, str) else None
    if amount is not None and amount[2]:
        return float(amount[1]), amount[2]
    return _rounded(float(to_unit(si_value, unit)) if unit else si_value), unit


def _rounded(value: float) -> float:
    """Twelve digits: what a change of units adds beyond them was never written."""
    return float(f"{value:.12g}")


def _limits(parts: Sequence[Any], unit: str) -> Limits:
    """Lowest and highest value in ``unit``."""
    low: Any = 0.0 if Curve in parts else None
    high: Any = None
    for part in parts:
        if isinstance(part, Quantity):
            low, high = part.low, part.high
        elif isinstance(part, Ge):
            low = part.ge
        elif isinstance(part, Le):
            high = part.le
    factor = unit_factor(unit) if unit else 1.0
    return (
        None if low is None else _rounded(low / factor),
        None if high is None else _rounded(high / factor),
    )


def _limits_text(limits: Limits) -> str:
    """Limits in words: "0.1 to 20", "0 or more"; empty without any."""
    low, high = limits
    if low is None:
        return "" if high is None else f"at most {number(high)}"
    return f"{number(low)} or more" if high is None else f"{number(low)} to {number(high)}"


def _slider(amount: float | None, limits: Limits, whole: bool) -> tuple[float, float, float] | None:
    """Half as much to half as much again, in round steps within the limits."""
    if not amount or not math.isfinite(amount):
        return None
    reach = abs(amount) * _REACH
    step = 1.0 if whole else _round_step(2 * reach / _STEPS)
    low = max(amount - reach, -math.inf if limits[0] is None else limits[0])
    high = min(amount + reach, math.inf if limits[1] is None else limits[1])
    low, high = (_rounded(round(end / step) * step) for end in (low, high))
    return (low, high, step) if high - low >= 2 * step else None


def _round_step(least: float) -> float:
    """1, 2 or 5 times a power of ten, the least that is no less than ``least``."""
    power = 10.0 ** math.floor(math.log10(least))
    return _rounded(next(n for n in (1, 2, 5, 10) if n * power >= least * (1 - 1e-9)) * power)


def usual_text(info: FieldInfo) -> str:
    """What holds where a value is left out, in words and in the unit in which it is usually given."""
    value = info.default
    if info.is_required() or info.default_factory is not None or value in (None, ""):
        return ""
    if isinstance(value, (BaseModel, Table, Mapping, list)):
        return ""
    if isinstance(value, (bool, str)):
        return str(value).lower() if isinstance(value, bool) else value.replace("`", "")
    mark = next((item for item in info.metadata if isinstance(item, Quantity)), None)
    if mark is None:
        if isinstance(value, tuple):
            return "-".join(map(str, value))
        return str(value) if isinstance(value, int) else number(value)
    unit = DIMENSIONS[mark.dimension].default_unit if mark.dimension else ""
    scale = unit_factor(unit) if unit else 1.0
    values = value if isinstance(value, tuple) else (value,)
    return f"{', '.join(number(entry / scale) for entry in values)} {unit}".strip()
