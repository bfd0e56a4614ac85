"""What a test rig recorded: channels over time, as the file holds them."""

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


@dataclass(frozen=True, eq=False)
class RigChannel:
    """One channel in the units of its file.

    Parameters
    ----------
    name : as the file calls it
    unit : as the file writes it, empty where it does not
    values : shape (samples,)
    start, step : s; time of the first sample and between samples; step 0 where the file tells no
        time
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
        rate = (
            f"{1 / self.step:g} Hz"
            if self.step > 0
            else "times of its own"
            if self.times is not None
            else "no times"
        )
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
    """What a reader may still take: samples and channels of one file are bounded before anything of
    them is made.
    """

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
    """Start and step (s) of the even times nearest to ``times``, and how far those leave them at
    most (in steps).

    Raises :class:`InputError` where times do not rise.
    """
    steps = np.diff(times)
    if (
        len(times) < 2
        or not np.isfinite(times).all()
        or not (steps >= 0).all()
        or times[-1] <= times[0]
    ):
        raise InputError(
            f"the times of '{name[:80]}' do not rise; correct them or leave them out and give the sampling rate"
        )
    count = np.arange(len(times))
    step = float(times[-1] - times[0]) / (len(times) - 1)
    start = float(np.mean(times - step * count))
    return start, step, float(np.max(np.abs(times - start - step * count))) / step


#: Bytes of the beginning of a file by which its form is found.
HEAD = 4096
_EXTRA = "install the extra 'measure' (pip install 'valvetrain[measure]')"


@dataclass(frozen=True, slots=True)
class RigFormat:
    """A form of recordings.

    ``words``: what it is called. ``recognise(head, name)`` looks at the first bytes alone (the name is for messages). ``read(path, name,
    wanted)`` gives the channels called as in ``wanted``, all where it is empty. ``apart``: whether it is read in a process of its own,
    since the library behind it is not made for damaged bytes.
    """

    words: str
    recognise: Callable[[bytes, str], bool]
    read: Callable[[Path, str, tuple[str, ...]], Recording]
    apart: bool = True


def missing_library(name: str, form: str, library: str) -> InputError:
    """The refusal of a file whose library is not installed."""
    return InputError(f"'{name[:80]}' is {form}, which needs {library}; {_EXTRA}")


def says_synthetic(*words: object) -> bool:
    """Whether any of a file's descriptions says that it was computed."""
    return any("synthetic" in str(word).lower() for word in words)


def plain_word(value: object) -> str:
    """A word of a file as text of one line."""
    text = value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
    return " ".join("".join(char if char.isprintable() else " " for char in text).split())[:120]


#: Bytes of memory and seconds (of the processor, of the clock) that reading one file may take.
MAX_MEMORY, MAX_SECONDS, MAX_WAIT = 4_000_000_000, 120, 300
#: Larger files are not opened.
MAX_BYTES = 4_000_000_000


def read_recording(path: Path, wanted: tuple[str, ...] = ()) -> Recording:
    """The channels of a recording, in whatever registered form it is.

    Parameters: ``path`` of the file, ``wanted`` names of channels (all where empty). Raises
    :class:`InputError` for a file that is
    missing, empty, special, of no known form, damaged or too large.
    """
    name = path.name[:80] or str(path)[:80]
    form = form_of(path, name)
    found: RigFormat = registry.find("rig_formats", form)
    recording = _apart(path, name, form, wanted) if found.apart else found.read(path, name, wanted)
    if not recording.channels:
        why = f" ({recording.notes[0]})" if recording.notes else ""
        which = f" called {', '.join(wanted)[:80]}" if wanted else " of numbers over time"
        raise InputError(
            f"'{name}' ({found.words}) holds no channel{which}{why}; look at it with its own program"
        )
    return recording


def form_of(path: Path, name: str) -> str:
    """Word of the registered form whose mark the content bears."""
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
    known = registry.words("rig_formats")
    form = next(
        (word for word in known if registry.find("rig_formats", word).recognise(head, name)), None
    )
    if form is None:
        words = ", ".join(registry.find("rig_formats", word).words for word in known)
        raise InputError(f"'{name}' is none of {words}; export the recording in one of them")
    return form


