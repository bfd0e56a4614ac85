"""Reads recordings of a test rig: channels over time, in whatever registered form the file has.

Readers whose libraries are not made for damaged bytes run in a process of their own.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.solution.read_apart import apart_environment, bound_process, no_interpreter

Array = NDArray[np.float64]
#: Bytes at the beginning of a file by which its form is recognised.
HEAD = 4096
#: Bytes of memory and seconds (of the processor, of the clock) that reading one file may take.
MAX_MEMORY, MAX_SECONDS, MAX_WAIT = 4_000_000_000, 120, 300
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

    def __init__(self, file_name: str, selected: tuple[str, ...] = ()) -> None:
        self.file_name, self.selected = file_name, selected
        self.samples = self.channels = 0

    def selects(self, channel: str) -> bool:
        """Whether a channel is read: all are where none is named."""
        return not self.selected or channel in self.selected

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
    ``read(path, file_name, selected)`` returns the channels whose names are in ``selected``, all
    where it is empty. ``isolated``: read in a process of its own, since the library behind it is
    not made for damaged bytes.
    """

    label: str
    recognise: Callable[[bytes, str], bool]
    read: Callable[[Path, str, tuple[str, ...]], Recording]
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


def read_recording(path: Path, selected: tuple[str, ...] = ()) -> Recording:
    """The channels of a recording, in whatever registered form it is.

    Parameters: ``path`` of the file, ``selected`` names of channels (all where empty). Raises
    :class:`InputError` for a file that is missing, empty, special, of no known form, damaged or too
    large.
    """
    name = path.name[:80] or str(path)[:80]
    form = form_of(path, name)
    reader: RigFormat = registry.find("rig_formats", form)
    if reader.isolated:
        recording = _read_isolated(path, name, form, selected)
    else:
        recording = reader.read(path, name, selected)
    if not recording.channels:
        why = f" ({recording.notes[0]})" if recording.notes else ""
        which = f" called {', '.join(selected)[:80]}" if selected else " of numbers over time"
        raise InputError(
            f"'{name}' ({reader.label}) holds no channel{which}{why}; look at it with its own program"
        )
    return recording


def form_of(path: Path, name: str) -> str:
    """Registry name of the form that recognises the content."""
    try:
        if path.exists() and not path.is_file():
            raise InputError(f"'{name}' is no regular file; give the recording as a file")
        size = path.stat().st_size
        with path.open("rb") as stream:
            head = stream.read(HEAD)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", "") or "the name is no file name"
        raise InputError(
            f"recording '{name}' cannot be read: {reason.lower()}; check the name and the folder"
        ) from error
    if size > MAX_BYTES:
        raise InputError(f"'{name}' is larger than {MAX_BYTES / 1e9:g} GB; cut the recording")
    if not head.strip():
        raise InputError(f"'{name}' is empty; export the recording again")
    readers = {form: registry.find("rig_formats", form) for form in registry.names("rig_formats")}
    form = next((form for form, reader in readers.items() if reader.recognise(head, name)), None)
    if form is None:
        labels = ", ".join(reader.label for reader in readers.values())
        raise InputError(f"'{name}' is none of {labels}; export the recording in one of them")
    return form


def _read_isolated(path: Path, name: str, form: str, selected: tuple[str, ...]) -> Recording:
    """The recording, read by :func:`serve` in a process of its own."""
    request = {"path": str(path.absolute()), "name": name, "form": form, "selected": selected}
    environment = apart_environment()
    with tempfile.TemporaryDirectory(prefix="valvetrain.") as folder:
        # -P: a module in the folder of the recording is none of ours
        command = [sys.executable, "-P", "-c", f"from {__name__} import serve; serve()", folder]
        try:
            done = subprocess.run(
                command,
                input=json.dumps(request),
                text=True,
                capture_output=True,
                timeout=MAX_WAIT,
                env=environment,
                check=False,
            )
        except subprocess.TimeoutExpired as error:
            raise InputError(
                f"'{name}' was not read within {MAX_WAIT} s; it is damaged or too long, so cut it"
            ) from error
        except (OSError, TypeError) as error:
            raise InputError(
                f"'{name}' is not read, for recordings are read in a process of their own, and {no_interpreter()}"
            ) from error
        file = Path(folder, "answer.json")
        if done.returncode or not file.is_file():
            reader: RigFormat = registry.find("rig_formats", form)
            raise InputError(
                f"'{name}' cannot be read as {reader.label}: it is damaged, was cut short, or is too large; export it again"
            )
        answer = json.loads(file.read_text(encoding="utf-8"))
        if "error" in answer:
            raise InputError(answer["error"])
        arrays = [
            np.load(Path(folder, f"{index}.npy"), allow_pickle=False)
            for index in range(answer["arrays"])
        ]
    for one in answer["channels"]:
        one["values"] = arrays[one["values"]]
        one["times"] = None if one["times"] is None else arrays[one["times"]]
    channels = tuple(RigChannel(**one) for one in answer["channels"])
    return Recording(
        answer["form"], channels, answer["scalars"], answer["synthetic"], tuple(answer["notes"])
    )


def serve() -> None:
    """Read the file that standard input requests into the folder named by the first argument: the
    child's side of :func:`read_recording`.
    """
    bound_process(MAX_MEMORY, MAX_SECONDS)
    request, folder = json.loads(sys.stdin.read()), Path(sys.argv[1])
    selected = tuple(request["selected"])
    answer = read_into(folder, Path(request["path"]), request["name"], request["form"], selected)
    Path(folder, "answer.json").write_text(json.dumps(answer), encoding="utf-8")


def read_into(
    folder: Path, path: Path, name: str, form: str, selected: tuple[str, ...]
) -> dict[str, Any]:
    """The channels of a file for JSON, their numbers as arrays in ``folder``; an error as one
    sentence.
    """
    reader: RigFormat = registry.find("rig_formats", form)
    try:
        recording = reader.read(path, name, selected)
    except InputError as error:
        return {"error": str(error)}
    except MemoryError:
        return {
            "error": f"'{name}' claims more than the memory that reading may take; it is damaged, or cut it"
        }
    except Exception as error:  # each library raises its own kinds for bytes it cannot parse
        hint = "it is damaged or was cut short"
        hint = (
            "it is of a kind that is not read" if isinstance(error, NotImplementedError) else hint
        )
        return {"error": f"'{name}' cannot be read as {reader.label}: {hint}; export it again"}
    arrays = {
        id(values): values
        for one in recording.channels
        for values in (one.values, one.times)
        if values is not None
    }
    for index, values in enumerate(arrays.values()):
        np.save(Path(folder, f"{index}.npy"), np.asarray(values, dtype=float), allow_pickle=False)
    index_of = {key: index for index, key in enumerate(arrays)} | {id(None): None}
    channels = [
        vars(one) | {"values": index_of[id(one.values)], "times": index_of[id(one.times)]}
        for one in recording.channels
    ]
    return {
        "form": recording.form,
        "channels": channels,
        "scalars": dict(recording.scalars),
        "synthetic": recording.synthetic,
        "notes": list(recording.notes),
        "arrays": len(arrays),
    }
