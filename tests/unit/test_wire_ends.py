"""Unit: inactive and ground turns of every end that textbooks name, by hand, and the refusal of any
other.
"""

from __future__ import annotations

import pytest

from valvetrain.errors import InputError
from valvetrain.parameters.constructors import _end


@pytest.mark.parametrize(
    ("end", "turns"),
    [
        ("closed-ground", (1, 0.5)),
        ("closed", (1, 0)),
        ("open", (0, 0)),
        ("open-ground", (0.5, 0.25)),
    ],
)
def test_ends_of_textbooks_have_their_turns(end, turns):
    found = _end(end, 4e-3, 8e-3)
    assert (found.kind, found.inactive_coils, found.ground_coils) == (end, *turns)


def test_any_other_end_is_refused():
    with pytest.raises(
        InputError,
        match=r"^ends: ends 'bent' are unknown; use closed-ground, closed, open, open-ground$",
    ):
        _end("bent", 4e-3, 8e-3)
