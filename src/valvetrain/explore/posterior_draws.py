"""A posterior as the points of a study: draws that an identification stored, correlated as it found
them.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from valvetrain.errors import InputError
from valvetrain.explore.draws import even_draws
from valvetrain.explore.identified import QUANTITY
from valvetrain.explore.samplers import CountedOptions, SamplerOptions, SamplerSpec
from valvetrain.explore.space import Space, Varied
from valvetrain.parameters.changes import nearest
from valvetrain.solution.atomic import checked_content
from valvetrain.solution.netcdf import dataset_of

Array = NDArray[np.float64]
_NO_DRAWS = "holds no draws of an identification; give draws.nc of its folder"


class PosteriorOptions(CountedOptions):
    """Options of the draws of a posterior."""

    file: str = Field(default="", description="draws.nc of an identification")


def _first_posterior(varied: Sequence[Varied], options: SamplerOptions) -> Array:
    """Draws (count, d) in SI of equal weight, every quantity by its label or name."""
    assert isinstance(options, PosteriorOptions)
    if isinstance(varied, Space) and varied.correlation is not None:
        raise InputError(
            "the draws of a posterior are correlated as they are; leave correlation out", "points"
        )
    columns, weights = read_draws(Path(options.file))
    chosen = []
    for one in varied:
        name = next((name for name in (one.label, one.name) if name in columns), None)
        if name is None:
            raise InputError(
                f"the draws have no '{one.shown_name[:60]}'; {nearest(one.shown_name, tuple(columns))}",
                "points.file",
            )
        chosen.append(columns[name])
    places, counts = even_draws(weights / weights.sum(), options.count, options.seed)
    return np.repeat(np.column_stack(chosen)[places], counts, axis=0)


def read_draws(path: Path) -> tuple[dict[str, Array], Array]:
    """Values (SI) by quantity and weights of a file of draws. Raises :class:`InputError` for another
    file, or one whose bytes are not those that were written.
    """
    if not checked_content(path)[1]:
        raise InputError(_NO_DRAWS, str(path))
    dataset = dataset_of(path)
    columns = {
        str(one.attrs["long_name"]): np.asarray(one.values, dtype=float)
        for one in dataset.data_vars.values()
        if one.attrs.get("role") == QUANTITY
    }
    if not columns or "weight" not in dataset:
        raise InputError(_NO_DRAWS, str(path))
    return columns, np.asarray(dataset["weight"].values, dtype=float)


POSTERIOR_SPEC = SamplerSpec(
    "posterior",
    "draws of a posterior",
    PosteriorOptions,
    _first_posterior,
    independent=True,
)
