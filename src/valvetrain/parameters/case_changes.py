"""The one way from a case and changes of its values to a case: its file with those values, read again.

What follows from a changed value, such as the rate of a spring card, follows anew.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import case_of_tree, parse_toml
from valvetrain.parameters.overrides import split_notes


@dataclass(frozen=True, eq=False)
class CaseTables:
    """The tables of a case's file, not to be changed: ``tree`` as written, ``bare`` without notes and
    published values; ``warnings`` that reading them gives.
    """

    tree: dict[str, Any]
    bare: dict[str, Any]
    warnings: tuple[str, ...] = ()


@lru_cache(maxsize=16)
def tables_of(case: Case) -> CaseTables:
    """The tables of the text of a case.

    Raises :class:`InputError` for a case that a program put together or changed part by part, which its
    text does not give: what follows from a value could not follow a change of it.
    """
    tree: dict[str, Any] = {}
    again: Case | None = None
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        if case.text:
            tree = parse_toml(case.text, case.name)
            tree |= {"name": case.name} if "name" in tree else {}
            again = case_of_tree(tree, case.name, where=case.name, text=case.text)
    if again != case:
        raise InputError(
            f"case '{case.name}' was put together or changed in Python and has no file; make it with vt.Case and its set"
        )
    bare = split_notes(tree)[0]
    bare.pop("published", None)
    return CaseTables(tree, bare, tuple(str(one.message) for one in caught))


def changed_case(case: Case, changes: Mapping[str, Any]) -> Case:
    """The case with the values at the key paths in ``changes`` as its file would hold them.

    A function among them makes the new value of the bare one in the file. Raises :class:`InputError`,
    one sentence, for a path that leads nowhere, a case that cannot exist, and as :func:`tables_of`.

    >>> import valvetrain as vt
    >>> changed_case(vt.load_case("job-t"), {"operation.cycles": 3}).operation.cycles
    3
    """
    tree = tables_of(case).tree
    made = case_of_tree(tree, case.name, where="", changes=changes, published=case.published)
    return replace(made, changed=tuple(dict.fromkeys((*case.changed, *made.changed))))
