"""Recordings read in a process of its own: bytes that upset the library of a format cannot take the caller with them."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.measurements.recording import Recording, RigChannel
from valvetrain.measurements.rig_formats.contract import HEAD, RigFormat
from valvetrain.solution.read_apart import apart_environment, bound_process, no_interpreter

#: Bytes of memory and seconds (of the processor, of the clock) that reading one file may take.
MOST_MEMORY, MOST_SECONDS, LONGEST_WAIT = 4_000_000_000, 120, 300
#: Larger files are not opened.
MOST_BYTES = 4_000_000_000


def read_recording(path: Path, wanted: tuple[str, ...] = ()) -> Recording:
    """The channels of a recording, in whatever registered form it is.

    Parameters: ``path`` of the file, ``wanted`` names of channels (all where empty). Raises :class:`InputError` for a file that is
    missing, empty, special, of no known form, damaged or too large.
    """
    name = path.name[:80] or str(path)[:80]
    form = form_of(path, name)
    found: RigFormat = registry.find("rig_formats", form)
    recording = _apart(path, name, form, wanted) if found.apart else found.read(path, name, wanted)
    if not recording.channels:
        why = f" ({recording.notes[0]})" if recording.notes else ""
        which = f" called {', '.join(wanted)[:80]}" if wanted else " of numbers over time"
        raise InputError(f"'{name}' ({found.words}) holds no channel{which}{why}; look at it with its own program")
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
        raise InputError(f"recording '{name}' cannot be read: {reason.lower()}; check the name and the folder") from error
    if size > MOST_BYTES:
        raise InputError(f"'{name}' is larger than {MOST_BYTES / 1e9:g} GB; cut the recording")
    if not head.strip():
        raise InputError(f"'{name}' is empty; export the recording again")
    known = registry.words("rig_formats")
    form = next((word for word in known if registry.find("rig_formats", word).recognise(head, name)), None)
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
            done = subprocess.run(command, input=asked, text=True, capture_output=True, timeout=LONGEST_WAIT, env=environment, check=False)
        except subprocess.TimeoutExpired as error:
            raise InputError(f"'{name}' was not read within {LONGEST_WAIT} s; it is damaged or too long, so cut it") from error
        except (OSError, TypeError) as error:
            raise InputError(f"'{name}' is not read, for recordings are read in a process of their own, and {no_interpreter()}") from error
        answer = Path(folder, "answer.json")
        if done.returncode or not answer.is_file():
            words: RigFormat = registry.find("rig_formats", form)
            raise InputError(f"'{name}' cannot be read as {words.words}: it is damaged, was cut short, or is too large; export it again")
        return _taken(json.loads(answer.read_text(encoding="utf-8")), Path(folder))


def _taken(answer: dict[str, Any], folder: Path) -> Recording:
    if "error" in answer:
        raise InputError(answer["error"])
    arrays = [np.load(folder / f"{place}.npy", allow_pickle=False) for place in range(answer["arrays"])]
    channels = tuple(
        RigChannel(
            one["name"], one["unit"], arrays[one["values"]], one["start"], one["step"],
            None if one["times"] is None else arrays[one["times"]],
        )
        for one in answer["channels"]
    )  # fmt: skip
    return Recording(answer["form"], channels, answer["scalars"], answer["synthetic"], tuple(answer["notes"]))


def serve() -> None:
    """Read what standard input asks for and put it into the folder named by the first argument: the other side of this module."""
    bound_process(MOST_MEMORY, MOST_SECONDS)
    asked, folder = json.loads(sys.stdin.read()), Path(sys.argv[1])
    answer = answered(Path(asked["path"]), asked["name"], asked["form"], tuple(asked["wanted"]), folder)
    Path(folder, "answer.json").write_text(json.dumps(answer), encoding="utf-8")


def answered(path: Path, name: str, form: str, wanted: tuple[str, ...], folder: Path) -> dict[str, Any]:
    """The channels of a file: numbers as arrays in ``folder``, all else in the answer, which is an error in one sentence at worst."""
    reader: RigFormat = registry.find("rig_formats", form)
    try:
        found = reader.read(path, name, wanted)
    except InputError as error:
        return {"error": str(error)}
    except MemoryError:
        return {"error": f"'{name}' claims more than the memory that reading may take; it is damaged, or cut it"}
    except (Exception, RecursionError) as error:  # each library raises kinds of its own for bytes that make no sense to it
        hint = "it is damaged or was cut short" if not isinstance(error, NotImplementedError) else "it is of a kind that is not read"
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
            "name": one.name, "unit": one.unit, "start": one.start, "step": one.step, "values": place_of(one.values),
            "times": place_of(one.times),
        }
        for one in found.channels
    ]  # fmt: skip
    for place, values in enumerate(arrays):
        np.save(Path(folder, f"{place}.npy"), np.asarray(values, dtype=float), allow_pickle=False)
    return {
        "form": found.form, "channels": channels, "scalars": dict(found.scalars), "synthetic": found.synthetic, "notes": list(found.notes),
        "arrays": len(arrays),
    }  # fmt: skip
