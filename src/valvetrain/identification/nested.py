"""Nested sampling: evidence and posterior, several branches included.

Sources: J. Skilling, Bayesian Analysis 1 (2006) 833; F. Feroz, M. Hobson and M. Bridges, Monthly
Notices of the Royal Astronomical Society
398 (2009) 1601 for the bounding ellipsoids; the library dynesty (J. Speagle, the same 493 (2020)
3132).
"""

from __future__ import annotations

import warnings
from contextlib import redirect_stdout
from io import StringIO

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.identification.draws import Draws, Report, extra, quietly, silent
from valvetrain.identification.lockstep import Lockstep
from valvetrain.identification.posterior import Posterior
from valvetrain.studies.stopping import Stopped

Array = NDArray[np.float64]
#: Live points, points asked for at once, and what of the logarithm of the evidence may be left in
#: the live points at the end.
LIVE_POINTS, LANES, PRECISION = 400, 16, 0.1
#: Draws with less than this share of the largest weight tell nothing.
NO_WEIGHT = 1e-8


def nested(
    posterior: Posterior,
    *,
    seed: int = 1,
    live_points: int = LIVE_POINTS,
    lanes: int = LANES,
    precision: float = PRECISION,
    report: Report = silent,
) -> Draws:
    """Weighted draws of the posterior and the logarithm of its evidence, by :data:`LIVE_POINTS`
    live points.

    ``lanes``: points asked for at once; another number is another (equally good) sequence of
    points. Raises :class:`InputError` where no
    point of the prior can be computed, :class:`MissingExtraError` without the library.
    """
    try:
        import dynesty
    except ImportError as error:
        raise extra("dynesty") from error

    def log_likelihoods(shares: Array) -> Array:
        return posterior.at(posterior.from_shares(np.clip(shares, 0.0, 1.0))).log_likelihood

    pool, count = Lockstep(log_likelihoods, lanes), len(posterior.unknowns)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            with redirect_stdout(
                StringIO()
            ):  # it prints where it is interrupted; that stream belongs to the answer
                sampler = dynesty.NestedSampler(
                    pool.ask,
                    _same,
                    count,
                    nlive=max(live_points, 2 * count + 2),
                    pool=pool,
                    queue_size=lanes,
                    rstate=np.random.default_rng(seed),
                    use_pool={"prior_transform": False, "update_bound": False},
                )
        except RuntimeError as error:
            raise InputError(
                "no point of the priors can be computed or meets the data; widen the priors or check the measurements"
            ) from error
        whole = True
        try:
            left = np.inf
            for one in quietly(sampler.sample(dlogz=precision)):
                if one.delta_logz < left:
                    left = float(one.delta_logz)
                    report(
                        float(np.clip(1.0 - np.log1p(left) / np.log1p(50.0), 0.0, 0.99)),
                        f"{left:.2f} of the log evidence left",
                    )
            for _ in quietly(sampler.add_live_points()):
                pass
        except Stopped:
            whole = False
            if not len(sampler.saved_run["logl"]):
                raise
        found = sampler.results
    log_weights = np.asarray(found.logwt) - np.max(found.logwt)
    weights = np.exp(log_weights)
    kept = weights > NO_WEIGHT
    evidence, doubt = float(found.logz[-1]), float(found.logzerr[-1])
    return Draws(
        posterior.from_shares(np.asarray(found.samples_u)[kept]),
        weights[kept] / weights[kept].sum(),
        evidence,
        doubt,
        "nested sampling",
        whole,
    )


def _same(shares: Array) -> Array:
    return np.asarray(shares)
