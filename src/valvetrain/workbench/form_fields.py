"""One field of a form from one field of a typed table: what may be written there, in which unit,
within which bounds.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Ge, Le
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.parameters.material import MATERIALS
from valvetrain.parameters.schema_curves import CurveField
from valvetrain.parameters.schema_spring import EndField, MaterialField
from valvetrain.parameters.schema_types import Quantity
from valvetrain.parameters.spring import EndKind
from valvetrain.parameters.summary import number
from valvetrain.parameters.toml_text import inline
from valvetrain.units import DIMENSIONS, parse_quantity, to_unit, unit_factor

#: Last part of a key -> label, where the key's own words are not those of the field.
LABELS = {
    "youngs_modulus": "Young's modulus", "poisson_ratio": "Poisson's ratio", "lift_of": "lift measured at", "zero_of_angle": "zero of the cam angle",
    "kind": "kind", "law": "contact law", "ends": "both ends",
}  # fmt: skip

#: Last part of a key -> what it means, where the table that reads it does not say.
HELP = {
    "title": "one line above results", "description": "what the case is, on top of its page",
    "wire_diameter": "diameter of the wire; over the coils where it changes", "mean_diameter": "diameter of the helix of the wire's axis",
    "outer_diameter": "over the coils, in place of the mean diameter", "pitch": "rise of the wire's axis per turn",
    "height": "height of the wire's axis over the coil number, in place of the pitch", "total_coils": "all turns, tip to tip",
    "material": "name of a wire, or a table of its moduli and density", "lower_end": "end at the cylinder head",
    "upper_end": "end at the retainer",
    "installed_height": "seat to retainer with the valve closed", "name": "word for the spring",
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
    "forces": "gas force on the valve head",
    "label": "word for the variant",
}  # fmt: skip


Kind = Literal["number", "text", "choice", "flag", "curve"]
#: One number with its unit.
_AMOUNT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\D.*?)?\s*")
#: A slider reaches this far on both sides of the value, in this many steps.
_REACH, _STEPS = 0.5, 50


@dataclass(frozen=True, slots=True)
class Field:
    """One value of a case.

    Parameters
    ----------
    key : key path, as ``--set`` and :meth:`Workspace.set_value` take it
    label : words of the key
    kind : ``number`` (with a unit), ``text``, ``choice`` (one of ``choices``), ``flag`` (true,
        false), ``curve`` (over the coils)
    value_text : as written in the file, empty where it is left out
    unit : default unit, in which ``limits`` are given
    limits : lowest and highest value in ``unit``, None for none
    help : what it means
    source : where the value comes from (status and source of its note)
    required : the case cannot be read without it
    default_text : what holds where it is left out
    choices : words of a ``choice``; of a ``text``, suggestions
    number : the value in ``unit``, None where it is no single number
    slider : lowest value, highest value and step of a slider in ``unit``, None where one makes no
        sense
    """

    key: str
    label: str
    kind: Kind
    value_text: str
    unit: str = ""
    limits: tuple[float | None, float | None] = (None, None)
    help: str = ""
    source: str = ""
    required: bool = False
    default_text: str = ""
    choices: tuple[str, ...] = ()
    number: float | None = None
    slider: tuple[float, float, float] | None = None


@dataclass(frozen=True, slots=True)
class _Form:
    """What an annotation allows."""

    kind: Kind
    dimension: str | None = None
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()
    whole: bool = False
    listed: bool = False


def field_of(key: str, name: str, info: FieldInfo, value: Any) -> Field | None:
    """The field of a form; None for a table of its own."""
    form = _form(info.annotation, tuple(info.metadata))
    form = _with_registry(key, name, form)
    if form is None:
        return None
    number, unit = None, _unit(form)
    if form.kind in ("number", "curve") and value is not None:
        number, unit = _number(value, form, unit)
    kind: Kind = (
        "number" if form.kind == "curve" and (value is None or number is not None) else form.kind
    )
    limits = _limits(form, unit)
    return Field(
        key, LABELS.get(name, text_of(name)), kind, written(value), unit, limits,
        help=info.description or HELP.get(name, ""), required=info.is_required(), default_text=_default(info), choices=form.choices,
        number=number, slider=_slider(number, limits, form.whole),
    )  # fmt: skip


def text_of(name: str) -> str:
    """Words of a key: ``wire_diameter`` -> wire diameter.

    >>> text_of("wire_diameter")
    'wire diameter'
    """
    return name.replace("_", " ")


def written(value: Any) -> str:
    """A value as ``--set`` takes it; empty for None.

    >>> written("4 mm"), written(["1 mm", "2 mm"]), written(True)
    ('4 mm', '["1 mm", "2 mm"]', 'true')
    """
    return "" if value is None else value if isinstance(value, str) else inline(value)


def _form(annotation: Any, metadata: tuple[Any, ...]) -> _Form | None:
    """What an annotation allows, through unions with None and notes; None for a table."""
    for known, form in _KNOWN:
        if annotation is known or _same(annotation, known, metadata):
            return form
    low: float | None = None
    high: float | None = None
    dimension: str | None = None
    for mark in metadata:
        if isinstance(mark, Quantity):
            dimension, low, high = mark.dimension, mark.low, mark.high
        elif isinstance(mark, Ge):
            low = float(mark.ge)  # type: ignore[arg-type]
        elif isinstance(mark, Le):
            high = float(mark.le)  # type: ignore[arg-type]
    origin = get_origin(annotation)
    if origin is Annotated:
        inner, *more = get_args(annotation)
        return _form(inner, (*metadata, *more))
    if origin in (Union, UnionType):
        inner = [part for part in get_args(annotation) if part is not type(None)]
        return _form(inner[0], metadata) if len(inner) == 1 else _Form("text")
    if origin is Literal:
        return _Form("choice", choices=tuple(map(str, get_args(annotation))))
    if annotation is bool:
        return _Form("flag", choices=("true", "false"))
    if annotation is int:
        return _Form("number", None, low, high, whole=True)
    if annotation is float:
        return _Form("number", dimension, low, high)
    if origin is tuple:
        return _Form("text", dimension, listed=True)
    if annotation is str:
        return _Form("text")
    return None


def _same(annotation: Any, known: Any, metadata: tuple[Any, ...]) -> bool:
    """Whether an annotation taken apart (its type, and its marks) is a known annotated one."""
    inner, *marks = get_args(known)
    return (
        annotation == inner
        and bool(marks)
        and all(any(mark is one for one in metadata) for mark in marks)
    )


_KNOWN: tuple[tuple[Any, _Form], ...] = (
    (CurveField, _Form("curve", "length", low=0.0)),
    (EndField, _Form("text", choices=tuple(get_args(EndKind)))),
    (MaterialField, _Form("text", choices=tuple(MATERIALS))),
)


def _with_registry(key: str, name: str, form: _Form | None) -> _Form | None:
    """Words of the registry where a key takes one of them."""
    kinds = {"lift_law.kind": "lifts", "train.kind": "mechanisms"}
    named = {"law": "contacts", "spring_model": "springs"} if key.startswith("train.") else {}
    kind = kinds.get(key) or named.get(name, "")
    return _Form("choice", choices=registry.names(kind)) if kind else form


def _unit(form: _Form) -> str:
    return DIMENSIONS[form.dimension].default_unit if form.dimension is not None else ""


def _number(value: Any, form: _Form, unit: str) -> tuple[float | None, str]:
    """A value and its unit: the one it is written in, else the default one; None where it is no
    single number or refused.
    """
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        return None, unit
    if form.whole:
        return (float(value) if isinstance(value, int) else None), unit
    try:
        si_value = float(parse_quantity(value, form.dimension))
        if isinstance(value, str) and (found := _AMOUNT.fullmatch(value)) is not None and found[2]:
            return float(found[1]), found[2]
        return _rounded(float(to_unit(si_value, unit)) if unit else si_value), unit
    except (InputError, ValueError, TypeError):
        return None, unit


def _rounded(value: float) -> float:
    """Twelve digits: what a change of units adds beyond them was never written."""
    return float(f"{value:.12g}")


def _limits(form: _Form, unit: str) -> tuple[float | None, float | None]:
    factor = unit_factor(unit) if unit else 1.0
    low, high = (
        None if bound is None or (form.dimension is None and unit) else _rounded(bound / factor)
        for bound in (form.low, form.high)
    )
    return low, high


def _slider(
    number: float | None, limits: tuple[float | None, float | None], whole: bool
) -> tuple[float, float, float] | None:
    """Half as much to half as much again, in round steps within the limits."""
    if number is None or number == 0 or not math.isfinite(number):
        return None
    reach = abs(number) * _REACH
    step = 1.0 if whole else _round_step(2 * reach / _STEPS)
    low, high = (number - reach, number + reach)
    low = low if limits[0] is None else max(low, limits[0])
    high = high if limits[1] is None else min(high, limits[1])
    low, high = (_rounded(round(end / step) * step) for end in (low, high))
    return (low, high, step) if high - low >= 2 * step else None


def _round_step(least: float) -> float:
    """1, 2 or 5 times a power of ten, the least that is no less than ``least``."""
    power = 10.0 ** math.floor(math.log10(least))
    return _rounded(next(n for n in (1, 2, 5, 10) if n * power >= least * (1 - 1e-9)) * power)


def _default(info: FieldInfo) -> str:
    """What holds where a value is left out, in words."""
    if (
        info.is_required()
        or info.default_factory is not None
        or isinstance(info.default, (BaseModel, dict, list))
    ):
        return ""
    if info.default is None or info.default == "":
        return ""
    return shown_default(info).replace("`", "")


def shown_default(field: FieldInfo) -> str:
    """The default of a field in the unit in which it is usually given."""
    value = field.default
    if value is None or value == "":
        return "not given"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f"`{value}`"
    dimension = next(
        (item.dimension for item in field.metadata if isinstance(item, Quantity)), None
    )
    if dimension is None:
        return (
            "-".join(map(str, value))
            if isinstance(value, tuple)
            else str(value)
            if isinstance(value, int)
            else number(value)
        )
    unit = DIMENSIONS[dimension].default_unit
    scale = unit_factor(unit) if unit else 1.0
    values = value if isinstance(value, tuple) else (value,)
    return f"{', '.join(number(entry / scale) for entry in values)} {unit}".strip()
