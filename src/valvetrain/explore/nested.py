"""Weighted draws of a posterior and its evidence by nested sampling, of the library nautilus.

Source: J. Lange, Monthly Notices of the Royal Astronomical Society 525 (2023) 3181.
"""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.explore.draws import Draws, Report, branches_of_draws, extra, silent
from valvetrain.explore.identification_file import EFFECTIVE, Search
from valvetrain.explore.posterior import Posterior
from valvetrain.runs.stopping import Stopped

Array = NDArray[np.float64]
#: Draws with less than this share of the largest weight do not count.
NO_WEIGHT = 1e-8
#: Points of the prior of which one has to be possible.
TRIED = 2000
#: Log likelihood of an impossible point: below any other, and a number.
IMPOSSIBLE = -1e100


def nested(posterior: Posterior, search: Search, report: Report = silent) -> Draws:
    """Weighted draws of the posterior with their branches, and the logarithm of its evidence, which
    has no error bar.

    Another number of ``lanes`` of the search, points requested at once, is another (equally good) sequence of
    points. Raises :class:`InputError` where no point of the prior can be computed,
    :class:`MissingExtraError` without the library.
    """
    try:
        from nautilus import Sampler
    except ImportError as error:
        raise extra("nautilus-sampler") from error
    count = len(posterior.unknowns)
    expected = search.sampled(count)
    done = possible = 0

    def log_likelihoods(shares: Array) -> Array:
        nonlocal done, possible
        found = posterior.log_likelihood(
            posterior.from_shares(np.clip(shares[:, :count], 0.0, 1.0))
        )
        done, possible = done + len(found), possible + int(np.isfinite(found).sum())
        if not possible and done >= TRIED:
            raise InputError(
                "no point of the priors can be computed or meets the data; widen the priors or check the measurements"
            )
        report(min(done / expected, 0.99), f"{done} points")
        return np.maximum(found, IMPOSSIBLE)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        sampler = Sampler(
            np.asarray,
            log_likelihoods,
            n_dim=max(count, 2),  # it takes no single quantity: the second one has no effect
            n_live=max(search.live_points, 2 * count + 2),
            n_batch=search.lanes,
            n_networks=1,
            vectorized=True,
            pass_dict=False,
            seed=search.seed,
        )
        whole = True
        try:
            sampler.run(f_live=search.precision, n_eff=EFFECTIVE)
        except Stopped:
            whole = False
            if not possible:
                raise
            for shell in range(len(sampler.points)):  # the stop met one half updated
                sampler.update_shell_info(shell)
        shares, log_weights, _ = sampler.posterior()
    weights = np.exp(log_weights - np.max(log_weights))
    retained = weights > NO_WEIGHT
    work = posterior.from_shares(shares[retained, :count])
    weights = weights[retained] / weights[retained].sum()
    labels = np.zeros(len(work), dtype=np.int64)
    if whole:
        labels = branches_of_draws(posterior, work, weights, search.seed)
    return Draws(work, weights, labels, float(sampler.log_z), whole=whole)
