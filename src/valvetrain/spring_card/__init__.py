"""Springs from catalogue cards and from tables of a spring tester.

Begin in ``card.py`` (a card) and ``fit.py`` (the spring that meets it); ``tester.py`` fits a spring to forces over height;
``page.py`` and ``command.py`` show both.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvetrain.lazy import lazy_names

#: Public name -> module of this package.
_HOMES = {
    "SpringLoad": "card",
    "CatalogueCard": "card",
    "spring_from_card": "fit",
    "SpringFit": "fit",
    "card_from_table": "tester",
    "spring_from_tester": "tester",
    "TesterFit": "tester",
}

__all__ = [
    "SpringLoad",
    "CatalogueCard",
    "spring_from_card",
    "SpringFit",
    "card_from_table",
    "spring_from_tester",
    "TesterFit",
]

if TYPE_CHECKING:
    from valvetrain.spring_card.card import CatalogueCard as CatalogueCard
    from valvetrain.spring_card.card import SpringLoad as SpringLoad
    from valvetrain.spring_card.fit import SpringFit as SpringFit
    from valvetrain.spring_card.fit import spring_from_card as spring_from_card
    from valvetrain.spring_card.tester import TesterFit as TesterFit
    from valvetrain.spring_card.tester import card_from_table as card_from_table
    from valvetrain.spring_card.tester import spring_from_tester as spring_from_tester
else:
    __getattr__ = lazy_names(__name__, _HOMES)
