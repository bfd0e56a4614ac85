"""Ensemble sampling: walkers that move along the differences of the others.

Sources: J. Goodman and J. Weare, Communications in Applied Mathematics and Computational Science 5
(2010) 65; C. ter Braak, Statistics and
Computing 16 (2006) 239 for the differential moves; the library emcee (D. Foreman-Mackey and others,
Publications of the Astronomical
Society of the Pacific 125 (2013) 306).
"""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.identification.draws import Draws, Report, extra, quietly, silent
from valvetrain.identification.posterior import Posterior
from valvetrain.studies.stopping import Stopped

Array = NDArray[np.float64]
STEPS = 1000
#: Share of the steps at the beginning that are left out, autocorrelation times that a chain should
#: hold, most draws that are kept.
BEGINNING, ENOUGH_TIMES, MOST_DRAWS = 0.4, 50, 4000
#: Rounds of draws from the prior in which starts that can be computed are looked for.
ROUNDS = 20


def ensemble(
    posterior: Posterior,
    *,
    seed: int = 1,
    walkers: int = 0,
    steps: int = STEPS,
    around: Array | None = None,
    report: Report = silent,
) -> Draws:
    """Equally weighted draws of the posterior by ``walkers`` (four a quantity by default, half of
    them moved at once) over ``steps``.

    ``around`` (n, quantities): working coordinates the walkers begin at, of a search before; by
    default draws of the prior. Walkers seldom
    pass between separate branches: :func:`nested` weighs those. Raises :class:`InputError` where
    too few starts can be computed,
    :class:`MissingExtraError` without the library.
    """
    try:
        import emcee
    except ImportError as error:
        raise extra("emcee") from error
    count = len(posterior.unknowns)
    number = max(walkers or 4 * count + 8, 2 * count + 2)
    begin = _starts(posterior, number, np.random.default_rng(seed), around)

    def log_posteriors(work: Array) -> Array:
        return posterior.at(work).log_posterior

    moves = [
        (emcee.moves.DEMove(), 0.6),
        (emcee.moves.DESnookerMove(), 0.1),
        (emcee.moves.StretchMove(), 0.3),
    ]
    sampler = emcee.EnsembleSampler(number, count, log_posteriors, moves=moves, vectorize=True)
    sampler.random_state = np.random.RandomState(
        seed
    ).get_state()  # the library knows the old kind of generator only
    done, whole = 0, True
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            for done, _ in enumerate(quietly(sampler.sample(begin, iterations=steps)), start=1):
                report(done / steps, f"step {done} of {steps}")
        except Stopped:
            whole = False
            if done < 10:
                raise
        time = float(np.max(sampler.get_autocorr_time(tol=0)))
    chain = sampler.get_chain(discard=int(BEGINNING * done))
    thin = max(1, -(-chain.shape[0] * number // MOST_DRAWS))
    work = chain[::thin].reshape(-1, count)
    notes = []
    if not np.isfinite(time) or (1 - BEGINNING) * done < ENOUGH_TIMES * time:
        told = f"{(1 - BEGINNING) * done / time:.0f}" if np.isfinite(time) and time > 0 else "few"
        notes.append(
            f"the chain holds {told} autocorrelation times, {ENOUGH_TIMES} are wanted; take more steps"
        )
    return Draws(work, np.full(len(work), 1.0 / len(work)), whole=whole, notes=tuple(notes))


def _starts(
    posterior: Posterior, number: int, random: np.random.Generator, around: Array | None
) -> Array:
    """``number`` different points that can be computed, the likeliest of twice as many draws."""
    found, scores = np.zeros((0, len(posterior.unknowns))), np.zeros(0)
    low, high = posterior.bounds
    for _ in range(ROUNDS):
        if around is None:
            tried = posterior.from_shares(random.random((2 * number, len(posterior.unknowns))))
        else:
            near = around[random.integers(len(around), size=2 * number)]
            tried = np.clip(
                near + 0.02 * posterior.spread * random.standard_normal(near.shape), low, high
            )
        at = posterior.at(tried).log_posterior
        found, scores = (
            np.vstack([found, tried[np.isfinite(at)]]),
            np.append(scores, at[np.isfinite(at)]),
        )
        if len(found) >= number:
            return found[np.argsort(-scores, kind="stable")[:number]]
    raise InputError(
        f"{len(found)} of {ROUNDS * 2 * number} draws of the priors can be computed; narrow the priors to what is possible"
    )
