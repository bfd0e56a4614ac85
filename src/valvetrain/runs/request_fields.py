"""Fields of a request: what each means, and how it reads what is typed on the command line or given in Python.

A field reads text, numbers and objects alike, so a wrong value has one sentence everywhere. The place in that sentence
is the option on the command line and the argument in Python.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from numbers import Integral
from pathlib import Path
from typing import Any, ClassVar, Self

from valvetrain import registry
from valvetrain.errors import FrozenMapping, InputError, UnknownNameError
from valvetrain.runs.cost import Limits, read_limits
from valvetrain.units import as_names, si, si_each, si_speeds
from valvetrain.units.text import clipped

#: Reads a given value; its second argument is the place that a refusal names.
Reader = Callable[[Any, str], Any]


@dataclass(frozen=True)
class Option:
    """What a field means and how it is read.

    ``flag``: its option on the command line, empty where only Python has it; without a flag but with a ``metavar`` it is
    an argument there. ``metavar``: what follows the option, empty for a switch. ``default``: its default as text.
    """

    read: Reader
    meaning: str
    flag: str = ""
    metavar: str = ""
    repeatable: bool = False
    default: str = ""


def option(
    read: Reader,
    meaning: str,
    flag: str = "",
    metavar: str = "",
    *,
    default: Any = None,
    repeatable: bool = False,
) -> Any:
    """A field of a request. A ``default`` that is text is read as if it were given, when a request needs it."""
    text = default if isinstance(default, str) else ""
    metadata = {"option": Option(read, meaning, flag, metavar, repeatable, text)}
    if text:
        return dataclasses.field(default_factory=partial(read, text, flag), metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


def options_of(model: type[Any]) -> dict[str, Option]:
    """Name of each field -> its option, those of the class itself before those that it inherits."""
    fields = {one.name: one for one in dataclasses.fields(model) if "option" in one.metadata}
    order = [name for parent in model.__mro__ for name in vars(parent).get("__annotations__", ())]
    return {name: fields[name].metadata["option"] for name in order if name in fields}


@dataclass(frozen=True, kw_only=True)
class Fields:
    """A frozen model whose fields are made by :func:`option`. Its constructor takes values in SI.

    ``typed``: the texts that its fields were read from.
    """

    command: ClassVar[str]

    typed: Mapping[str, str] = dataclasses.field(default_factory=dict, compare=False, repr=False)

    @property
    def given(self) -> dict[str, str]:
        """What was given, as it was typed or as text."""
        values = {name: getattr(self, name) for name in options_of(type(self))}
        return {
            name: str(value) for name, value in values.items() if value and name != "case"
        } | dict(self.typed)

    @classmethod
    def read(cls, given: Mapping[str, Any], flags: bool = False) -> Self:
        """The model from what was typed or given, by name of the field; None stands for the default.

        ``flags``: refusals name the option and not the argument. Raises :class:`InputError` for a value that a field
        cannot read, and :class:`UnknownNameError` for a name that is no field.
        """
        options = options_of(cls)
        values = {}
        for name, value in given.items():
            if name not in options:
                raise UnknownNameError(name, options, f"argument of {cls.__name__.lower()}")
            if value is not None:
                place = options[name].flag if flags else name
                values[name] = options[name].read(value, place)
        typed = {name: value for name, value in given.items() if isinstance(value, str)}
        with flagged(options if flags else {}):
            return cls(**values, typed=typed)


@dataclass(frozen=True, kw_only=True)
class Answers(Fields):
    """Fields whose constructor reads text too."""

    def __post_init__(self) -> None:
        """Read every value that is not the default."""
        for one in dataclasses.fields(self):
            if "option" in one.metadata and (value := getattr(self, one.name)) is not one.default:
                read = one.metadata["option"].read
                object.__setattr__(self, one.name, read(value, one.name))


@contextmanager
def flagged(options: Mapping[str, Option]) -> Iterator[None]:
    """Refusals within name the option of a field and not the field."""
    try:
        yield
    except InputError as error:
        name = error.where.partition(" of the ")[0]  # so are fields of a table
        if name not in options:
            raise
        raise InputError(error.reason, options[name].flag) from error


def read_case(given: Any, where: str) -> Any:
    """A case, by name of the library, path or object."""
    from valvetrain.parameters.loading import case_of

    return case_of(given)


def read_text(given: Any, where: str) -> str:
    """Text as it is."""
    return str(given)


def read_path(given: Any, where: str) -> Path:
    """The path of a folder. Raises :class:`InputError` for an empty name or a zero byte."""
    text = str(given)
    if not text.strip():
        raise InputError(
            "the name of the folder is empty; give one, or leave the option out", where
        )
    if "\0" in text:
        raise InputError(
            "the name of the folder holds a zero byte, which no folder can; give another", where
        )
    return Path(text)


def read_speeds(given: Any, where: str) -> tuple[float, ...]:
    """Crank speeds (rad/s), as :func:`valvetrain.units.si_speeds` reads them; a model in their place is refused by its name."""
    texts = (given,) if isinstance(given, str) else given if isinstance(given, Sequence) else ()
    words = ",".join(one for one in texts if isinstance(one, str)).replace(" ", "").split(",")
    models = set(words) & set(registry.names("springs"))
    if models:
        raise InputError(
            f"'{min(models)}' is a spring model, and engine speeds come first: (case, engine_speeds, models), such as "
            "compare('job-t', '3000 rpm', ['massless', 'multi-mass'])",
            where,
        )
    return si_speeds(given, "engine_speed", where)


def read_speed(given: Any, where: str) -> float:
    """One crank speed (rad/s) above zero."""
    speeds = read_speeds(given, where)
    if len(speeds) != 1:
        raise InputError("one speed is needed here; write such as '6000 rpm'", where)
    return speeds[0]


def read_names(given: Any, where: str) -> tuple[str, ...]:
    """Names, each once; a text may list several with commas."""
    parts = (part.strip() for text in as_names(given) for part in text.split(","))
    return tuple(dict.fromkeys(filter(None, parts)))


def read_words(given: Any, where: str) -> tuple[str, ...]:
    """Words in their order; a text lists them with commas."""
    parts = given.split(",") if isinstance(given, str) else given
    return tuple(filter(None, map(str.strip, parts)))


def read_pairs(given: Any, where: str) -> FrozenMapping:
    """Text by quantity from ``QUANTITY=VALUE``, each once."""
    if isinstance(given, Mapping):
        return FrozenMapping(given)
    pairs: dict[str, str] = {}
    for text in (given,) if isinstance(given, str) else given:
        quantity, _, value = (part.strip() for part in text.partition("="))
        name = quantity.replace(" ", "_")
        if not value or not name.isidentifier() or not name.isascii() or len(name) > 60:
            raise InputError(
                f"'{text[:40]}' is no pair; write QUANTITY=..., such as 'spring_force=...'", where
            )
        if name in pairs:
            raise InputError(f"{name} is given twice; give it once", where)
        pairs[name] = value
    return FrozenMapping(pairs)


def read_models(given: Any, where: str) -> tuple[str, ...]:
    """Names of spring models, given by name, class, instance or function."""
    parts = given if isinstance(given, Sequence) and not isinstance(given, str) else (given,)
    models: list[str] = []
    for part in parts:
        if isinstance(part, str):
            models += read_names(part, where)
        else:
            from valvetrain.springs.own_spring import model_name

            models.append(model_name(part, where))
    for word in models:
        if word not in registry.names("springs"):
            registry.find("springs", word, where)
    return tuple(dict.fromkeys(models))


def read_choices(names: tuple[str, ...], given: Any, where: str) -> tuple[str, ...]:
    """One or several of ``names``."""
    chosen = read_names(given, where)
    for name in chosen:
        if name not in names:
            raise InputError(f"'{name[:40]}' is not available; use {', '.join(names)}", where)
    return chosen


def read_choice(names: tuple[str, ...], given: Any, where: str) -> str:
    """One of ``names``."""
    return "".join(read_choices(names, given, where)[:1])


def read_within(name: str, low: float, high: float, given: Any, where: str) -> float:
    """An amount of the quantity or dimension ``name`` between ``low`` and ``high`` (SI)."""
    value = si(given, name, where)
    if not low <= value <= high:
        text = clipped(str(given))
        raise InputError(f"'{text}' is outside {low:g} to {high:g} in SI units; correct it", where)
    return value


def read_positive(name: str, given: Any, where: str) -> float:
    """An amount of the quantity or dimension ``name`` (SI) above zero."""
    value = si(given, name, where)
    if not value > 0:
        raise InputError(f"'{clipped(str(given))}' is not positive; give one above zero", where)
    return value


def read_amount(name: str, given: Any, where: str) -> float:
    """An amount of the quantity or dimension ``name`` (SI): zero or more."""
    value = si(given, name, where)
    if value < 0:
        raise InputError(f"'{clipped(str(given))}' is negative; give zero or more", where)
    return value


def read_amounts(name: str, given: Any, where: str) -> tuple[float, ...]:
    """Amounts of the quantity or dimension ``name`` (SI), each text one or several: ``'200, 400 N'``."""
    parts = given if isinstance(given, (list, tuple)) else (given,)
    return tuple(
        value
        for part in parts
        for value in si_each(part if isinstance(part, str) else (part,), name, where)
    )


def read_count(low: int, high: int, given: Any, where: str) -> int:
    """A whole number from ``low`` to ``high``."""
    text = given.strip() if isinstance(given, str) else ""
    if text.lstrip("+-").isdecimal() and len(text) <= 20:
        given = int(text)
    if not isinstance(given, Integral) or isinstance(given, bool):
        raise InputError(f"a whole number is needed; it is {str(given)[:40]}", where)
    number = int(given)
    if not low <= number <= high:
        raise InputError(f"{number} is outside {low} to {high}; choose a number between", where)
    return number


def read_switch(given: Any, where: str) -> bool:
    """True or False."""
    if not isinstance(given, bool):
        raise InputError(
            f"{clipped(repr(given))} is neither True nor False; give one of them", where
        )
    return given


def read_limit(given: Any, where: str) -> Limits:
    """The largest time and memory, from ``"2 h, 8 GB"``."""
    if isinstance(given, Limits):
        return given
    texts = [given] if isinstance(given, str) else given
    if not isinstance(texts, (list, tuple)) or not all(isinstance(one, str) for one in texts):
        raise InputError(
            f"'{str(given)[:40]}' is no bound; write a time and a memory such as '2 h, 8 GB'", where
        )
    return read_limits(tuple(filter(None, texts)), where)
