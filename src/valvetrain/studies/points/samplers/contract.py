"""What every sampler answers: where in the unit cube the first points of a study lie, and where the
next ones, once those are known.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from valvetrain.errors import InputError
from valvetrain.registry import find
from valvetrain.studies.points.varied import Varied

Array = NDArray[np.float64]
#: Points of a study beyond this number are taken for a mistake.
MOST_POINTS = 1_000_000
#: Places where nobody says otherwise.
COUNT, LEVELS = 100, 5


class SamplerOptions(BaseModel):
    """Options that a sampler takes; each declares its own."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class CountedOptions(SamplerOptions):
    """Options of samplers that draw a number of points."""

    count: int = Field(default=COUNT, ge=1, le=MOST_POINTS, description="points drawn")
    seed: int = Field(
        default=1,
        ge=0,
        le=2**31,
        description="seed of the random numbers; the same seed gives the same points",
    )


First = Callable[[Sequence[Varied], SamplerOptions], Array]
More = Callable[[Sequence[Varied], SamplerOptions, Array, Array], Array]


def no_more(
    varied: Sequence[Varied], options: SamplerOptions, points: Array, values: Array
) -> Array:
    """A sampler that knows all its points from the start."""
    return np.zeros((0, len(varied)))


@dataclass(frozen=True, slots=True)
class SamplerSpec:
    """A sampler: ``first`` gives points (n, d) in SI; ``more``, told all points and the first
    output of each (nan where it failed), those
    that follow, none at the end. ``independent``: its points are draws from the distributions, so
    that their percentiles mean something.
    """

    word: str
    words: str
    options: type[SamplerOptions]
    first: First
    more: More = no_more
    independent: bool = False

    def read_options(self, given: dict[str, object]) -> SamplerOptions:
        """Checked options. Raises :class:`InputError` for those that the sampler does not have."""
        from pydantic import ValidationError

        from valvetrain.parameters.changes import nearest

        known = tuple(self.options.model_fields)
        for key in given:
            if key not in known:
                raise InputError(
                    f"sampler {self.word} has no option '{key[:40]}'; {nearest(key, known)}",
                    f"points.{key[:40]}",
                )
        try:
            return self.options.model_validate(given)
        except ValidationError as error:
            first = error.errors(include_url=False)[0]
            place = ".".join(str(part) for part in first["loc"])
            raise InputError(
                f"{str(first['input'])[:40]!r} does not fit: {first['msg'][:1].lower()}{first['msg'][1:]}; correct it",
                f"points.{place}",
            ) from None


def sampler(word: str, where: str = "points.sampler") -> SamplerSpec:
    """The sampler behind a word of the registry. Raises :class:`InputError` for an unknown one."""
    found: SamplerSpec = find("samplers", word, where)
    return found


def spread(varied: Sequence[Varied], shares: Array) -> Array:
    """Points (n, d) in SI of shares (n, d) in the unit cube, each column by its distribution."""
    # half of the last bit off either end, where a distribution without bounds is infinite
    inside = np.clip(shares, 2.0**-53, 1 - 2.0**-53)
    return np.column_stack(
        [one.distribution.at(inside[:, place]) for place, one in enumerate(varied)]
    )
