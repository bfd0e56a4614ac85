"""Reads the spring blocks of a case file: one spring, or outer and inner, by wire, card or a card of both
together.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import AfterValidator, PlainValidator, ValidationInfo
from pydantic.fields import FieldInfo

from valvetrain import registry
from valvetrain.errors import FrozenMapping, UnusualValueWarning
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.dual_spring import read_pair
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.schema_types import (
    Name,
    guarded,
    problem,
    refuse_unknown,
    validate_as,
)
from valvetrain.parameters.spring import SpringDefinition

#: Keys of a card in a pair; how a card is installed, and a wire: the fields of its table, and the key of its part.
PAIRED = ("loads_of", "total_coils")
CARD = {key: one for key, one in SpringCard.model_fields.items() if key not in PAIRED}
OF_CARD = {
    key: InstalledSpring.model_fields[key]
    for key in ("damping", "contact", "end_contact", "options")
}
OF_WIRE = {
    key: one
    for key, one in InstalledSpring.model_fields.items()
    if key not in ("wire", "card", "tied")
}
#: Keys that a card alone has, and a wire alone; a wire_diameter shows neither, for a card may have
#: one for its mass.
_CARD_KEYS = CARD.keys() - SpringDefinition.model_fields.keys() - {"installed_height"}
_WIRE_KEYS = SpringDefinition.model_fields.keys() - CARD.keys()
#: Keys of which a card has one or more.
_LOADS = {"preload", "rate", "open_load"}

#: An inner spring may be this many times as wide as the outer one is inside: damped pairs rub.
INTERFERENCE = 1.03


def springs_of(raw: Any, name: str, group: str = "") -> tuple[InstalledSpring, ...]:
    """The springs of one place in the file: one, or a list of one or two, outer first; installed springs
    as they are.

    ``name`` is for a spring without one of its own, ``group`` the set that warnings name. Raises a
    located problem.
    """
    if isinstance(raw, tuple) and all(isinstance(entry, InstalledSpring) for entry in raw):
        return raw
    entries = raw if isinstance(raw, list) else [raw]
    if not 1 <= len(entries) <= 2:
        raise problem("there are one or two springs, outer first")
    paths = [(place,) if isinstance(raw, list) else () for place in range(len(entries))]
    pair = any(isinstance(entry, dict) and "loads_of" in entry for entry in entries)
    if pair and len(entries) < 2:
        raise problem(
            "loads_of = 'pair' is said of two springs; add the inner one", (*paths[0], "loads_of")
        )
    names = ("outer", "inner") if len(entries) == 2 else (name,)
    kinds: list[type[SpringDefinition | SpringCard]] = []
    tables: list[dict[str, Any]] = []
    for entry, path, called in zip(entries, paths, names, strict=True):
        which = f"{called} " if len(entries) == 2 else ""
        kind = guarded(_kind_of, entry, which, pair, path=path)
        kinds.append(kind)
        table = {key: value for key, value in entry.items() if key in kind.model_fields}
        tables.append({"name": called, **table} if called else table)
    parts = read_pair(tables) if pair else tuple(map(validate_as, kinds, tables, paths))
    if len(parts) == 2:
        _refuse_too_wide(parts)
    springs = tuple(map(_installed, parts, entries, paths, [group] * len(parts)))
    if len({spring.name for spring in springs}) < len(springs):
        raise problem(
            f"both springs are named '{springs[0].name}'; give each a name of its own",
            (1, "name"),
        )
    return springs


def _refuse_too_wide(parts: tuple[SpringDefinition | SpringCard, ...]) -> None:
    """Refuse an inner card whose coils are wider than the outer one's are inside; the interference of
    damped pairs passes.
    """
    sizes = []
    for part in parts:
        wire = part.wire_diameter if isinstance(part, SpringCard) else None
        if not isinstance(part, SpringCard) or wire is None:
            return
        mean, outer = part.mean_diameter, part.outer_diameter
        if outer is None and mean is None:
            return
        sizes.append((outer if outer is not None else (mean or 0.0) + wire, wire))
    inside = sizes[0][0] - 2 * sizes[0][1]
    if inside > 0 and sizes[1][0] > INTERFERENCE * inside:
        raise problem(
            f"the inner spring is {sizes[1][0] * 1e3:.4g} mm wide and does not fit into the outer one, which is {inside * 1e3:.4g} mm wide "
            "inside; check diameters and wires, and that the outer spring comes first",
            (1, "outer_diameter"),
        )


def _installed(
    part: SpringDefinition | SpringCard, entry: dict[str, Any], path: tuple[int, ...], group: str
) -> InstalledSpring:
    """The spring of a ``part`` with the other keys of its table; a doubtful card is warned of with the set ``group``."""
    by_card = isinstance(part, SpringCard)
    rest = {key: one for key, one in entry.items() if key in (OF_CARD if by_card else OF_WIRE)}
    if "options" in rest:
        rest["options"] = guarded(_read_options, rest["options"], path=(*path, "options"))
    spring = validate_as(InstalledSpring, {"card" if by_card else "wire": part, **rest}, path)
    if spring.card is not None and spring.card.doubt:
        of_set = f" of set '{group}'" if group else ""
        text = f"spring '{spring.name}'{of_set}: {spring.card.doubt}"
        warnings.warn(text, UnusualValueWarning, stacklevel=2)
    return spring


def _read_options(raw: Any) -> dict[str, dict[str, Any]]:
    """Options by the word of their model, of which only those that are given are kept."""
    if not isinstance(raw, dict):
        raise problem("a table of spring-model words is needed here, such as options.multi-mass")
    return {
        word: validate_as(
            guarded(registry.find, "springs", word, path=(word,)).options, values, (word,)
        ).model_dump(exclude_unset=True)
        for word, values in raw.items()
    }


def _kind_of(entry: Any, which: str, pair: bool) -> type[SpringDefinition | SpringCard]:
    """The table that reads a spring, whose keys it knows."""
    if not isinstance(entry, dict):
        raise problem(
            "a spring is a table: its wire (wire_diameter and so on) or its card (preload, rate)"
        )
    known = SpringDefinition.model_fields.keys() | OF_WIRE.keys() | CARD.keys()
    if not pair and entry.keys() <= known and not (_LOADS | _WIRE_KEYS) & entry.keys():
        raise problem(
            f"the loads of the {which}spring are missing; give preload (seat load) and rate, or preload, open_load and open_height "
            + (
                "(where those of the other are of both together: loads_of = 'pair' there)"
                if which
                else "(of a spring known by its wire: total_coils, pitch, ends)"
            )
        )
    if (
        not pair
        and "total_coils" in entry
        and _LOADS & entry.keys()
        and not (_WIRE_KEYS - {"total_coils"}) & entry.keys()
    ):
        raise problem(
            "total_coils is of a spring known by its wire or of a pair (loads_of = 'pair'); on a card with its loads give active_coils, two "
            "fewer where both ends are closed and ground, or leave it out: rate, wire and diameter give them",
            ("total_coils",),
        )
    fields = fields_of({"loads_of": "pair"} if pair else entry)
    refuse_unknown(entry, fields)
    return SpringCard if "preload" in fields else SpringDefinition


def fields_of(entry: Mapping[str, Any]) -> dict[str, FieldInfo]:
    """The fields of the table of a spring, by its keys, its name first."""
    if not is_card(entry):
        fields = SpringDefinition.model_fields | OF_WIRE
    else:
        fields = (SpringCard.model_fields if "loads_of" in entry else CARD) | OF_CARD
    return {"name": fields["name"], **fields}


def is_card(entry: Mapping[str, Any]) -> bool:
    """Whether the table of a spring is read as its card, else as its wire.

    >>> is_card({"preload": "250 N", "rate": "32 N/mm"}), is_card({"wire_diameter": "4 mm", "total_coils": 6})
    (True, False)
    """
    if "loads_of" in entry:
        return True
    return any(key in _CARD_KEYS for key in entry) and not (
        "wire_diameter" in entry and any(key in _WIRE_KEYS for key in entry)
    )


def _of_case(raw: Any, info: ValidationInfo) -> tuple[InstalledSpring, ...]:
    name = info.data.get("name") or (info.context or {}).get("name", "spring")
    return springs_of(raw, name)


def _of_train(sets: Mapping[str, Any]) -> FrozenMapping:
    return FrozenMapping(
        {name: guarded(springs_of, raw, "spring", name, path=(name,)) for name, raw in sets.items()}
    )


#: The springs of a case, called by its name; and those of a train, sets by their names.
CaseSprings = Annotated[tuple[InstalledSpring, ...], PlainValidator(_of_case)]
SpringSets = Annotated[
    Mapping[Name, Annotated[tuple[InstalledSpring, ...], PlainValidator(lambda raw: raw)]],
    AfterValidator(_of_train),
]
