"""Contract of what computes the points of an identification in a package's own way."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class PointEvaluator:
    """What a package lists under ``valvetrain.evaluators``.

    ``points(names, options)``: for the unknown quantities of those names, a function of their
    values (SI) that returns numbers by name (SI), None for an impossible point; it pickles. Raises
    :class:`InputError` for a name or an option that is none. ``values(names)``: a start.

    >>> square = PointEvaluator(lambda names, options: lambda values: {"area": values[0] ** 2}, lambda names: (2.0,))
    >>> square.points(["side"], {})([3.0])
    {'area': 9.0}
    """

    points: Callable[
        [Sequence[str], Mapping[str, float]],
        Callable[[Sequence[float]], Mapping[str, float] | None],
    ]
    values: Callable[[Sequence[str]], tuple[float, ...]]
