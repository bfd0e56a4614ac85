"""What the models of a case file share: strictness, quantities with units and errors that know
their place.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, field, fields
from functools import partial, wraps
from typing import Annotated, Any, ClassVar, TypeVar, dataclass_transform

import pydantic.dataclasses
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import ArgsKwargs, PydanticCustomError

from valvetrain.errors import InputError
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.key_names import meant_key
from valvetrain.units import (
    DIMENSIONS,
    PlainInteger,
    PlainNumber,
    doubt,
    format_quantity,
    parse_quantities,
    parse_quantity,
    plain_value,
)
from valvetrain.units.text import clipped

Model = TypeVar("Model", bound="BaseModel | Table")
Part = TypeVar("Part", bound="Table")


class StrictModel(BaseModel):
    """A table of the case file: frozen, no unknown keys, no silent conversions."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, arbitrary_types_allowed=True
    )

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, raw: Any) -> Any:
        fields = {info.alias or name: info for name, info in cls.model_fields.items()}
        return refuse_unknown(raw, fields)


class Table:
    """Base of the tables that :func:`table` makes parameters of."""

    model_fields: ClassVar[dict[str, FieldInfo]]

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, raw: Any) -> Any:
        fields = cls.model_fields
        if isinstance(raw, ArgsKwargs):  # made in Python: numbers alone are SI, None is not given
            fields = fields | cls.__pydantic_fields__  # type: ignore[attr-defined]
            named = {
                key: plain_value(value)
                for key, value in (raw.kwargs or {}).items()
                if value is not None or key not in fields or fields[key].default is not None
            }
            return ArgsKwargs(
                tuple(plain_value(value) for value in raw.args), refuse_unknown(named, fields)
            )
        return raw if isinstance(raw, cls) else refuse_unknown(raw, fields)


def refuse_unknown(raw: Any, fields: Mapping[str, FieldInfo]) -> dict[str, Any]:
    """The table ``raw``; refuses what is none and a key that is not among its ``fields``, with the nearest."""
    known = tuple(fields)
    if not isinstance(raw, dict):
        raise problem(f"a table of {', '.join(known)} is needed here")
    for key in raw:
        if key not in known:
            raise problem(
                f"key '{key[:60]}' is unknown; {meant_key(key, known) or nearest(key, known)}",
                (key,),
            )
    return raw


def as_given(*, default: Any, description: str) -> Any:
    """A field of a table that says what others follow from, and does not make two tables differ."""
    return field(default=default, compare=False, repr=False, metadata={"description": description})


#: Default of a field that ``__post_init__`` fills in where it is not given; a field of numbers to readers.
FOLLOWS: Any = None


@dataclass_transform(frozen_default=True, field_specifiers=(Field, as_given))
def table(noun: str) -> Callable[[type[Part]], type[Part]]:
    """Makes a class one table of a case file and the frozen parameters that the physics reads.

    It is a dataclass that pydantic checks: from a file its numbers are text with units, in Python SI
    numbers too. What is refused in Python is an :class:`InputError`; ``noun`` says whose field it is.
    """

    def make(cls: type[Part]) -> type[Part]:
        made: Any = pydantic.dataclasses.dataclass(
            frozen=True,
            config=ConfigDict(extra="forbid", arbitrary_types_allowed=True, populate_by_name=True),
        )(cls)
        infos = made.__pydantic_fields__
        made.model_fields = {
            info.alias or name: info for name, info in infos.items() if info.init is not False
        }
        for one in fields(made):  # the default alone, without the words around it
            info = infos[one.name]
            one.default = MISSING if info.is_required() else info.default
        read = made.__init__

        @wraps(read)
        def init(self: Any, *arguments: Any, **named: Any) -> None:
            try:
                read(self, *arguments, **named)
            except ValidationError as error:
                path, reason = first_problem(error)
                names = list(made.model_fields)
                key = ".".join(names[key] if isinstance(key, int) else key for key in path[:1])
                raise InputError(reason, f"{key} of {noun}" if key else "") from None

        made.__init__ = init
        result: type[Part] = made
        return result

    return make


def problem(reason: str, path: tuple[str | int, ...] = ()) -> PydanticCustomError:
    """An error at ``path`` below the value being validated; ``reason`` is what the user reads."""
    return PydanticCustomError("input", "{reason}", {"reason": reason, "path": path})


