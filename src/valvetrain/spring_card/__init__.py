"""Springs from catalogue cards and from tables of a spring tester.

Begin in ``card.py`` (a card) and ``fit.py`` (the spring that meets it); ``tester.py`` fits a spring to forces over height;
``answer.py`` shows both by the findings of ``rules.py``.
"""

from valvetrain.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
