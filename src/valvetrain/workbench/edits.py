"""Values of a case file changed in its text, so that comments and order stay."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit import TOMLDocument
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import AoT, Array, InlineTable, Item, Table

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.loading import parse_case, parse_toml
from valvetrain.parameters.overrides import REMOVED, read_assignment, set_value, with_values
from valvetrain.parameters.schema_case import lend
from valvetrain.units.text import clipped
from valvetrain.workbench.starts import ASSUMED, FILE_KEYS, LAW_KEYS, LAW_STARTS

_PLAIN_FILE = re.compile(r"[^\W_][\w.+ -]*")


def changed(text: str, change: Callable[[Any], None]) -> str:
    """The case file ``text`` after ``change``, which is made twice: in the document, whose comments
    stay, and in the tree that the result must read as.

    Raises :class:`InputError` for a text that is no TOML, or that is written in a way which takes no such change.
    """
    due: Any = parse_toml(text, "case")
    made = ""
    with suppress(TOMLKitError, ValueError, LookupError, TypeError, AttributeError):
        change(due)
        document = tomlkit.parse(text)
        change(document)
        made = tomlkit.dumps(document)
    if not made or parse_toml(made, "case") != due:
        raise InputError(
            "this case is written in a way that cannot be changed here; change it in the file itself",
            "case",
        )
    return made


def with_value(text: str, path: str, value: Any) -> str:
    """The case file ``text`` with a ``value`` as :func:`set_value` takes it at the dotted ``path``.

    A note on the earlier value (status, source) goes with it. Raises :class:`InputError` for a path
    that leads nowhere.

    >>> with_value("[spring]\\ntotal_coils = 6 # counted\\n", "spring.total_coils", 7)
    '[spring]\\ntotal_coils = 7 # counted\\n'
    """
    return changed(text, lambda tree: set_value(tree, path, value))


def with_table(text: str, path: str, table: Mapping[str, Any]) -> str:
    """The case file ``text`` with a ``table`` at ``path``; a 1 at its end puts it behind the spring that is there."""
    *heads, last = path.split(".")

    def put(tree: Any) -> None:
        if last == "1":
            place = _at(tree, heads[:-1])
            place[heads[-1]] = _both(place, place[heads[-1]], table)
        else:
            _at(tree, heads)[last] = dict(table)

    return changed(text, put)


def _at(tree: Any, heads: Sequence[str]) -> Any:
    for head in heads:
        tree = tree[int(head)] if isinstance(tree, list) else tree[head]
    return tree


def _both(place: Any, first: Any, second: Mapping[str, Any]) -> Any:
    """The ``first`` spring of ``place``, a table or a list of one, with a ``second`` behind it."""
    if not isinstance(place, Table | TOMLDocument) or isinstance(first, Array):
        return [*first, dict(second)] if isinstance(first, list) else [first, dict(second)]
    springs = first if isinstance(first, AoT) else tomlkit.aot()
    if springs is not first:
        springs.append(first if isinstance(first, Table) else tomlkit.item(dict(first)))
    springs.append(tomlkit.item(dict(second)))
    return springs


def with_law(text: str, kind: str, file: str = "") -> str:
    """The case file ``text`` with a lift law of another ``kind``: what both kinds know stays, what the law
    lent to the train moves there, and the rest is assumed to begin with.

    Parameters
    ----------
    text : the case (TOML)
    kind : kind of lift law; raises :class:`InputError` for an unknown one
    file : name of the file that a law reads which is given by one
    """
    laws = registry.names("lifts")
    if kind not in laws:
        raise InputError(
            f"kind '{kind[:40]}' of a lift law is unknown; {nearest(kind, laws)}", "lift_law.kind"
        )
    fields = registry.find("lifts", kind).table.model_fields

    def change(tree: Any) -> None:
        law = tree["lift_law"]
        if law["kind"] == kind:
            return
        if isinstance(tree, TOMLDocument) and not isinstance(law, InlineTable):
            if "[lift_law]" not in text:  # dotted keys, which tomlkit does not remove all
                del tree["lift_law"]
                tree["lift_law"] = law = tomlkit.item(law.unwrap())
        lend(tree, law, fields)
        for name in [name for name in law if name not in fields]:
            del law[name]
        law["kind"] = kind
        reads = "file" in fields and "lifts" not in law
        if reads:
            law.setdefault("file", file)
        needed = (name for name in fields if fields[name].is_required())
        begun = FILE_KEYS if reads else (*needed, *LAW_KEYS.get(kind, ()))
        for name in begun:
            if name in fields and name not in law and name in LAW_STARTS:
                note: Any = tomlkit.inline_table() if isinstance(law, Item) else {}
                note.update(value=LAW_STARTS[name], **ASSUMED)
                law[name] = note
                law.pop("zero_of_angle", None)

    return changed(text, change)


def with_name(text: str, name: str) -> str:
    """The case file ``text`` with ``name`` as its name, where it gives one; else its folder's name
    is the case's.
    """
    return with_value(text, "name", name) if "name" in parse_toml(text, "case") else text


def read_change(
    case_text: str, key: str, value_text: str, folder: Path = Path(), where: str = "case"
) -> tuple[str, Any, Case]:
    """The change as the reader takes it: key path, value, and the changed case.

    A value that only reads as text, such as the title ``24``, is taken as text. Raises
    :class:`InputError` with the reader's sentence.
    """
    path, value = read_assignment(f"{key}={value_text}", key)
    refuse_foreign_files(case_text, {path: value})

    def read(given: Any) -> Case:
        return parse_case(case_text, where, folder, where, {path: given})

    try:
        return path, value, read(value)
    except InputError:
        if value is REMOVED or isinstance(value, str):
            raise
        with suppress(InputError):
            return path, value_text.strip(), read(value_text.strip())
        raise


def refuse_foreign_files(
    text: str, changes: Mapping[str, Any] | None = None, where: str = "case"
) -> None:
    """Refuse a case, as it is with ``changes`` (key path -> value), that names a file elsewhere
    than next to it, whatever reads it later.

    Raises :class:`InputError` with the name, for a text that is no TOML, or where a change leads
    nowhere.
    """
    tree: Mapping[str, Any] = parse_toml(text, where)
    tree = with_values(tree, changes) if changes else tree
    for name in named_files(tree):
        if not _PLAIN_FILE.fullmatch(name) or ".." in name:
            shown = clipped(name, 60)
            raise InputError(
                f"names the file '{shown}', which is not next to the case; add the file and name it plainly, as in 'lift.csv'",
                "file",
            )


def named_files(tree: Any) -> list[str]:
    """Every text under a key ``file`` of the tree of a case, with a note or without.

    >>> named_files({"lift_law": {"file": {"value": "lift.csv", "status": "measured"}}})
    ['lift.csv']
    """
    found: list[str] = []
    left = [tree]
    while left:
        item = left.pop()
        if isinstance(item, dict):
            named = item.get("file")
            value = named.get("value") if isinstance(named, dict) else named
            found += [value] if isinstance(value, str) else []
        left += item.values() if isinstance(item, dict) else item if isinstance(item, list) else ()
    return found
