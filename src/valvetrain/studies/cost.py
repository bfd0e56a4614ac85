"""What a request will cost in time and memory, from plain numbers and before anything is built."""

from __future__ import annotations

from dataclasses import dataclass

#: Seconds around a run (states of rest, records, quantities), and bytes of a run kept without its channels.
RUN, REDUCED = 0.03, 40_000.0
#: Copies of a channel that stand side by side while a run is recorded, evaluated and written.
COPIES = 2.0


@dataclass(frozen=True, slots=True)
class Cost:
    """Estimated wall time (s) and memory (bytes)."""

    seconds: float = 0.0
    bytes: float = 0.0

    def __add__(self, other: Cost) -> Cost:
        return Cost(self.seconds + other.seconds, self.bytes + other.bytes)


def estimate(
    *, runs: int, simulated_time: float, processor_time: float, refinement: float = 1.0, own_time: float = 0.0, samples: float = 720.0,
    channels: float = 30.0,
    workers: int = 1, whole: bool = True,
) -> Cost:  # fmt: skip
    """Cost of ``runs`` runs that cover ``simulated_time`` (s) in all, by ``workers`` at a time.

    ``processor_time``: seconds of one core per simulated second with the model's default options; ``refinement``: unknowns over those of
    the default, which shorten the step alike, so time grows with their square. ``own_time``: the same of what is not the springs.
    ``samples`` instants of ``channels`` numbers each are recorded per run; of a run that is not kept ``whole`` they are there while it
    runs only.
    """
    at_a_time = max(1, min(workers, runs))
    seconds = (runs * RUN + simulated_time * (own_time + processor_time * refinement**2)) / at_a_time
    record = 8.0 * samples * channels
    return Cost(seconds, (runs * record if whole else runs * REDUCED) + COPIES * record * at_a_time)