def _apart(path: Path, name: str, form: str, wanted: tuple[str, ...]) -> Recording:
    asked = json.dumps({"path": str(path.absolute()), "name": name, "form": form, "wanted": wanted})
    environment = apart_environment()
    with tempfile.TemporaryDirectory(prefix="valvetrain.") as folder:
        # -P: a module that lies beside the recording is none of ours
        command = [sys.executable, "-P", "-c", f"from {__name__} import serve; serve()", folder]
        try:
            done = subprocess.run(
                command,
                input=asked,
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
        answer = Path(folder, "answer.json")
        if done.returncode or not answer.is_file():
            words: RigFormat = registry.find("rig_formats", form)
            raise InputError(
                f"'{name}' cannot be read as {words.words}: it is damaged, was cut short, or is too large; export it again"
            )
        return _taken(json.loads(answer.read_text(encoding="utf-8")), Path(folder))


def _taken(answer: dict[str, Any], folder: Path) -> Recording:
    if "error" in answer:
        raise InputError(answer["error"])
    arrays = [
        np.load(folder / f"{place}.npy", allow_pickle=False) for place in range(answer["arrays"])
    ]
    channels = tuple(
        RigChannel(
            one["name"],
            one["unit"],
            arrays[one["values"]],
            one["start"],
            one["step"],
            None if one["times"] is None else arrays[one["times"]],
        )
        for one in answer["channels"]
    )
    return Recording(
        answer["form"], channels, answer["scalars"], answer["synthetic"], tuple(answer["notes"])
    )


def serve() -> None:
    """Read what standard input asks for and put it into the folder named by the first argument: the
    other side of this module.
    """
    bound_process(MAX_MEMORY, MAX_SECONDS)
    asked, folder = json.loads(sys.stdin.read()), Path(sys.argv[1])
    answer = answered(
        Path(asked["path"]), asked["name"], asked["form"], tuple(asked["wanted"]), folder
    )
    Path(folder, "answer.json").write_text(json.dumps(answer), encoding="utf-8")


def answered(
    path: Path, name: str, form: str, wanted: tuple[str, ...], folder: Path
) -> dict[str, Any]:
    """The channels of a file: numbers as arrays in ``folder``, all else in the answer, which is an
    error in one sentence at worst.
    """
    reader: RigFormat = registry.find("rig_formats", form)
    try:
        found = reader.read(path, name, wanted)
    except InputError as error:
        return {"error": str(error)}
    except MemoryError:
        return {
            "error": f"'{name}' claims more than the memory that reading may take; it is damaged, or cut it"
        }
    except (
        Exception,
        RecursionError,
    ) as error:  # each library raises kinds of its own for bytes that make no sense to it
        hint = (
            "it is damaged or was cut short"
            if not isinstance(error, NotImplementedError)
            else "it is of a kind that is not read"
        )
        return {"error": f"'{name}' cannot be read as {reader.words}: {hint}; export it again"}
    arrays: list[Any] = []
    places: dict[int, int] = {}

    def place_of(values: Any) -> int | None:
        if values is None:
            return None
        if id(values) not in places:
            places[id(values)] = len(arrays)
            arrays.append(values)
        return places[id(values)]

    channels = [
        {
            "name": one.name,
            "unit": one.unit,
            "start": one.start,
            "step": one.step,
            "values": place_of(one.values),
            "times": place_of(one.times),
        }
        for one in found.channels
    ]
    for place, values in enumerate(arrays):
        np.save(Path(folder, f"{place}.npy"), np.asarray(values, dtype=float), allow_pickle=False)
    return {
        "form": found.form,
        "channels": channels,
        "scalars": dict(found.scalars),
        "synthetic": found.synthetic,
        "notes": list(found.notes),
        "arrays": len(arrays),
    }
