"""``valvetrain compare-test``: a model compared with measured cycles or values of a test.

``compare.py`` runs the case and compares (begin there): ``reader.py`` reads the test, ``comparison.py`` judges one run by
``adequacy.py`` (Fisher's test) and ``agreement.py``. ``rules.py`` says what that means, ``answer.py`` shows it, ``tables.py`` writes it.
"""

from valvetrain.lazy import public_names

__getattr__, __dir__, __all__ = public_names(__name__, __file__)
