"""TDMS, the recordings of LabVIEW."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.measurements.recording import Budget, Recording, RigChannel
from valvetrain.measurements.rig_formats.contract import RigFormat, missing_library, plain_word, says_synthetic


def recognise(head: bytes, name: str) -> bool:
    """Whether the content begins with the mark of a segment."""
    return head.startswith(b"TDSm")


def read(path: Path, name: str, wanted: tuple[str, ...]) -> Recording:
    """Channels of numbers with the increments of their waveforms; an index file beside is not looked at."""
    try:
        from nptdms import TdmsFile
    except ImportError as error:
        raise missing_library(name, "TDMS", "npTDMS") from error
    budget, channels, notes = Budget(name, wanted), [], []
    size = path.stat().st_size
    with path.open("rb") as stream, TdmsFile(stream, read_metadata_only=True, keep_open=True) as file:
        if getattr(file.file_status, "incomplete_final_segment", False):
            notes.append("the last segment is not whole: the recording was cut short, and what is there was read")
        words = [str(value) for value in file.properties.values()]
        for group in file.groups():
            words += [str(value) for value in group.properties.values()]
            for channel in group.channels():
                if not budget.wants(plain_word(channel.name)):
                    continue
                if len(channel) > size:
                    raise InputError(
                        f"'{name[:80]}' is damaged: channel '{plain_word(channel.name)}' claims more samples than it has bytes"
                    )
                if channel.dtype.kind not in "fiu":
                    notes.append(f"channel '{plain_word(channel.name)}' is left out: it holds no numbers")
                    continue
                budget.take(len(channel))
                channels.append(_channel(channel))
    return Recording("TDMS", tuple(channels), synthetic=says_synthetic(*words), notes=tuple(notes))


def _channel(channel: Any) -> RigChannel:
    told = channel.properties
    step, start = (_number(told.get(key, 0.0)) for key in ("wf_increment", "wf_start_offset"))
    values = np.asarray(channel[:], dtype=float)
    return RigChannel(plain_word(channel.name), plain_word(told.get("unit_string", told.get("unit", ""))), values, start, max(step, 0.0))


def _number(value: Any) -> float:
    return float(value) if isinstance(value, (int, float, np.number)) and np.isfinite(value) else 0.0


SPEC = RigFormat("TDMS", recognise, read)
