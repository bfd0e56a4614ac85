"""Reads recordings of data loggers: MDF 4 (and 3) and TDMS.

Conversions of MDF by numbers are applied; formulas are not evaluated.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.rig.reader import (
    Budget,
    Recording,
    RigChannel,
    RigFormat,
    missing_library,
    one_line,
    says_synthetic,
)

#: Kinds of conversions by numbers alone: ASAM MDF 4.1 and MDF 3.3, CCBLOCK.
_BY_NUMBERS, _BY_NUMBERS_IN_MDF_3 = (0, 1, 2, 4, 5), (65535, 0, 1, 2)
_FORMULA = "a formula or words"


def recognise_mdf4(head: bytes, file_name: str) -> bool:
    """Whether the content begins as a finished or unfinished MDF file does."""
    return head.startswith((b"MDF     ", b"UnFinMF "))


def read_mdf4(path: Path, file_name: str) -> Recording:
    """Channels with the times of their group. Attachments and bus messages are left alone."""
    try:
        import asammdf
    except ImportError as error:
        raise missing_library(file_name, "MDF", "asammdf") from error
    budget, notes = Budget(file_name), []
    channels: list[RigChannel] = []
    with tempfile.TemporaryDirectory() as folder:
        options: dict[str, Any] = {"process_bus_logging": False, "temporary_folder": folder}
        file = asammdf.MDF(path, **options)
        try:
            for group in range(len(file.groups)):
                read, left_out = _mdf_group(file, group, budget)
                channels += read
                notes += left_out
            comment = getattr(file.header, "comment", "")
        finally:
            file.close()
    return Recording("MDF", tuple(channels), synthetic=says_synthetic(comment), notes=tuple(notes))


def _mdf_group(file: Any, group: int, budget: Budget) -> tuple[list[RigChannel], list[str]]:
    """Channels of one group, and a sentence on each that is left out."""
    blocks = file.groups[group]
    cycles = int(blocks.channel_group.cycles_nr)
    master = file.masters_db.get(group)
    names = [
        (index, one_line(channel.name))
        for index, channel in enumerate(blocks.channels)
        if index != master
    ]
    if not names or not cycles:
        return [], []
    times = None
    if master is not None and not _by_numbers(blocks.channels[master].conversion):
        return [], [
            f"{len(names)} channels, '{names[0][1]}' the first, are left out: the conversion of their times is {_FORMULA}"
        ]
    budget.take(cycles)
    if master is not None:
        times = _numbers(file.get_master(group))
    channels, notes = [], []
    for index, name in names:
        budget.take(cycles)
        signal = file.get(group=group, index=index, raw=True, ignore_invalidation_bits=True)
        raw, conversion = _numbers(signal.samples), signal.conversion
        if raw is None:
            continue
        if not _by_numbers(conversion):
            notes.append(
                f"channel '{name}' is left out: its conversion is {_FORMULA}, and nothing in a file is evaluated; store "
                "converted values"
            )
            continue
        values = raw if conversion is None else np.asarray(conversion.convert(raw))
        unit = one_line(getattr(conversion, "unit", "") or signal.unit or "")
        of_group = times if times is not None and len(times) == len(values) else None
        channels.append(RigChannel(name, unit, values, times=of_group))
    return channels, notes


def _numbers(samples: Any) -> np.ndarray[Any, Any] | None:
    """Samples as floats; None for what is no row of numbers."""
    numeric = samples.ndim == 1 and samples.dtype.kind in "fiub"
    return np.asarray(samples, dtype=float) if numeric else None


def _by_numbers(conversion: Any) -> bool:
    """Whether a conversion is one by numbers alone, in which nothing of the file is evaluated."""
    if conversion is None:
        return True
    older = type(conversion).__module__.endswith("v2_v3_blocks")
    return int(conversion.conversion_type) in (_BY_NUMBERS_IN_MDF_3 if older else _BY_NUMBERS)


MDF4_SPEC = RigFormat("MDF", recognise_mdf4, read_mdf4)


def recognise_tdms(head: bytes, file_name: str) -> bool:
    """Whether the content begins with the mark of a segment."""
    return head.startswith(b"TDSm")


def read_tdms(path: Path, file_name: str) -> Recording:
    """Channels of numbers with the increments of their waveforms; an index file next to it is not
    opened.
    """
    try:
        from nptdms import TdmsFile
    except ImportError as error:
        raise missing_library(file_name, "TDMS", "npTDMS") from error
    budget, channels, notes = Budget(file_name), [], []
    size = path.stat().st_size
    with (
        path.open("rb") as stream,
        TdmsFile(stream, read_metadata_only=True, keep_open=True) as file,
    ):
        if getattr(file.file_status, "incomplete_final_segment", False):
            notes.append(
                "the last segment is not whole: the recording was cut short, and what is there was read"
            )
        descriptions = [str(value) for value in file.properties.values()]
        for group in file.groups():
            descriptions += [str(value) for value in group.properties.values()]
            for channel in group.channels():
                name = one_line(channel.name)
                if len(channel) > size:
                    raise InputError(
                        f"'{file_name[:80]}' is damaged: channel '{name}' claims more samples than it has bytes"
                    )
                if channel.dtype.kind not in "fiu":
                    notes.append(f"channel '{name}' is left out: it holds no numbers")
                    continue
                budget.take(len(channel))
                channels.append(_tdms_channel(channel, name))
    synthetic = says_synthetic(*descriptions)
    return Recording("TDMS", tuple(channels), synthetic=synthetic, notes=tuple(notes))


def _tdms_channel(channel: Any, name: str) -> RigChannel:
    properties = channel.properties
    step, start = (
        float(value) if isinstance(value, (int, float, np.number)) and np.isfinite(value) else 0.0
        for value in (properties.get(key, 0.0) for key in ("wf_increment", "wf_start_offset"))
    )
    unit = one_line(properties.get("unit_string", properties.get("unit", "")))
    return RigChannel(name, unit, np.asarray(channel[:], dtype=float), start, max(step, 0.0))


TDMS_SPEC = RigFormat("TDMS", recognise_tdms, read_tdms)
