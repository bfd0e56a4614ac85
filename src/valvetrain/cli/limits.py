"""Large requests: what they will cost is said before they begin, and beyond a bound they are
refused with the numbers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvetrain.cli.outcome import tell

if TYPE_CHECKING:
    from valvetrain.cli.study_command import StudyRequest
    from valvetrain.runs.cost import Cost, Limits

#: Estimates above this are printed (s).
WORTH_SAYING = 20.0


def refuse_beyond(request: StudyRequest, whole: bool = True, searches: bool = False) -> None:
    """Say what the request will cost where it takes a while; raise :class:`InputError` with the
    numbers where it is too large.

    ``whole``: whether every run is saved with its channels; ``searches``: whether a train's critical
    speeds are searched as well.
    """
    from valvetrain.runs.cost import FEWER
    from valvetrain.runs.request_cost import request_cost

    say_cost(request_cost(request, whole, searches), request.limits, FEWER)


def say_cost(cost: Cost, limits: Limits, fewer: str) -> None:
    """Say what a request will cost where it takes a while; raise :class:`InputError` with the
    numbers, and the advice to ask for
    ``fewer`` of what makes it large, where it lies beyond ``limits``."""
    from valvetrain.runs.cost import refuse_cost

    estimate = refuse_cost(cost, limits, fewer=fewer)
    if cost.seconds > WORTH_SAYING:
        tell(f"this will take {estimate}")
