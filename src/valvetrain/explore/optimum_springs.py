"""The springs of a set in what a search found: which one a load is of, and the best card's other loads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from valvetrain.explore.measure import Measure
from valvetrain.explore.optimum import Optimum
from valvetrain.explore.space import Varied
from valvetrain.explore.trial import Trial
from valvetrain.parameters.case import Case
from valvetrain.parameters.case_changes import tables_of
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.overrides import file_key
from valvetrain.parameters.schema_pair import LOADS
from valvetrain.quantities.statics import card_quantities
from valvetrain.solution.definition import NESTED, PAIR, shown
from valvetrain.units import si

#: Values of the card of a best design in addition to the varied ones: quantity -> name, and its unit next to
#: loads in pounds.
CARD = {
    "card_preload": ("seat load", "lbf"),
    "card_rate": ("rate", "lbf/in"),
    "card_open_force": ("open load", "lbf"),
}


@dataclass(frozen=True)
class OfCard:
    """A load or rate of a card as an objective: its ``label`` with its spring, in the ``unit`` of what
    was varied, ``scale`` in SI.
    """

    label: str
    unit: str
    scale: float
    limit: None = None

    def shown(self, value: float) -> float:
        """A value (SI) in that unit."""
        return value / self.scale


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


def as_of_card(found: Optimum, measure: Measure) -> Measure | OfCard:
    """A load or rate of a card, of a pair with its spring and in pounds where those were varied; any
    other measure as it is.
    """
    spring, _, bare = measure.quantity.partition("_")
    bare = bare if spring in (*NESTED, PAIR) else measure.quantity
    if measure.limit is not None or bare not in CARD:
        return measure
    of = f" of the {spring} spring" if spring in NESTED and spring not in measure.label else ""
    unit = CARD[bare][1] if in_pounds(found.plan.varied) else measure.unit
    return OfCard(f"{measure.label}{of}", unit, _scale(bare, unit))


def _scale(name: str, unit: str) -> float:
    return si(f"1 {unit}", "stiffness" if "rate" in name else "force")


def card_values(found: Optimum, trial: Trial) -> dict[str, list[str]]:
    """Of the card that is varied seat load, rate and open load, as far as they are neither varied nor the
    objective, by the spring of a pair; of loads of both springs those of the pair too.
    """
    case, varied = found.plan.case, found.plan.varied
    keys = [one.key.split(".") for one in varied] if case is not None else []
    places = {tuple(key[:-1]) for key in keys if "spring" in key[0] or "springs" in key[1:2]}
    if len(places) != 1 or found.best is None:
        return {}
    place = places.pop()
    best = found.case_of(found.best)
    spring = _spring_at(best, place)
    if spring is None or spring.card is None:
        return {}
    groups = {}
    if any(spring_of(case, one.key) == "pair" for one in varied):
        both = [_spring_at(best, (*place[:-1], end)) for end in ("0", "1")]
        cards = [card_quantities(one.card) for one in both if one is not None and one.card]
        groups["pair"] = {name: sum(one[name] for one in cards) for name in CARD}
    # no key of a card's own: of a pair the spring itself, not both
    groups[spring_of(case, ".".join((*place, "card")))] = card_quantities(spring.card)
    known = [*trial.values, *trial.objectives]
    return {
        word: [
            _card_text(name, value, in_pounds(varied))
            for name in CARD
            if (value := values.get(name)) is not None
            and not np.any(np.isclose(known, value, rtol=1e-9, atol=0.0))
        ]
        for word, values in groups.items()
    }


def _card_text(name: str, value: float, pounds: bool) -> str:
    label, unit = CARD[name]
    number, own = (value / _scale(name, unit), unit) if pounds else shown(name, value)
    return f"{label} {number:.4g} {own}"


def _spring_at(case: Case, path: tuple[str, ...]) -> InstalledSpring | None:
    """The spring that a key such as ``train.springs.card.0`` names; None for any other part."""
    if path[:2] == ("train", "springs") and len(path) == 4 and case.train is not None:
        springs, index = case.train.springs.get(path[2], ()), path[3]
    else:
        springs, index = case.springs, path[1] if len(path) == 2 else "0"
    place = int(index) if index.isdigit() else 0
    return springs[place] if place < len(springs) else None
