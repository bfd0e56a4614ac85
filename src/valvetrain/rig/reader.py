"""Reads recordings of a test rig: channels over time, in whatever registered form the file has.

Readers whose libraries are not made for damaged bytes are tried in a process of their own first.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

from valvetrain import registry
from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.parameters.bounded_file import file_head
from valvetrain.solution.read_apart import tried_apart

#: Seconds of the processor that reading one file may take, at least.
MAX_SECONDS = 60
#: Larger files are not opened.
MAX_BYTES = 4_000_000_000


@dataclass(frozen=True, eq=False)
class RigChannel:
    """One channel in the units of its file.

    Parameters
    ----------
    name : as the file calls it
    unit : as the file writes it, empty where it does not
    values : shape (samples,)
    start, step : s; time of the first sample and between samples; step 0 where the file gives no
        times
    times : s, shape (samples,), where they are stored one by one

    >>> import numpy as np
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
        rate = "no times" if self.times is None else "times of its own"
        rate = f"{1 / self.step:g} Hz" if self.step > 0 else rate
        return f"RigChannel '{self.name}' [{self.unit or 'no unit'}]: {len(self.values)} samples, {rate}"


@dataclass(frozen=True, eq=False)
class Recording:
    """All channels of a file.

    Parameters
    ----------
    form : label of the format
    channels : in the order of the file
    scalars : single numbers by name, such as a sampling rate
    synthetic : the file says that it was computed
    notes : what was left out and why, a sentence each

    >>> import numpy as np
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
    """Bounds on samples and channels of one file, checked before any array is allocated."""

    #: Samples of one recording that are read at once, and channels, at most.
    SAMPLES, CHANNELS = 60_000_000, 2_000

    def __init__(self, file_name: str) -> None:
        self.file_name = file_name
        self.samples = self.channels = 0

    def take(self, samples: int) -> None:
        """Count the samples of a channel. Raises :class:`InputError` beyond the bounds."""
        self.samples, self.channels = self.samples + int(samples), self.channels + 1
        if self.channels > self.CHANNELS or not 0 <= self.samples <= self.SAMPLES:
            raise InputError(
                f"'{self.file_name[:80]}' claims more than {self.SAMPLES / 1e6:g} million samples or {self.CHANNELS} channels; cut the "
                "recording, or store the needed channels alone"
            )


@dataclass(frozen=True, slots=True)
class RigFormat:
    """A form of recordings.

    ``recognise(head, file_name)`` examines the first bytes alone (the name is for messages).
    ``read(path, file_name)`` returns the channels. ``isolated``: tried in a process of its own, since
    the library behind it is not made for damaged bytes.
    """

    label: str
    recognise: Callable[[bytes, str], bool]
    read: Callable[[Path, str], Recording]
    isolated: bool = True


def missing_library(file_name: str, form: str, library: str) -> InputError:
    """The refusal of a file whose library is not installed."""
    extra = "install the extra 'measure' (pip install 'valvetrain[measure]')"
    return InputError(f"'{file_name[:80]}' is {form}, which needs {library}; {extra}")


def says_synthetic(*descriptions: object) -> bool:
    """Whether any of a file's descriptions says that it was computed."""
    return any("synthetic" in str(text).lower() for text in descriptions)


def one_line(value: object) -> str:
    """A name or description from a file as printable text of one line."""
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    return " ".join("".join(char if char.isprintable() else " " for char in text).split())[:120]


def read_recording(path: Path) -> Recording:
    """The channels of a recording, in whatever registered form it is.

    Raises :class:`InputError` for a file that is missing, empty, special, of no known form, damaged or too
    large.
    """
    name = path.name[:80] or str(path)[:80]
    reader = form_of(path, name)
    if reader.isolated:
        damaged = f"cannot be read as {reader.label}: it is damaged, was cut short or is of a kind that is not read; export it again"
        tried_apart(f"{__name__}:read_here", path, f"'{name}'", damaged, MAX_SECONDS)
    recording = read_here(path)
    if not recording.channels:
        why = f" ({recording.notes[0]})" if recording.notes else ""
        raise InputError(
            f"'{name}' ({reader.label}) holds no channel of numbers over time{why}; look at it with its own program"
        )
    return recording


def read_here(path: Path) -> Recording:
    """As :func:`read_recording`, untried: the library of the form may raise anything, crash or hang this process."""
    return form_of(path, path.name).read(path, path.name)


def form_of(path: Path, name: str) -> RigFormat:
    """The form that recognises the content."""
    _, head, size = file_head(path, "recording")
    if size > MAX_BYTES:
        raise InputError(f"'{name}' is larger than {MAX_BYTES / 1e9:g} GB; cut the recording")
    readers: list[RigFormat] = [
        registry.find("rig_formats", word) for word in registry.names("rig_formats")
    ]
    for reader in readers:
        if reader.recognise(head, name):
            return reader
    labels = ", ".join(reader.label for reader in readers)
    raise InputError(f"'{name}' is none of {labels}; export the recording in one of them")
