"""Two springs side by side in one train: the train with a set for either."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.loading import AnyCase, case_of, case_of_tree, parse_toml
from valvetrain.runs.requests import CompareSprings

#: Key paths of a train that belong to its own springs.
_OWN = ("springs", "spring_set", "variants", "rubbing")
#: Names that a spring or a case has when it was not named.
_UNNAMED = ("", "spring", "spring card", "spring-card", "valve spring")
#: Spring model of both where one is a card and one a wire: a chain of a card is coarser than one of a wire.
MIXED_MODEL = "modal-uniform"


def with_two_springs(
    train: AnyCase, first: AnyCase, second: AnyCase, files: tuple[str, str] = ("", "")
) -> Case:
    """The case of a ``train`` whose two spring sets are the springs of ``first`` and ``second``.

    Parameters
    ----------
    train : case with a [train]
    first, second : cases with a [spring], as ``valvetrain spring-card`` writes them, or trains, of
        which the spring set in use is taken. Each goes by the name of its spring, else by that of its
        case. A spring without damping has that of the train's own
    files : stems of their files, by which springs without a name or with one name go

    Returns
    -------
    Case that holds both as spring sets and nothing published

    Raises
    ------
    InputError : a train without [train], a case without springs, what the springs refuse in it

    Examples
    --------
    >>> import valvetrain as vt
    >>> text = 'spring = { preload = "320 N", rate = "42 N/mm", mass = "48 g" }'
    >>> both = with_two_springs("tdi-pushrod", vt.Case(text, name="stiff"), "tdi-pushrod")
    >>> list(both.train.springs)
    ['stiff', 'tdi-pushrod']
    """
    engine, pair = case_of(train), (case_of(first), case_of(second))
    if engine.train is None:
        raise InputError(
            f"case '{engine.name}' has no [train], so nothing moves the springs; give the case of an engine, such as "
            "'valvetrain new my-engine --kind pushrod' writes",
            "--train",
        )
    tree = parse_toml(engine.text, engine.name)
    own = _blocks(engine)
    both = [[_damped(block, own) for block in _blocks(case)] for case in pair]
    sets: dict[str, Any] = dict(zip(_names(pair, both, files), both, strict=True))
    other = {key: value for key, value in tree["train"].items() if key not in _OWN}
    parts = {key: value for key, value in tree.items() if key in ("lift_law", "operation")}
    title = " against ".join(sets)
    return case_of_tree(
        {"title": f"{title} in {engine.name}", **parts, "train": {**other, "springs": sets}},
        f"{engine.name}-springs",
    )


def _names(
    cases: tuple[Case, Case], blocks: list[list[dict[str, Any]]], files: tuple[str, str]
) -> tuple[str, str]:
    """Two names: of the springs, else of their cases or files; equal ones are distinguished by these."""
    found = []
    for case, springs, file in zip(cases, blocks, files, strict=True):
        own = str(springs[0].get("name", "")) if case.train is None and len(springs) == 1 else ""
        names = (own, case.name, file)
        found.append(next((one for one in names if one not in _UNNAMED), file or case.name))
    for first, second in (found, files, [case.name for case in cases]):
        if first != second and first and second:
            return first, second
    return found[0], f"{found[0]} (2)"


def _blocks(case: Case) -> list[Mapping[str, Any]]:
    """The spring blocks of a case as its file holds them: its [spring], or the set that its train
    uses.
    """
    tree = parse_toml(case.text, case.name)
    found = tree.get("spring")
    if found is None and case.train is not None:
        found = tree["train"]["springs"][case.train.spring_set or next(iter(case.train.springs))]
    if found is None:
        raise InputError(
            f"case '{case.name}' holds no spring to compare; give one with [spring], as 'valvetrain spring-card' writes, or an engine"
        )
    return found if isinstance(found, list) else [found]


def _damped(block: Mapping[str, Any], own: list[Mapping[str, Any]]) -> dict[str, Any]:
    """The block, with the damping of the train's own spring where it gives none."""
    damping = next((one["damping"] for one in own if "damping" in one), None)
    return dict(block) if damping is None or "damping" in block else {**block, "damping": damping}


def paired(
    request: CompareSprings, first: AnyCase, second: AnyCase, files: tuple[str, str] = ("", "")
) -> CompareSprings:
    """The request of an engine with the springs of ``first`` and ``second`` in it, as :func:`with_two_springs` puts them.

    Without models both have one where a card is compared with a wire, else their own.
    """
    case = with_two_springs(request.case, first, second, files)
    assert case.train is not None
    own = {case.train.model_of(name) for name in case.train.springs}
    models = request.models or ((MIXED_MODEL,) if len(own) > 1 else ())
    return replace(request, case=case, models=models, spring_sets=tuple(case.train.springs))
