"""A slice of ``make faults``: damaged cases, measurements and results end in an answer or one
sentence, and what does not is noticed.
"""

from __future__ import annotations

import pytest
from faults.apart import FILES, asked_apart, warm

SLICE = {"cases": 16, "runs": 2, "measurements": 4, "results": 10}
SEED = 20


@pytest.fixture(scope="module", autouse=True)
def loaded():
    """Forks of this process have what was loaded here."""
    warm()


@pytest.mark.slow  # every input is read and built, some are run
@pytest.mark.parametrize("kind", FILES)
def test_every_input_ends_in_an_answer(kind):
    answers = [asked_apart(kind, SEED, number) for number in range(SLICE[kind])]
    assert not [broken for _, broken in answers if broken]
    assert {word for word, _ in answers} <= {"answered", "refused", "failed"}
