"""Definitions of quantities by name: dimension, shown unit, label and definition.

The rows are in the tables that the registry lists under ``quantities``: the general one and one per
published study.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from contextvars import ContextVar
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cache
from typing import Any, Literal, TypeVar, get_args

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.registry import find
from valvetrain.registry import names as registered_names
from valvetrain.solution.force_peak import FORCE_BANDWIDTH, band_text
from valvetrain.units import DIMENSIONS, unit_factor
from valvetrain.units.reader import reader_unit, shown_system

Sense = Literal["larger is better", "smaller is better", ""]
Systems = tuple[Literal["spring", "train"], ...]
#: Where a quantity is shown in addition to the table of all: ``brief`` in the row of a run among many, ``sweep``
#: in the terminal's table of a sweep, ``curve`` drawn over engine speed, ``study`` offered as an output of
#: a study, ``stress`` in the table of stresses; ``page`` on the page but not in the terminal. ``case``:
#: one value for all engine speeds; ``one speed``: no worst value over several.
Use = Literal["brief", "sweep", "curve", "study", "stress", "page", "case", "one speed"]
#: Topics of the answers in the order of page, terminal and workbench; any other text follows them.
TOPICS = (
    "Spring force and coil bind", "Surge", "Coil clash", "Seating and contact", "Scatter from cycle to cycle", "Loss of control",
    "Wire stress",
)  # fmt: skip
Number = TypeVar("Number", float, Array)
#: Cut-off (Hz) that labels of spring forces state: that of the case last built, or of the result last shown.
_CUT_OFF: ContextVar[float] = ContextVar("cut_off_of_labels", default=FORCE_BANDWIDTH)

#: Last part of a name -> dimension and shown unit, unless its row gives others; for a range, that
#: of the word before it.
BY_LAST_WORD: dict[str, tuple[str, str]] = {
    "force": ("force", "N"), "preload": ("force", "N"), "load": ("force", "N"), "angle": ("angle", "deg"), "frequency": ("frequency", "Hz"),
    "velocity": ("velocity", "m/s"), "acceleration": ("acceleration", "m/s^2"), "displacement": ("length", "mm"),
    "compression": ("length", "mm"), "gap": ("length", "mm"), "clearance": ("length", "mm"), "length": ("length", "mm"),
    "height": ("length", "mm"), "lift": ("length", "mm"), "diameter": ("length", "mm"), "duration": ("time", "ms"),
    "rate": ("stiffness", "N/mm"), "impulse": ("impulse", "mN s"), "energy": ("energy", "mJ"), "stress": ("pressure", "MPa"),
    "pressure": ("pressure", "MPa"), "mass": ("mass", "g"), "speed": ("angular speed", "rpm"), "torque": ("moment", "N m"),
    "power": ("power", "W"), "moment": ("moment", "N m"), "ratio": ("ratio", ""), "count": ("ratio", ""), "order": ("ratio", ""),
    "number": ("ratio", ""),
}  # fmt: skip
#: SI units written otherwise than `valvetrain.units` does.
_SI_TEXTS = {"": "1", "1/s": "Hz", "m/s^2": "m/s2", "N*m": "N m", "N*s": "N s"}
#: Springs of a nested pair, whose quantities carry the spring's name in front:
#: ``outer_coil_bind_clearance``.
NESTED = ("outer", "inner")
#: Both springs of a pair together, and what is added up of them: ``pair_card_preload``.
PAIR = "pair"
ADDED = (
    "preload", "installed_rate", "card_preload", "card_rate", "card_open_force", "card_mass", "wire_mass",
)  # fmt: skip


def si_unit_text(dimension: str) -> str:
    """SI unit of a dimension of :data:`valvetrain.units.DIMENSIONS` in results: ``1`` for plain
    numbers.
    """
    unit = DIMENSIONS[dimension].si_unit
    return _SI_TEXTS.get(unit, unit)


@dataclass(frozen=True, slots=True)
class QuantityRow:
    """One quantity, or a family of them where ``name`` is a template: ``mode_{n}_frequency``,
    ``peak_{place}_contact_force``.

    ``dimension``: key of :data:`valvetrain.units.DIMENSIONS`, empty where the name has none; ``shown_unit``
    is printed in tables. ``label``: plain English; ``definition``: one sentence for docs/quantities.md;
    both may repeat the fields of the template. ``systems`` that have it: a spring under prescribed
    motion, a train. ``topic`` of the answers on the page, in the terminal and in the workbench, empty for
    the table of all quantities alone; ``uses``: where else it is shown; ``answered_as``: names for
    topic and uses where they are not ``name`` alone. ``compute`` (a quantity of another package): SI
    value of a :class:`~valvetrain.solution.result.Solution`, None where it has none. ``remark``: what
    tables and axes put behind the label. ``physical``: whether it is of the valvetrain; else of the computation.
    """

    name: str
    dimension: str
    shown_unit: str
    label: str
    definition: str = ""
    sense: Sense = ""
    systems: Systems = ()
    topic: str = ""
    uses: tuple[Use, ...] = ()
    answered_as: tuple[str, ...] = ()
    compute: Callable[[Any], float | None] | None = None
    remark: str = ""
    physical: bool = True

    @property
    def si_unit(self) -> str:
        """Unit of the values inside the package and in JSON; ``1`` for plain numbers."""
        return si_unit_text(self.dimension or "ratio")

    @property
    def unit_word(self) -> str:
        """The shown unit as printed, of an angle with what turns by it.

        >>> definition_of("valve_50_thou_lost_crank_angle_range").unit_word
        'crank deg'
        """
        turning = re.search(r"(cam|crank)_angle(_range)?$", self.name)
        of_what = f"{turning[1]} " if turning and self.shown_unit == "deg" else ""
        return of_what + self.shown_unit


def row(
    name: str,
    label: str,
    definition: str,
    *,
    dimension: str = "",
    shown_unit: str | None = None,
    uses: tuple[Use, ...] = (),
    **more: Any,
) -> QuantityRow:
    """A :class:`QuantityRow` whose dimension and shown unit follow from the last part of ``name``
    where they are left out; ``more``: its other fields. Raises :class:`InputError` for an unknown use.
    """
    if unknown := [use for use in uses if use not in get_args(Use)]:
        raise InputError(
            f"quantity '{name}' has the unknown use '{unknown[0]}'; use {', '.join(get_args(Use))}"
        )
    parts = name.split("_")
    last = parts[-2] if parts[-1] == "range" and len(parts) > 1 else parts[-1]
    default = BY_LAST_WORD.get(last, ("", ""))
    unit = default[1] if shown_unit is None else shown_unit
    return QuantityRow(name, dimension or default[0], unit, label, definition, uses=uses, **more)


@cache
def tables() -> dict[str, tuple[QuantityRow, ...]]:
    """Every registered table of quantities by its name. Raises :class:`InputError` where two rows
    have one name.
    """
    found: dict[str, tuple[QuantityRow, ...]] = {
        name: tuple(find("quantities", name)) for name in registered_names("quantities")
    }
    owner: dict[str, str] = {}
    for table, rows in found.items():
        for one in rows:
            if one.name in owner:
                raise InputError(
                    f"quantity '{one.name}' is in the tables '{owner[one.name]}' and '{table}'; rename or remove one"
                )
            owner[one.name] = table
    return found


@cache
def topics() -> dict[str, tuple[str, ...]]:
    """Topic -> its quantities, in the order in which page, terminal and workbench answer them."""
    names: dict[str, list[str]] = {topic: [] for topic in TOPICS}
    for one in _rows():
        if one.topic:
            names.setdefault(one.topic, []).extend(one.answered_as or (one.name,))
    return {topic: tuple(some) for topic, some in names.items()}


@cache
def names_for(use: Use, system: Literal["spring", "train", ""] = "") -> tuple[str, ...]:
    """Names of the quantities with a ``use``, in the order of the topics, of ``system`` alone where
    one is given.
    """
    order = list(topics())
    rows = [one for one in _rows() if use in one.uses and (not system or system in one.systems)]
    rows.sort(key=lambda one: order.index(one.topic) if one.topic else len(order))
    return tuple(name for one in rows for name in one.answered_as or (one.name,))


def _rows() -> list[QuantityRow]:
    return [one for rows in tables().values() for one in rows]


def definition_of(name: str) -> QuantityRow:
    """The row of ``name``, its template filled; for a name that no table has, one made from its
    last word. Its ``shown_unit`` is that of the reader (:mod:`valvetrain.units.reader`), and its label states
    the cut-off of :func:`label_cut_off`.

    >>> definition_of("mode_2_frequency").label
    'mode 2 frequency'
    """
    system, cut_off = shown_system(), _CUT_OFF.get()
    usual = system == "si" and cut_off == FORCE_BANDWIDTH
    return _definition(name) if usual else _for_reader(name, system, cut_off)


def label_cut_off(cut_off: float) -> None:
    """Let labels of spring forces state ``cut_off`` (Hz) from here on.

    >>> label_cut_off(5e3)
    >>> label_of("peak_spring_force")
    'peak spring force below 5 kHz'
    >>> label_cut_off(10e3)
    """
    _CUT_OFF.set(cut_off)


@cache
def _for_reader(name: str, system: str, cut_off: float) -> QuantityRow:
    """The row of ``name`` in a ``system`` of units, which is the one in use, with a ``cut_off`` (Hz)."""
    one = _definition(name)
    unit = one.shown_unit if system == "si" else reader_unit(one.shown_unit)
    label = one.label.replace(band_text(FORCE_BANDWIDTH), band_text(cut_off))
    return replace(one, shown_unit=unit, label=label)


@cache
def _definition(name: str) -> QuantityRow:
    exact, templates = _index()
    if name in exact:
        return exact[name]
    for one, pattern in templates:
        if found := pattern.fullmatch(name):
            parts = {key: value.replace("_", " ") for key, value in found.groupdict().items()}
            return replace(
                one,
                name=name,
                label=one.label.format(**parts),
                definition=one.definition.format(**parts),
            )
    first, _, rest = name.partition("_")
    if first == PAIR and rest in ADDED:
        whole = _definition(rest)
        return replace(
            whole,
            name=name,
            label=f"{whole.label}, both springs",
            definition=f"{whole.definition} Of both springs of a pair together.",
        )
    if first in NESTED and (whole := _definition(rest)).definition:
        return replace(
            whole,
            name=name,
            label=f"{whole.label}, {first} spring",
            definition=f"{whole.definition} Of the {first} spring.",
        )
    return row(name, re.sub(r" cam angle$", ", cam angle", name.replace("_", " ")), "")


def is_defined(name: str) -> bool:
    """Whether a table has ``name``, itself or by a template."""
    return bool(definition_of(name).definition)


def no_quantity(name: str) -> str:
    """Message on a name that no table has, with the names nearest to it.

    >>> no_quantity("float_speed")
    "'float_speed' is no quantity; did you mean float_engine_speed? All names: `valvetrain quantities`"
    """
    near = near_names(name)
    hint = "`valvetrain quantities` lists their names"
    if near:
        hint = f"did you mean {_either(near)}? All names: `valvetrain quantities`"
    return f"'{name[:60]}' is no quantity; {hint}"


def of_pair(name: str) -> tuple[str, ...]:
    """Names of a quantity for each spring of a pair and, where it adds up, for both together.

    >>> of_pair("card_rate"), of_pair("free_length")
    (('outer_card_rate', 'inner_card_rate', 'pair_card_rate'), ('outer_free_length', 'inner_free_length'))
    """
    return tuple(f"{one}_{name}" for one in (*NESTED, *((PAIR,) if name in ADDED else ())))


def not_given(name: str, given: Iterable[str] = ()) -> str:
    """Message on a quantity that no completed run gave, with the names nearest to it: those of a pair's
    springs where they are among ``given``.

    >>> not_given("peak_shear_stress")[:62]
    'no run gave the peak shear stress (peak_shear_stress); similar'
    >>> not_given("preload", ("outer_preload", "inner_preload"))
    'no run gave the preload (preload); of a pair: outer_preload or inner_preload'
    """
    lead = f"no run gave the {label_of(name)} ({name})"
    known = set(given)
    if named := tuple(one for one in of_pair(name) if one in known):
        return f"{lead}; of a pair: {_either(named)}"
    near = near_names(name)
    return lead + (f"; similar: {_either(near)}" if near else "")


def near_names(name: str) -> tuple[str, ...]:
    """Up to three names of quantities near to ``name``: those that have all of its words, shortest
    first, then those of like spelling.
    """
    exact, templates = _index()
    known = [*exact, *(one.name.replace("{place}", "cam") for one, _ in templates)]
    parts = name[:60].split("_")
    whole = [
        one
        for one in known
        if all(
            part in one.split("_") or (part.isdecimal() and re.search(r"\{\w\}", one))
            for part in parts
        )
    ]
    whole.sort(key=lambda one: (one.count("_"), len(one), one))
    found = dict.fromkeys([*whole[:4], *get_close_matches(name[:60], known, n=2, cutoff=0.75)])
    return tuple(one for one in found if one != name)[:3]


def _either(names: tuple[str, ...]) -> str:
    return " or ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)


def label_of(name: str) -> str:
    """Label of ``name``: ``minimum_spring_force`` -> ``minimum spring force``."""
    return definition_of(name).label


def shown(name: str, value: Number) -> tuple[Number, str]:
    """SI ``value`` (a number or an array) of quantity ``name`` in the unit tables print, and that
    unit (empty for plain numbers).
    """
    one = definition_of(name)
    return value / unit_factor(one.shown_unit), one.unit_word


def angle_name(quantity: str) -> str:
    """The quantity with the cam angle of a peak. Raises :class:`InputError` for one without."""
    short = quantity
    for ending in ("_force", "_acceleration", "_velocity", "_displacement", "_lift", "_stress"):
        short = short.removesuffix(ending)
    names = (f"{quantity}_cam_angle", f"{short}_cam_angle")
    found = next((name for name in names if is_defined(name)), None)
    if found is None:
        raise InputError(f"no quantity gives the angle of '{quantity[:60]}'; give its value alone")
    return found


@cache
def _index() -> tuple[dict[str, QuantityRow], tuple[tuple[QuantityRow, re.Pattern[str]], ...]]:
    """Rows by whole name, and templates with their patterns, the one with most fixed letters first."""
    every = _rows()
    templates = sorted(
        (one for one in every if "{" in one.name),
        key=lambda one: -len(re.sub(r"\{\w+\}", "", one.name)),
    )
    return {one.name: one for one in every if "{" not in one.name}, tuple(
        (one, pattern_of(one.name)) for one in templates
    )


def pattern_of(template: str) -> re.Pattern[str]:
    """Pattern of the names of a template: one letter in braces for a number, a word for one or
    several words.
    """
    places = re.split(r"\{(\w+)\}", template)
    text_of = (
        rf"(?P<{part}>{r'[0-9]+' if len(part) == 1 else r'[a-z0-9]+(?:_[a-z0-9]+)*'})"
        for part in places[1::2]
    )
    fixed = map(re.escape, places[::2])
    return re.compile("".join(text + next(text_of, "") for text in fixed))
