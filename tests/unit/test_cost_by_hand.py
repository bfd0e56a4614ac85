"""What a request is estimated to take, by hand, and the sentence that refuses one beyond its
bounds.
"""

from __future__ import annotations

import pytest

from valvetrain.errors import InputError
from valvetrain.runs.cost import (
    Cost,
    Limits,
    duration_text,
    memory_text,
    refuse_cost,
)


@pytest.mark.parametrize(
    ("cost", "limits", "words"),
    [
        (
            Cost(700.0, 1e6),
            Limits(),
            "about 11.7 min and 1 MB, beyond the bound of 10 min; .* with --limit '13 min'$",
        ),
        (Cost(7000.0, 3e9), Limits(), "beyond the bound of 10 min and 2 GB; .* '3 h, 4 GB'$"),
        (Cost(1.0, 2.5e12), Limits(), "beyond the bound of 2 GB; .* '3 TB'$"),
        (Cost(0.5, 0.0), Limits(0.1, 1.0), "beyond the bound of 1 s; .* '1 s'$"),
        (Cost(100000.0, 0.0), Limits(), "'2 d'$"),
    ],
)
def test_a_request_beyond_its_bounds_names_those_that_would_do(cost, limits, words):
    with pytest.raises(InputError, match=words):
        refuse_cost(cost, limits)
    assert (
        refuse_cost(cost, Limits(1e9, 1e15))
        == f"about {duration_text(cost.seconds)} and {memory_text(cost.bytes)}"
    )


def test_a_request_at_its_bounds_passes():
    assert refuse_cost(Cost(600.0, 2e9), Limits()) == "about 10 min and 2 GB"
    with pytest.raises(InputError, match="limit='11 min'"):
        refuse_cost(Cost(601.0, 2e9), Limits(), "limit=")
