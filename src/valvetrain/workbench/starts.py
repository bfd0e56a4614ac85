"""Tables that a case does not have yet: which it may get, and values that they begin with, each
said to be assumed.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.annotations import split_notes
from valvetrain.parameters.case import Case
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.templates import template_text
from valvetrain.workbench.edits import opened, saved

#: Difference of diameters of nested springs, and of a spring and a bore (m); the gap on either side
#: is half of it.
GAP = 1e-3
#: Share of the loads and of the mass of a spring that one inside it begins with, where both are
#: known by their cards.
SHARE = 0.4
_SOURCE = "to begin with; put your own"
#: Parts of a train that may be absent -> label, what they are, values to begin with. The gas load
#: begins without any force.
PARTS: dict[str, tuple[str, str, Mapping[str, str]]] = {
    "gas": ("Gas load", "force of the gas on the valve over the cam angle",
            {"cam_angles": "0, 90, 180, 270 deg", "forces": "0, 0, 0, 0 N"}),
    "crank": ("Crank and piston", "for the clearance of valve and piston",
              {"radius": "45 mm", "rod_length": "150 mm", "clearance": "8 mm", "top_dead_centre": "120 deg"}),
}  # fmt: skip


def assumed(value: Any) -> dict[str, Any]:
    """A value with a note that it is assumed."""
    return {"value": value, "status": "assumed", "source": _SOURCE}


def of_template(name: str) -> dict[str, Any]:
    """The table called ``name`` of the template of a spring alone."""
    found: dict[str, Any] = tomllib.loads(template_text("spring"))[name]
    return {"status": "assumed", "source": _SOURCE, **found}


def guide_of(spring: InstalledSpring) -> dict[str, Any]:
    """The guide of a ``spring`` by its wire: a bore around it. Raises :class:`InputError` for one
    known by its card.
    """
    return {"bore": assumed(_length(_outer(spring.wire) + GAP))}


def inner_spring(outer: InstalledSpring, given: Mapping[str, Any]) -> dict[str, Any]:
    """A spring that fits inside the ``outer`` one, whose table in the file is ``given``: as
    slender, of its material, wound the other way.

    By its card where the outer one is. Raises :class:`InputError` where none fits.
    """
    head = {
        "status": "assumed",
        "source": _SOURCE,
        "name": "inner" if outer.name != "inner" else "second",
    }
    if outer.wire is None:
        card = outer.card
        if card is None:
            raise InputError("the first spring is not known; give it first", "spring")
        mass = {} if card.mass is None else {"mass": f"{SHARE * card.mass * 1e3:.3g} g"}
        return (
            head
            | {
                "preload": f"{SHARE * card.preload:.3g} N",
                "rate": f"{SHARE * card.rate / 1e3:.3g} N/mm",
            }
            | mass
        )
    wire = outer.wire
    coil = np.linspace(0.0, wire.total_coils, 257)
    mean, thick = wire.mean_diameter.value(coil), wire.wire_diameter.value(coil)
    narrow = int(np.argmin(mean - thick))
    index = float(mean[narrow] / thick[narrow])
    inner_wire = (float(mean[narrow] - thick[narrow]) - GAP) / (index + 1)
    if inner_wire <= 0:
        raise InputError("no second spring fits inside this one; widen it first", "spring")
    bare, _, _ = split_notes(
        {"material": given["material"]}
    )  # its notes say where the outer one's comes from
    height = {"precompression": _length(outer.precompression)}
    if "installed_height" in given:
        height = {"installed_height": _length(wire.free_length - outer.precompression)}
    return head | {
        "wire_diameter": _length(inner_wire),
        "mean_diameter": _length(index * inner_wire),
        "total_coils": float(f"{wire.total_coils:.4g}"),
        "free_length": _length(wire.free_length),
        "hand": "left" if wire.hand == "right" else "right",
        "material": bare["material"],
        "ends": "closed-ground",
        **height,
    }


def _outer(wire: SpringDefinition | None) -> float:
    """Largest outer diameter of a spring (m)."""
    if wire is None:
        raise InputError("a spring known by its card has no guide; give its wire", "guide")
    coil = np.linspace(0.0, wire.total_coils, 257)
    return float(np.max(wire.mean_diameter.value(coil) + wire.wire_diameter.value(coil)))


def _length(value: float) -> str:
    return f"{value * 1e3:.4g} mm"


@dataclass(frozen=True, slots=True)
class Addition:
    """A table that a case may get.

    Parameters
    ----------
    key : key path of the table
    label : words for a button
    help : what it is
    """

    key: str
    label: str
    help: str


def additions(case: Case, text: str) -> list[Addition]:
    """Tables that ``case``, read from ``text``, does not have and may get, in the order of a file.

    >>> from valvetrain.parameters.loading import load_case
    >>> case = load_case("tdi-pushrod")
    >>> [one.key for one in additions(case, case.text)][:2]
    ['train.springs.stock.1', 'train.springs.performance.1']
    """
    tree = tomllib.loads(text)
    found = []
    if case.train is None and not case.springs:
        found.append(Addition("spring", "Spring", "a spring by its wire"))
    for key, springs, suffix in _places(case):
        for place, spring in enumerate(springs):
            if spring.wire is not None and spring.guide is None:
                whose = f"{key}.{place}" if isinstance(_table(tree, key.split(".")), list) else key
                found.append(
                    Addition(
                        f"{whose}.guide",
                        f"Guide{suffix}{_which(springs, place)}",
                        "a bore around the spring, or a rod inside it",
                    )
                )
        if len(springs) == 1:
            found.append(
                Addition(f"{key}.1", f"Second spring{suffix}", "a spring inside the first")
            )
    if case.lift_law is None:
        found.append(Addition("lift_law", "Lift law", "the lift over the cam angle"))
    if case.train is not None:
        found += [
            Addition(f"train.{name}", label, meaning)
            for name, (label, meaning, _) in PARTS.items()
            if getattr(case.train, name) is None
        ]
    return sorted(found, key=lambda one: one.key.endswith(".guide"))


def removable(case: Case, text: str) -> frozenset[str]:
    """Key paths of tables that ``case``, read from ``text``, may lose again."""
    tree = tomllib.loads(text)
    found = {
        f"train.{name}"
        for name in PARTS
        if case.train is not None and getattr(case.train, name) is not None
    }
    for key, springs, _ in _places(case):
        listed = isinstance(_table(tree, key.split(".")), list)
        found |= {
            f"{key}.{place}.guide" if listed else f"{key}.guide"
            for place, one in enumerate(springs)
            if one.guide is not None
        }
        found |= {f"{key}.1"} if len(springs) == 2 else set()
    found |= {"rubbing"} if "rubbing" in tree else set()
    found |= {"train.rubbing"} if "rubbing" in tree.get("train", {}) else set()
    return frozenset(
        found | ({"lift_law"} if case.lift_law is not None and case.springs else set())
    )


def with_addition(case: Case, text: str, key: str) -> str:
    """The ``text`` of ``case`` with the table at ``key``, a key of :func:`additions`. Raises
    :class:`InputError` for another.
    """
    keys = [one.key for one in additions(case, text)]
    if key not in keys:
        raise InputError(
            f"'{key[:60]}' is no table that this case may get; {nearest(key, keys)}", "table"
        )
    document = opened(text)
    *heads, last = key.split(".")
    before = _table(tomllib.loads(text), heads)
    if last == "1":
        start = inner_spring(_springs(case, ".".join(heads))[0], _first(before))
        due: Any = [_first(before), start]
        _nest(document, heads, start)
    else:
        start = _start(case, heads, last)
        due = before | {last: start}
        _table(document, heads)[last] = start
    made, written = saved(document), None
    with suppress(ValueError, LookupError, TypeError):
        written = _table(tomllib.loads(made), heads)
    if written != due:
        raise InputError(
            "this case is written in a way that takes no table here; add it to the case file itself",
            key,
        )
    return made


def _start(case: Case, heads: Sequence[str], name: str) -> dict[str, Any]:
    """What the table called ``name`` below ``heads`` begins with."""
    if name in ("spring", "lift_law"):
        return of_template(name)
    if name != "guide":
        return {key: assumed(value) for key, value in PARTS[name][2].items()}
    listed = heads[-1].isdecimal()
    springs = _springs(case, ".".join(heads[:-1] if listed else heads))
    return guide_of(springs[int(heads[-1]) if listed else 0])


def _nest(document: Any, heads: Sequence[str], inner: Mapping[str, Any]) -> None:
    """Put a second spring behind the one at ``heads``, which then is in a list."""
    import tomlkit

    *above, last = heads
    table = _table(document, above)
    if isinstance(table[last], tomlkit.items.Array):
        second = tomlkit.inline_table()
        second.update(inner)
        table[last].append(second)
        return
    listed = table[last] if isinstance(table[last], list) else tomlkit.aot()
    if listed is not table[last]:
        listed.append(
            table[last]
            if isinstance(table[last], tomlkit.items.Table)
            else tomlkit.item(dict(table[last]))
        )
    behind = tomlkit.item(dict(inner))
    behind.add(tomlkit.nl())
    listed.append(behind)
    if listed is not table[last]:
        table[last] = listed


def _table(document: Any, heads: Sequence[str]) -> Any:
    """The value at ``heads`` in a document or the tree of a file."""
    for head in heads:
        document = document[int(head)] if isinstance(document, list) else document[head]
    return document


def _places(case: Case) -> list[tuple[str, tuple[InstalledSpring, ...], str]]:
    """Key path, springs and words of each place with springs."""
    if case.train is None:
        return [("spring", case.springs, "")] if case.springs else []
    several = len(case.train.springs) > 1
    named = {name: springs for name, springs in case.train.springs.items() if "." not in name}
    return [
        (f"train.springs.{name}", springs, f" of set {name}" if several else "")
        for name, springs in named.items()
    ]


def _springs(case: Case, key: str) -> tuple[InstalledSpring, ...]:
    return next(springs for place, springs, _ in _places(case) if place == key)


def _which(springs: Sequence[InstalledSpring], place: int) -> str:
    return f", {('outer', 'inner')[place]} spring" if len(springs) == 2 else ""


def _first(springs: Any) -> Mapping[str, Any]:
    """The table of the first of ``springs``, a table or a list of them."""
    found: Mapping[str, Any] = springs[0] if isinstance(springs, list) else springs
    return found
