"""What a test rig recorded: channels over time, as the file holds them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RigChannel:
    """One channel in the units of its file.

    Parameters
    ----------
    name : as the file calls it
    unit : as the file writes it, empty where it does not
    values : shape (samples,)
    start, step : s; time of the first sample and between samples; step 0 where the file tells no time
    times : s, shape (samples,), where they are stored one by one

    >>> RigChannel("Force 1", "N", np.zeros(100), step=1e-4)
    RigChannel 'Force 1' [N]: 100 samples, 10000 Hz
    """

    name: str
    unit: str
    values: Array
    start: float = 0.0
    step: float = 0.0
    times: Array | None = None

    def __repr__(self) -> str:
        rate = f"{1 / self.step:g} Hz" if self.step > 0 else "times of its own" if self.times is not None else "no times"
        return f"RigChannel '{self.name}' [{self.unit or 'no unit'}]: {len(self.values)} samples, {rate}"


@dataclass(frozen=True, eq=False)
class Recording:
    """All channels of a file.

    Parameters
    ----------
    form : words for the format
    channels : in the order of the file
    scalars : single numbers by name, such as a sampling rate
    synthetic : the file says that it was computed
    notes : what was left out and why, a sentence each

    >>> Recording("text", (RigChannel("a", "N", np.zeros(9)),)).names
    ('a',)
    """

    form: str
    channels: tuple[RigChannel, ...]
    scalars: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    synthetic: bool = False
    notes: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the channels."""
        return tuple(channel.name for channel in self.channels)


class Budget:
    """What a reader may still take: samples and channels of one file are bounded before anything of them is made."""

    #: Most samples of one recording that are read at once, most channels.
    SAMPLES, CHANNELS = 60_000_000, 2_000

    def __init__(self, name: str, wanted: tuple[str, ...] = ()) -> None:
        self.name, self.wanted = name, wanted
        self.samples = self.channels = 0

    def wants(self, channel: str) -> bool:
        """Whether a channel is read: all are where none is named."""
        return not self.wanted or channel in self.wanted

    def take(self, samples: int) -> None:
        """Count a channel of so many samples. Raises :class:`InputError` beyond the bounds."""
        self.samples, self.channels = self.samples + int(samples), self.channels + 1
        if self.channels > self.CHANNELS or not 0 <= self.samples <= self.SAMPLES:
            raise InputError(
                f"'{self.name[:80]}' claims more than {self.SAMPLES / 1e6:g} million samples or {self.CHANNELS} channels; cut the "
                "recording, or store the wanted channels alone"
            )


def evenly(times: Array, name: str) -> tuple[float, float, float]:
    """Start and step (s) of the even times nearest to ``times``, and how far those leave them at most (in steps).

    Raises :class:`InputError` where times do not rise.
    """
    steps = np.diff(times)
    if len(times) < 2 or not np.isfinite(times).all() or not (steps >= 0).all() or times[-1] <= times[0]:
        raise InputError(f"the times of '{name[:80]}' do not rise; correct them or leave them out and give the sampling rate")
    count = np.arange(len(times))
    step = float(times[-1] - times[0]) / (len(times) - 1)
    start = float(np.mean(times - step * count))
    return start, step, float(np.max(np.abs(times - start - step * count))) / step
