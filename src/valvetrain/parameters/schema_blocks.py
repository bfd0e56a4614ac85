"""Reads the spring blocks of a case file: one spring, or outer and inner, by wire, card or a card of both
together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from pydantic import AfterValidator, PlainValidator, ValidationInfo

from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.lift_law import FrozenMapping
from valvetrain.parameters.schema_installed import CardBlock, WireBlock
from valvetrain.parameters.schema_pair import read_pair
from valvetrain.parameters.schema_spring import SpringCardModel, SpringModel
from valvetrain.parameters.schema_types import Name, placed, problem, validate_as

#: Keys that a card alone has, and a wire alone; a wire_diameter shows neither, for a card may have
#: one for its mass.
_CARD_KEYS = (
    set(SpringCardModel.model_fields) - set(SpringModel.model_fields) - {"installed_height"}
)
#: Keys of which a card has one or more.
_LOADS = {"preload", "rate", "open_load"}
_WIRE_KEYS = set(SpringModel.model_fields) - set(SpringCardModel.model_fields)

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
    blocks: tuple[WireBlock | CardBlock, ...]
    if any(isinstance(entry, dict) and "loads_of" in entry for entry in entries):
        if len(entries) < 2:
            raise problem(
                "loads_of = 'pair' is said of two springs; add the inner one",
                (*paths[0], "loads_of"),
            )
        blocks = read_pair(entries)
    else:
        which = ("outer ", "inner ") if len(entries) == 2 else ("",)
        blocks = tuple(map(_read_block, entries, paths, which))
    _refuse_too_wide(blocks)
    names = ("outer", "inner") if len(blocks) == 2 else (name,)
    springs = tuple(
        placed(path, block.installed, called, group)
        for path, block, called in zip(paths, blocks, names, strict=True)
    )
    if len({spring.name for spring in springs}) < len(springs):
        raise problem(
            f"both springs are named '{springs[0].name}'; give each a name of its own",
            (1, "name"),
        )
    return springs


def _refuse_too_wide(blocks: Sequence[WireBlock | CardBlock]) -> None:
    """Refuse an inner card whose coils are wider than the outer one's are inside; the interference of
    damped pairs passes.
    """
    sizes = []
    for block in blocks:
        wire = block.wire_diameter if isinstance(block, CardBlock) else None
        if not isinstance(block, CardBlock) or wire is None:
            return
        mean, outer = block.mean_diameter, block.outer_diameter
        if outer is None and mean is None:
            return
        sizes.append((outer if outer is not None else (mean or 0.0) + wire, wire))
    inside = sizes[0][0] - 2 * sizes[0][1]
    if len(sizes) == 2 and inside > 0 and sizes[1][0] > INTERFERENCE * inside:
        raise problem(
            f"the inner spring is {sizes[1][0] * 1e3:.4g} mm wide and does not fit into the outer one, which is {inside * 1e3:.4g} mm wide "
            "inside; check diameters and wires, and that the outer spring comes first",
            (1, "outer_diameter"),
        )


def _read_block(entry: Any, path: tuple[int, ...], which: str) -> WireBlock | CardBlock:
    if not isinstance(entry, dict):
        raise problem(
            "a spring is a table: its wire (wire_diameter and so on) or its card (preload, rate)",
            path,
        )
    known = WireBlock.model_fields.keys() | CardBlock.model_fields.keys()
    if entry.keys() <= known and not (_LOADS | _WIRE_KEYS) & entry.keys():
        raise problem(
            f"the loads of the {which}spring are missing; give preload (seat load) and rate, or preload, open_load and open_height "
            + (
                "(where those of the other are of both together: loads_of = 'pair' there)"
                if which
                else "(of a spring known by its wire: total_coils, pitch, ends)"
            ),
            path,
        )
    if (
        "total_coils" in entry
        and _LOADS & entry.keys()
        and not (_WIRE_KEYS - {"total_coils"}) & entry.keys()
    ):
        raise problem(
            "total_coils is of a spring known by its wire or of a pair (loads_of = 'pair'); on a card with its loads give active_coils, two "
            "fewer where both ends are closed and ground, or leave it out: rate, wire and diameter give them",
            (*path, "total_coils"),
        )
    return (
        validate_as(CardBlock, entry, path)
        if is_card(entry)
        else validate_as(WireBlock, entry, path)
    )


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
        {name: placed(name, springs_of, raw, "spring", name) for name, raw in sets.items()}
    )


#: The springs of a case, called by its name; and those of a train, sets by their names.
CaseSprings = Annotated[tuple[InstalledSpring, ...], PlainValidator(_of_case)]
SpringSets = Annotated[
    Mapping[Name, Annotated[tuple[InstalledSpring, ...], PlainValidator(lambda raw: raw)]],
    AfterValidator(_of_train),
]
