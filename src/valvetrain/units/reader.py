"""Units of the reader: which unit is printed in place of a metric one. Values inside, files and JSON
stay SI; only what a person reads, within :func:`for_reader`, is in the units requested.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from valvetrain.errors import InputError
from valvetrain.units.text import dimension_of, unit_factor

#: Systems of units that a reader may request.
SYSTEMS = ("si", "imperial")
#: A value of a case file in pounds: its owner thinks in them.
_POUNDS = re.compile(r"""=\s*(\{\s*value\s*=\s*)?["'][^"']*\blbf""")
#: Dimension -> unit of readers of inches and pounds; masses of valve gear are weighed in grams there too.
IMPERIAL = {
    "length": "in", "force": "lbf", "stiffness": "lbf/in", "pressure": "ksi", "modulus": "ksi", "moment": "lbf in", "energy": "lbf in",
    "impulse": "lbf s", "velocity": "ft/s", "acceleration": "in/s^2", "cam velocity": "in/deg", "cam acceleration": "in/deg^2",
    "power": "hp", "line stiffness": "ksi",
}  # fmt: skip
#: Numbers of prose that share the metric unit behind them: "72 N", "537 to 611 N", "−3 ± 0.2 mm".
_NUMBER = r"\d+(?:\.\d+)?(?:e[+-]?\d+)?"
_METRIC = re.compile(
    rf"(?<![\w.])({_NUMBER}(?:(?: (?:to|of|and|or|±) |[–±/-])[−-]?{_NUMBER})*)[ \xa0](N/mm|N|mm|MPa|m/s|mJ)(?![\w/^])"
)
#: Units as pages print them -> as they are read.
_WRITTEN = {"m/s2": "m/s^2", "µm/deg²": "um/deg^2"}
_REQUESTED: ContextVar[str] = ContextVar("requested_units", default="")
_OF_CASE: ContextVar[str] = ContextVar("units_of_case", default="si")
_SHOWN: ContextVar[str] = ContextVar("shown_units", default="si")


def request_units(system: str) -> None:
    """Choose the system of what :func:`for_reader` encloses; empty: that of the case, SI until :func:`follow_case`.

    Raises :class:`InputError` for an unknown one.

    >>> request_units("furlongs")
    Traceback (most recent call last):
    ...
    valvetrain.errors.InputError: --units: units 'furlongs' are unknown; use si or imperial
    """
    if system not in ("", *SYSTEMS):
        raise InputError(
            f"units '{system[:20]}' are unknown; use {' or '.join(SYSTEMS)}", "--units"
        )
    _REQUESTED.set(system)
    _OF_CASE.set("si")


def follow_case(text: str) -> None:
    """Show a case file with this text in its own units where the reader requests none."""
    _OF_CASE.set(system_of(text))


def system_of(text: str) -> str:
    """The system in which the values of a case file are given.

    >>> system_of('preload = "118 lbf"'), system_of('preload = "524 N"')
    ('imperial', 'si')
    """
    return "imperial" if _POUNDS.search(text) else "si"


def requested_system() -> str:
    """The system that the reader requests, empty where none is."""
    return _REQUESTED.get()


@contextmanager
def for_reader() -> Iterator[None]:
    """What is formatted within is in the units requested, or in those of the case."""
    before = _SHOWN.set(_REQUESTED.get() or _OF_CASE.get())
    try:
        yield
    finally:
        _SHOWN.reset(before)


def shown_system() -> str:
    """The system in which numbers are formatted here: one of :data:`SYSTEMS`."""
    return _SHOWN.get()


def reader_unit(unit: str) -> str:
    """The unit printed in place of ``unit``, itself where the reader's is the same.

    >>> request_units("imperial")
    >>> with for_reader():
    ...     reader_unit("N/mm"), reader_unit("deg"), reader_unit("g")
    ('lbf/in', 'deg', 'g')
    >>> request_units("")
    """
    if shown_system() == "si" or unit in ("", "thou"):
        return unit
    try:
        return IMPERIAL.get(dimension_of(_read(unit)) or "", unit)
    except InputError:  # a unit of a package's own
        return unit


def reader_factor(unit: str) -> float:
    """What a number in ``unit`` is multiplied with to be in :func:`reader_unit`."""
    shown = reader_unit(unit)
    return 1.0 if shown == unit else unit_factor(_read(unit)) / unit_factor(shown)


def reader_text(text: str) -> str:
    """A sentence that holds metric numbers, with those of the reader's other units in their place.

    >>> request_units("imperial")
    >>> with for_reader():
    ...     reader_text("rate 41.4 N/mm, 72 N at 6593 rpm (1.33 m/s), 537 to 611 N")
    'rate 236.4 lbf/in, 16.19 lbf at 6593 rpm (4.364 ft/s), 120.7 to 137.4 lbf'
    >>> request_units("")
    """
    if _SHOWN.get() == "si":
        return text

    def converted(match: re.Match[str]) -> str:
        unit = match[2]
        factor = reader_factor(unit)
        numbers = re.sub(_NUMBER, lambda one: f"{float(one[0]) * factor:.4g}", match[1])
        return f"{numbers} {reader_unit(unit)}"

    return _METRIC.sub(converted, text)


def _read(unit: str) -> str:
    return _WRITTEN.get(unit, unit)
