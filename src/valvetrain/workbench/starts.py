"""Tables that a case does not have yet: which it may get, and values that they begin with, each said to be assumed."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.workbench.edits import opened, saved
from valvetrain.workbench.start_values import PARTS, assumed, guide_of, inner_spring, of_template


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
    for key, springs, words in _places(case):
        for place, spring in enumerate(springs):
            if spring.wire is not None and spring.guide is None:
                whose = f"{key}.{place}" if isinstance(_table(tree, key.split(".")), list) else key
                found.append(
                    Addition(f"{whose}.guide", f"Guide{words}{_which(springs, place)}", "a bore around the spring, or a rod inside it")
                )
        if len(springs) == 1:
            found.append(Addition(f"{key}.1", f"Second spring{words}", "a spring inside the first"))
    if case.lift_law is None:
        found.append(Addition("lift_law", "Lift law", "the lift over the cam angle"))
    if case.train is not None:
        found += [Addition(f"train.{name}", label, told) for name, (label, told, _) in PARTS.items() if getattr(case.train, name) is None]
    return sorted(found, key=lambda one: one.key.endswith(".guide"))


def removable(case: Case, text: str) -> frozenset[str]:
    """Key paths of tables that ``case``, read from ``text``, may lose again."""
    tree = tomllib.loads(text)
    found = {f"train.{name}" for name in PARTS if case.train is not None and getattr(case.train, name) is not None}
    for key, springs, _ in _places(case):
        listed = isinstance(_table(tree, key.split(".")), list)
        found |= {f"{key}.{place}.guide" if listed else f"{key}.guide" for place, one in enumerate(springs) if one.guide is not None}
        found |= {f"{key}.1"} if len(springs) == 2 else set()
    found |= {"rubbing"} if "rubbing" in tree else set()
    found |= {"train.rubbing"} if "rubbing" in tree.get("train", {}) else set()
    return frozenset(found | ({"lift_law"} if case.lift_law is not None and case.springs else set()))


def with_addition(case: Case, text: str, key: str) -> str:
    """The ``text`` of ``case`` with the table at ``key``, a key of :func:`additions`. Raises :class:`InputError` for another."""
    keys = [one.key for one in additions(case, text)]
    if key not in keys:
        raise InputError(f"'{key[:60]}' is no table that this case may get; {nearest(key, keys)}", "table")
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
        raise InputError("this case is written in a way that takes no table here; add it to the case file itself", key)
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
    """Put a second spring behind the one at ``heads``, which then stands in a list."""
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
        listed.append(table[last] if isinstance(table[last], tomlkit.items.Table) else tomlkit.item(dict(table[last])))
    behind = tomlkit.item(dict(inner))
    behind.add(tomlkit.nl())
    listed.append(behind)
    if listed is not table[last]:
        table[last] = listed


def _table(document: Any, heads: Sequence[str]) -> Any:
    """What stands at ``heads`` in a document or the tree of a file."""
    for head in heads:
        document = document[int(head)] if isinstance(document, list) else document[head]
    return document


def _places(case: Case) -> list[tuple[str, tuple[InstalledSpring, ...], str]]:
    """Key path, springs and words of each place where springs stand."""
    if case.train is None:
        return [("spring", case.springs, "")] if case.springs else []
    several = len(case.train.springs) > 1
    named = {name: springs for name, springs in case.train.springs.items() if "." not in name}
    return [(f"train.springs.{name}", springs, f" of set {name}" if several else "") for name, springs in named.items()]


def _springs(case: Case, key: str) -> tuple[InstalledSpring, ...]:
    return next(springs for place, springs, _ in _places(case) if place == key)


def _which(springs: Sequence[InstalledSpring], place: int) -> str:
    return f", {('outer', 'inner')[place]} spring" if len(springs) == 2 else ""


def _first(springs: Any) -> Mapping[str, Any]:
    """The table of the first of ``springs``, a table or a list of them."""
    found: Mapping[str, Any] = springs[0] if isinstance(springs, list) else springs
    return found
