"""Values of a case file changed in its text, so that comments and order stay."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from typing import Any

from valvetrain.errors import InputError
from valvetrain.parameters.loading import parse_toml
from valvetrain.parameters.overrides import read_assignment, set_value, with_values
from valvetrain.units.text import clipped

_PLAIN_FILE = re.compile(r"[^\W_][\w.+ -]*")


def with_value(text: str, key: str, text_value: str) -> str:
    """The case file ``text`` with the value at the dotted ``key``, written as ``--set`` takes it;
    empty removes the key.

    A note on the earlier value (status, source) goes with it. Raises :class:`InputError` for a path
    that leads nowhere.

    >>> with_value("[spring]\\ntotal_coils = 6 # counted\\n", "spring.total_coils", "7")
    '[spring]\\ntotal_coils = 7 # counted\\n'
    """
    return with_change(text, *read_assignment(f"{key}={text_value}", key))


def with_change(text: str, path: str, value: Any) -> str:
    """As :func:`with_value`, with the value as :func:`set_value` takes it."""
    document = opened(text)
    set_value(document, path, value)
    return saved(document)


def with_name(text: str, name: str) -> str:
    """The case file ``text`` with ``name`` as its name, where it gives one; else its folder's name
    is the case's.
    """
    if "name" not in tomllib.loads(text):
        return text
    return with_value(text, "name", f'"{name}"')


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


def opened(text: str) -> Any:
    """The case file ``text`` as a document whose comments stay. Raises :class:`InputError` for what
    is no TOML.
    """
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    try:
        return tomlkit.parse(text)
    except (TOMLKitError, RecursionError, ValueError) as error:
        raise InputError(
            f"is not valid TOML: {clipped(str(error), 160)}; correct the text first", "case"
        ) from None


def saved(document: Any) -> str:
    """The text of a document of :func:`opened`."""
    import tomlkit

    return tomlkit.dumps(document)
