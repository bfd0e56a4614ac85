"""How an identification is searched: the options of all methods, and the number of points each will
compute.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Literal, get_args

from valvetrain.errors import InputError
from valvetrain.identification.ensemble import STEPS
from valvetrain.identification.evolution import EVALUATIONS
from valvetrain.identification.nested import LANES, LIVE_POINTS, PRECISION
from valvetrain.identification.profiles import SIDE

Method = Literal["least-squares", "cma-es", "nested", "ensemble"]
METHODS: tuple[str, ...] = get_args(Method)
#: Options that take a number of zero or more; all other numbers are positive.
_FROM_ZERO = {"seed", "draws", "population", "walkers", "difference_step", "keep"}
#: Most of anything that is counted.
_MOST = 10_000_000


@dataclass(frozen=True)
class Search:
    """Method and its options; those of other methods have no effect.

    ``seed`` of all random numbers. Searches for a point (``least-squares``, ``cma-es``): ``starts``
    tried, of which the ``keep`` likeliest
    are searched from (0: none but those that are given) for at most ``iterations`` (least squares)
    or ``evaluations`` each in generations
    of ``population`` (cma-es; 0: by the number of quantities); ``difference_step`` in standard
    deviations of the priors (0: follows what
    the data leave open); ``draws`` of the linearised posterior. ``nested``: ``live_points``,
    ``lanes`` asked for at once, ``precision`` of
    the log evidence. ``ensemble``: ``walkers`` (0: by the number of quantities), ``steps``. Raises
    :class:`InputError` for an unknown
    method or a number out of range.

    >>> Search("nested", live_points=200).evaluations_of(2) > 1000
    True
    """

    method: str = "least-squares"
    seed: int = 1
    starts: int = 1
    keep: int = 1
    iterations: int = 30
    difference_step: float = 0.0
    draws: int = 200
    evaluations: int = EVALUATIONS
    population: int = 0
    live_points: int = LIVE_POINTS
    lanes: int = LANES
    precision: float = PRECISION
    walkers: int = 0
    steps: int = STEPS

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise InputError(
                f"method '{str(self.method)[:40]}' is unknown; use one of {', '.join(METHODS)}",
                "method",
            )
        for one in fields(self)[1:]:
            value = getattr(self, one.name)
            whole = one.name not in ("difference_step", "precision")
            if isinstance(value, bool) or not isinstance(value, int if whole else (int, float)):
                raise InputError(
                    f"{one.name} is a {'whole ' if whole else ''}number; it is {str(value)[:40]!r}",
                    one.name,
                )
            if not (0 if one.name in _FROM_ZERO else 1e-9) <= value <= _MOST:
                raise InputError(
                    f"{one.name} is {value:g}; give a number above zero and below {_MOST:g}",
                    one.name,
                )

    def evaluations_of(self, quantities: int, profiles: int = 0, given: int = 0) -> int:
        """About how many points will be computed for so many unknown quantities, profiles and
        ``given`` starts beside those of its own.
        """
        slopes, kept = quantities + 1, min(self.keep, self.starts) + given
        after = slopes + profiles * 2 * SIDE * 4 * (slopes + 4)
        if (
            self.method == "nested"
        ):  # 2.5 nats a quantity to shrink by; chains of some 20 + quantities moves from ten on
            return (
                int(
                    self.live_points
                    * (2.5 * quantities + 3)
                    * (3 + 2 * quantities if quantities < 10 else 20 + quantities)
                )
                // 2
                + after
            )
        if self.method == "ensemble":
            return (self.walkers or 4 * quantities + 8) * (self.steps + 2) + after
        each = (
            min(self.iterations, 8) * (slopes + 4)
            if self.method == "least-squares"
            else self.evaluations + 4 * (slopes + 4)
        )
        return (self.starts if self.keep else 0) + kept * each + self.draws + after