def guarded(
    function: Callable[..., Any], *arguments: Any, path: tuple[str | int, ...] = (), **named: Any
) -> Any:
    """Call ``function``; what it refuses becomes an error that pydantic can place, ``path`` before its own."""
    try:
        return function(*arguments, **named)
    except InputError as error:
        raise problem(error.reason, path) from error
    except PydanticCustomError as error:
        context = error.context or {}
        inner = context.get("path", ())
        raise problem(str(context.get("reason", error)), (*path, *inner)) from error


def validate_as(model: type[Model], raw: Any, path: tuple[str | int, ...] = ()) -> Model:
    """Validate ``raw`` as ``model`` from within another validator, keeping the place of the error."""
    try:
        validator: Any = model.__pydantic_validator__  # type: ignore[attr-defined]
        found: Model = validator.validate_python(raw)
        return found
    except ValidationError as error:
        inner, reason = first_problem(error)
        raise problem(reason, (*path, *inner)) from error


#: Explanation of a missing key, in addition to its name, where a newcomer cannot guess what belongs
#: there.
SUCH_AS = {
    "material": ', such as material = "EN 10270-2 VDSiCr" (a name of the library) or its moduli and density',
    "preload": ", the load with the valve closed (seat load)",
}


def first_problem(error: ValidationError) -> tuple[tuple[str | int, ...], str]:
    """Path and one-sentence reason of the first problem pydantic found."""
    details = error.errors(include_url=False)[0]
    location = tuple(details["loc"])
    context = details.get("ctx") or {}
    if details["type"] == "input":
        return (*location, *context.get("path", ())), str(context["reason"])
    if details["type"] == "missing":
        return location, f"'{location[-1]}' is missing; add it{SUCH_AS.get(str(location[-1]), '')}"
    if details["type"] == "literal_error":
        return (
            location,
            f"{_show(details['input'])} is not among {context['expected']}; choose one of them",
        )
    text = str(details["msg"]).rstrip(".")
    return (
        location,
        f"{_show(details['input'])} does not fit: {text[:1].lower()}{text[1:]}; correct it",
    )


def _show(value: Any) -> str:
    return clipped(repr(value))


@dataclass(frozen=True)
class Quantity(BeforeValidator):
    """A validator that shows its ``dimension`` (a key of `valvetrain.units.DIMENSIONS`, None for
    any) and its bounds in SI.
    """

    dimension: str | None = None
    low: float | None = None
    high: float | None = None


#: Key of a case file -> the quantity whose plausible values it is checked against.
DOUBTED: dict[str, str] = {
    "rate": "spring_rate", "wire_diameter": "wire_diameter", "mean_diameter": "mean_diameter", "outer_diameter": "mean_diameter",
    "pitch": "pitch", "free_length": "spring_length", "installed_height": "spring_length", "preload_height": "spring_length",
    "open_height": "spring_length", "solid_height": "spring_length", "precompression": "compression", "maximum_lift": "valve_lift",
    "youngs_modulus": "modulus", "shear_modulus": "modulus", "density": "density", "engine_speeds": "engine_speed",
    "cam_speeds": "cam_speed",
    # fields whose key is the name of something else in Python
    "outer": "mean_diameter", "free": "spring_length", "stated_solid_height": "spring_length", "installed": "spring_length",
}  # fmt: skip


def _doubted(raw: Any, value: float, info: ValidationInfo) -> None:
    """Refuse a plain number that can only be a slip of units; warn of an unusual one with a unit."""
    if (name := DOUBTED.get(info.field_name or "")) is not None:
        bare = isinstance(raw, (PlainNumber, PlainInteger))
        shown = f"{raw:.6g} {raw.unit}" if bare else f"'{clipped(str(raw))}'"
        guarded(doubt, value, name, shown, bare)


def _bound(value: float, dimension: str | None) -> str:
    """A bound in the unit that is suggested for its dimension."""
    due = DIMENSIONS.get(dimension or "ratio")
    unit = str(dimension) if due is None else due.default_unit
    return format_quantity(value, unit) if value else "zero"


def quantity(
    dimension: str | None,
    *,
    low: float | None = None,
    high: float | None = None,
    open_low: bool = False,
) -> BeforeValidator:
    """Reads an SI float given as text with a unit; bounds are SI, ``open_low`` excludes ``low``
    itself.
    """

    def read(raw: Any, info: ValidationInfo) -> float:
        value = float(guarded(parse_quantity, raw, dimension))
        _doubted(raw, value, info)
        if low is not None and (value < low or (open_low and value == low)):
            raise problem(
                f"'{clipped(str(raw))}' is too small; give a value {'above' if open_low else 'of at least'} {_bound(low, dimension)}"
            )
        if high is not None and value > high:
            raise problem(
                f"'{clipped(str(raw))}' is too large; give a value of at most {_bound(high, dimension)}"
            )
        return value

    return Quantity(read, dimension=dimension, low=low, high=high)


