"""Chains that ask for one point at a time, run side by side so that their questions become batches."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Longest time (s) that the chains of a map that was cut are waited for.
LONGEST_END = 20.0


class _Cut(BaseException):
    """Ends a chain nobody waits for any more."""


class _Chain(threading.Thread):
    """One call of a function that asks for points; ``question`` while it waits, ``answer`` once it
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
        except BaseException as error:  # handed to whoever called map
            self.error = error
        with self.owner.turn:
            self.ended = True
            self.owner.turn.notify_all()


class Lockstep:
    """A pool as samplers want it (``map``) whose chains ask :meth:`ask`; what ``answers`` told of a
    batch of points is handed out in order.

    ``lanes``: chains at a time, which is also the size of a batch. The questions of a batch stand
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
        """Let chains end that nobody waits for any more; what a sampler prints of that is nobody's
        concern.
        """
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()), self.turn:
            self.cut = True
            self.turn.notify_all()
            # asked of the chains themselves: a signal within a thread's start leaves it running,
            # yet not «alive»
            self.turn.wait_for(
                lambda: all(chain.ended or not chain.inside for chain in chains),
                timeout=LONGEST_END,
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
