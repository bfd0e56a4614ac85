"""Ensemble sampling: walkers that move along the differences of the others.

Sources: J. Goodman and J. Weare, Communications in Applied Mathematics and Computational Science 5
(2010) 65; C. ter Braak, Statistics and
Computing 16 (2006) 239 for the differential moves; the library emcee (D. Foreman-Mackey and others,
Publications of the Astronomical
Society of the Pacific 125 (2013) 306).
"""

from __future__ import annotations

import threading
import warnings
from collections.abc import Callable, Iterable
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.explore.draws import Draws, Report, extra, quietly, silent
from valvetrain.explore.posterior import Posterior
from valvetrain.runs.stopping import Stopped

Array = NDArray[np.float64]
STEPS = 1000
#: Share of the steps at the beginning that are left out, autocorrelation times that a chain should
#: hold, most draws that are stored.
BEGINNING, ENOUGH_TIMES, MAX_DRAWS = 0.4, 50, 4000
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
    thin = max(1, -(-chain.shape[0] * number // MAX_DRAWS))
    work = chain[::thin].reshape(-1, count)
    notes = []
    if not np.isfinite(time) or (1 - BEGINNING) * done < ENOUGH_TIMES * time:
        reported = (
            f"{(1 - BEGINNING) * done / time:.0f}" if np.isfinite(time) and time > 0 else "few"
        )
        notes.append(
            f"the chain holds {reported} autocorrelation times, {ENOUGH_TIMES} are needed; take more steps"
        )
    return Draws(
        work, np.full(len(work), 1.0 / len(work)), whole=whole, notes=tuple(notes), chains=number
    )


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


#: Score of an impossible point above the worst possible one of its generation.
WORSE = 1e6
EVALUATIONS, FIRST_SPREAD = 2000, 0.5


def evolution(
    posterior: Posterior,
    begin: Array,
    *,
    seed: int = 1,
    evaluations: int = EVALUATIONS,
    population: int = 0,
    report: Report = silent,
) -> tuple[Array, bool]:
    """The best point found from ``begin`` (working coordinates) and whether it converged or ended
    at ``evaluations``, not by a stop.

    ``population``: points of a generation, all computed at once. Raises :class:`MissingExtraError`
    without the library.
    """
    try:
        import cmaes
    except ImportError as error:
        raise extra("cmaes") from error
    low, high = posterior.bounds
    box = np.column_stack(
        [(low - posterior.centre) / posterior.spread, (high - posterior.centre) / posterior.spread]
    )
    start = np.clip((begin - posterior.centre) / posterior.spread, box[:, 0], box[:, 1])
    count = len(start)
    size = population or 4 + int(3 * np.log(count)) + count % 2
    if (
        count == 1
    ):  # the library's strategy knows two quantities or more; the second one of these has no effect
        box, start = np.vstack([box, [-1.0, 1.0]]), np.append(start, 0.0)
    strategy = cmaes.CMA(
        mean=start, sigma=FIRST_SPREAD, bounds=box, seed=seed, population_size=size
    )
    best, least, used = begin, np.inf, 0
    try:
        first = float(posterior.at(np.clip(begin, low, high)[None, :]).log_posterior[0])
        least = (
            -first if np.isfinite(first) else np.inf
        )  # a search ends no worse than where it began
        while used < evaluations and not strategy.should_stop():
            requested = [strategy.ask() for _ in range(size)]
            work = np.clip(
                posterior.centre + posterior.spread * np.array(requested)[:, :count], low, high
            )
            scores = -posterior.at(work).log_posterior
            used += size
            possible = np.isfinite(scores)
            worst = float(scores[possible].max()) if possible.any() else 0.0
            strategy.tell(
                [
                    (one, float(score) if good else worst + WORSE)
                    for one, score, good in zip(requested, scores, possible, strict=True)
                ]
            )
            index = int(np.argmin(np.where(possible, scores, np.inf)))
            if possible[index] and scores[index] < least:
                best, least = work[index], float(scores[index])
            report(min(used / evaluations, 0.99), f"{used} evaluations, log posterior {-least:.3f}")
    except Stopped:
        return best, False
    return best, True


#: Longest time (s) that the chains of a map that was cut are waited for.
MAX_END = 20.0


class _Cut(BaseException):
    """Ends a chain whose result is no longer needed."""


class _Chain(threading.Thread):
    """One call of a function that requests points; ``question`` while it waits, ``answer`` once it
    is known.
    """

    def __init__(self, owner: Lockstep, function: Callable[[Any], Any], item: Any) -> None:
        super().__init__(daemon=True)
        self.owner, self.function, self.item = owner, function, item
        self.question: Array | None = None
        self.answer: float | None = None
        self.result: Any = None
        self.error: BaseException | None = None
        self.inside = self.ended = False

    def run(self) -> None:
        """Call the function, unless the map was cut before this thread came to it; see the base
        class.
        """
        with self.owner.turn:
            if self.owner.cut:
                return
            self.inside = True
        try:
            self.result = self.function(self.item)
        except _Cut:
            pass
        except BaseException as error:  # raised for the caller of map
            self.error = error
        with self.owner.turn:
            self.ended = True
            self.owner.turn.notify_all()


class Lockstep:
    """A pool as samplers need it (``map``) whose chains call :meth:`ask`; the ``answers`` to a
    batch of points are distributed in order.

    ``lanes``: chains at a time, which is also the size of a batch. The questions of a batch are
    in the order of the chains, so nothing
    depends on which thread was faster.
    """

    def __init__(self, answers: Callable[[Array], Array], lanes: int) -> None:
        self.answers, self.size = answers, lanes
        self.turn = threading.Condition()
        self.cut = False

    def ask(self, point: Array) -> float:
        """The answer to one point; waits for the batch when called from a chain."""
        chain = threading.current_thread()
        if not isinstance(chain, _Chain):
            return float(self.answers(np.asarray(point, dtype=float)[None, :])[0])
        with self.turn:
            chain.question, chain.answer = np.asarray(point, dtype=float), None
            self.turn.notify_all()
            while chain.answer is None and not self.cut:
                self.turn.wait()
            if chain.answer is None:
                raise _Cut
            return chain.answer

    def map(self, function: Callable[[Any], Any], items: Iterable[Any]) -> list[Any]:
        """``function`` of every item, :attr:`size` of them at a time. What a call raises is raised
        here.
        """
        left, results = list(items), []
        while left:
            chains = [_Chain(self, function, item) for item in left[: self.size]]
            del left[: self.size]
            try:
                for chain in chains:
                    chain.start()
                self._serve(chains)
            except BaseException:
                self._end(chains)
                raise
            for chain in chains:
                if chain.error is not None:
                    raise chain.error
                results.append(chain.result)
        return results

    def _end(self, chains: list[_Chain]) -> None:
        """End chains whose results are no longer needed, without the output of the sampler."""
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()), self.turn:
            self.cut = True
            self.turn.notify_all()
            # by flags of the chains themselves: a signal within a thread's start leaves it running,
            # yet not «alive»
            self.turn.wait_for(
                lambda: all(chain.ended or not chain.inside for chain in chains),
                timeout=MAX_END,
            )

    def _serve(self, chains: list[_Chain]) -> None:
        while True:
            with self.turn:
                while not all(chain.ended or chain.question is not None for chain in chains):
                    self.turn.wait()
                asking = [chain for chain in chains if not chain.ended]
            if not asking:
                return
            found = self.answers(np.array([chain.question for chain in asking]))
            with self.turn:
                for chain, value in zip(asking, found, strict=True):
                    chain.question, chain.answer = None, float(value)
                self.turn.notify_all()


#: Live points, points requested at once, and what of the logarithm of the evidence may be left in
#: the live points at the end.
LIVE_POINTS, LANES, PRECISION = 400, 16, 0.1
#: Draws with less than this share of the largest weight do not count.
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

    ``lanes``: points requested at once; another number is another (equally good) sequence of
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
    retained = weights > NO_WEIGHT
    evidence, doubt = float(found.logz[-1]), float(found.logzerr[-1])
    return Draws(
        posterior.from_shares(np.asarray(found.samples_u)[retained]),
        weights[retained] / weights[retained].sum(),
        evidence,
        doubt,
        "nested sampling",
        whole,
    )


def _same(shares: Array) -> Array:
    return np.asarray(shares)