def quantities(dimension: str | None) -> BeforeValidator:
    """Reads a tuple of SI floats: a list of quantities or ``"0, 1, 2 mm"``."""

    def read(raw: Any, info: ValidationInfo) -> tuple[float, ...]:
        found = tuple(guarded(parse_quantities, raw, dimension))
        items = raw if isinstance(raw, (list, tuple)) else [raw] * len(found)
        for item, value in zip(items, found, strict=True):
            _doubted(item, value, info)
        return found

    return Quantity(read, dimension=dimension)


Length = Annotated[float, quantity("length")]
Lash = Annotated[float, quantity("length", low=0.0)]
PositiveLength = Annotated[float, quantity("length", low=0.0, open_low=True)]
Force = Annotated[float, quantity("force")]
Stiffness = Annotated[float, quantity("stiffness", low=0.0, open_low=True)]
#: Masses (kg) beyond this are slips: the largest valve gears of ships weigh a tenth, and no
#: equilibrium is found for them in bearable time.
MAX_MASS = 1e3
Mass = Annotated[float, quantity("mass", low=0.0, high=MAX_MASS, open_low=True)]
Modulus = Annotated[float, quantity("modulus", low=0.0, open_low=True)]
Density = Annotated[float, quantity("density", low=0.0, open_low=True)]
Time = Annotated[float, quantity("time", low=0.0)]
PositiveTime = Annotated[float, quantity("time", low=0.0, open_low=True)]
Angle = Annotated[float, quantity("angle")]
AngularSpeed = Annotated[float, quantity("angular speed", low=0.0, open_low=True)]
Frequency = Annotated[float, quantity("frequency", low=0.0, open_low=True)]
DampingRate = Annotated[float, quantity("damping rate", low=0.0)]
Ratio = Annotated[float, quantity("ratio", low=0.0)]
Number = Annotated[float, quantity("ratio")]
Lengths = Annotated[tuple[float, ...], quantities("length")]
Angles = Annotated[tuple[float, ...], quantities("angle")]
Numbers = Annotated[tuple[float, ...], quantities("ratio")]


#: Longest name (a file is called by it), line and text (characters).
MAX_NAME_LENGTH, MAX_LINE_LENGTH, MAX_TEXT_LENGTH = 80, 1000, 50_000
_CONTROL = {
    "Cc": "a control character",
    "Cs": "half a character",
    "Zl": "a line break",
    "Zp": "a paragraph break",
}
#: Characters that turn the direction of what is written after them, so that a reader sees another
#: text.
_TURNS = frozenset("\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")


def text_problem(text: str, most: int, spared: str = "") -> str:
    """Why ``text`` may not appear in files, pages and terminals, empty when it may: longer than
    ``most`` or with control characters other than those in ``spared``.
    """
    if len(text) > most:
        return f"'{clipped(text)}' has {len(text)} characters; use at most {most}"
    if text.isprintable():
        return ""
    for char in text:
        kind = (
            "a sign that turns the direction of writing"
            if char in _TURNS
            else _CONTROL.get(unicodedata.category(char))
        )
        if kind is not None and char not in spared:
            return f"'{clipped(text)}' holds {kind} (U+{ord(char):04X}); remove it"
    return ""


def readable(text: str, most: int, spared: str = "", separators: str = "") -> str:
    """The text; refuses one that is longer than ``most``, holds control characters other than ``spared``, or any of
    ``separators``.
    """
    if reason := text_problem(text, most, spared):
        raise problem(reason)
    for sign in separators:
        if sign in text:
            raise problem(f"'{clipped(text)}' holds '{sign}', which parts folders; leave it out")
    return text


#: A name within a case; the name of a case, by which files are found; one line; a text of several
#: lines.
Name = Annotated[str, AfterValidator(partial(readable, most=MAX_NAME_LENGTH))]
CaseName = Annotated[str, AfterValidator(partial(readable, most=MAX_NAME_LENGTH, separators="/\\"))]
Line = Annotated[str, AfterValidator(partial(readable, most=MAX_LINE_LENGTH))]
Prose = Annotated[str, AfterValidator(partial(readable, most=MAX_TEXT_LENGTH, spared="\n\r\t"))]
