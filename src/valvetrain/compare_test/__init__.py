"""``valvetrain compare-test``: a model compared with measured cycles or values of a test.

``compare.py`` runs the case and compares (begin there): ``reader.py`` reads the test, ``comparison.py`` judges one run by
``adequacy.py`` (Fisher's test) and ``events.py``; ``tables.py`` and ``summary.py`` hold what terminal and page show.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvetrain.lazy import lazy_names

#: Public name -> module of this package.
_HOMES = {
    "compare_with_test": "compare",
    "compare_study_with_test": "compare",
    "ModelAgainstTest": "compare",
    "AdequacyTest": "adequacy",
    "adequacy_test": "adequacy",
    "compare_test_page": "page",
}

__all__ = [
    "compare_with_test",
    "compare_study_with_test",
    "ModelAgainstTest",
    "AdequacyTest",
    "adequacy_test",
    "compare_test_page",
]

if TYPE_CHECKING:
    from valvetrain.compare_test.adequacy import AdequacyTest as AdequacyTest
    from valvetrain.compare_test.adequacy import adequacy_test as adequacy_test
    from valvetrain.compare_test.compare import ModelAgainstTest as ModelAgainstTest
    from valvetrain.compare_test.compare import compare_study_with_test as compare_study_with_test
    from valvetrain.compare_test.compare import compare_with_test as compare_with_test
    from valvetrain.compare_test.page import compare_test_page as compare_test_page
else:
    __getattr__ = lazy_names(__name__, _HOMES)
