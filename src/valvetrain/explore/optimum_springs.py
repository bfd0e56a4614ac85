"""The springs of a set in what a search found: which one a load is of, and the other loads of the card of a design."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from valvetrain.explore.optimum import Design, Optimum
from valvetrain.explore.space import Varied
from valvetrain.explore.trial import Trial
from valvetrain.parameters.case import Case
from valvetrain.parameters.case_changes import tables_of
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.overrides import file_key
from valvetrain.parameters.schema_pair import LOADS
from valvetrain.quantities.statics import card_quantities
from valvetrain.solution.definition import NESTED

#: Values of the card of a design in addition to the varied ones: quantity -> name.
CARD = {"card_preload": "seat load", "card_rate": "rate", "card_open_force": "open load"}


def spring_of(case: Case | None, key: str) -> str:
    """``pair``, ``outer spring`` or ``inner spring``, whichever a key of two springs is of;
    empty for any other.

    >>> import valvetrain as vt
    >>> spring_of(vt.load_case("vaz-ohc"), "train.springs.nested-cards.1.rate")
    'inner spring'
    """
    heads = file_key(key).split(".")
    if case is None:
        return ""
    tree = tables_of(case).bare
    entries, rest = tree.get("spring"), heads[1:]
    if heads[:2] == ["train", "springs"]:
        entries, rest = tree["train"]["springs"].get("".join(heads[2:3])), heads[3:]
    elif heads[0] != "spring":
        return ""
    if (
        not isinstance(entries, list)
        or len(entries) != len(NESTED)
        or rest[:1] not in (["0"], ["1"])
    ):
        return ""
    of_both = any("loads_of" in one for one in entries)
    return (
        "pair" if of_both and rest[1:2] and rest[1] in LOADS else f"{NESTED[int(rest[0])]} spring"
    )


def in_pounds(varied: Sequence[Varied]) -> bool:
    """Whether a force was varied in pounds, so that other loads are given in pounds, too."""
    return any(one.unit == "lbf" for one in varied)


def card_values(found: Optimum, trial: Trial) -> Iterator[tuple[str, str, float, float]]:
    """Seat load, rate and open load of the card that is varied, as far as they are neither varied nor an objective: the
    name, of a pair with its spring, the quantity, and its value (SI) in the case and in the design; of loads of both
    springs those of the pair too.
    """
    case, varied = found.plan.case, found.plan.varied
    keys = [one.key.split(".") for one in varied]
    places = {tuple(key[:-1]) for key in keys if "spring" in key[0] or "springs" in key[1:2]}
    if case is None or len(places) != 1:
        return
    place = places.pop()
    # no key of a card's own: of a pair the spring itself, not both
    groups = {spring_of(case, ".".join((*place, "card"))): [place]}
    if any(spring_of(case, one.key) == "pair" for one in varied):
        groups = {"pair": [(*place[:-1], end) for end in ("0", "1")]} | groups
    known = [*trial.values, *trial.objectives, *trial.constraints]
    for spring, paths in groups.items():
        before, after = (_loads(one, paths) for one in (case, found.case_of(Design(trial, ""))))
        for name, label in CARD.items():
            if name in before and name in after and not np.any(np.isclose(known, after[name], rtol=1e-9, atol=0.0)):  # fmt: skip
                yield (
                    f"{label} of the {spring}" if spring else label,
                    name,
                    before[name],
                    after[name],
                )


def _loads(case: Case, paths: Sequence[tuple[str, ...]]) -> dict[str, float]:
    """The loads of the cards of springs, added up; empty where one has no card."""
    springs = [_spring_at(case, path) for path in paths]
    cards = [card_quantities(one.card) for one in springs if one is not None and one.card]
    if len(cards) < len(paths):
        return {}
    return {name: sum(one[name] for one in cards) for name in CARD}


def _spring_at(case: Case, path: tuple[str, ...]) -> InstalledSpring | None:
    """The spring that a key such as ``train.springs.card.0`` names; None for any other part."""
    if path[:2] == ("train", "springs") and len(path) == 4 and case.train is not None:
        springs, index = case.train.springs.get(path[2], ()), path[3]
    else:
        springs, index = case.springs, path[1] if len(path) == 2 else "0"
    place = int(index) if index.isdigit() else 0
    return springs[place] if place < len(springs) else None
