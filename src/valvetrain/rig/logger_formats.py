"""Reads recordings of data loggers: MDF 4 (and 3), TDMS and universal files 58.

Conversions of MDF by numbers are applied; formulas are not evaluated.
"""

from __future__ import annotations

import re
import tempfile
import warnings
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


#: Kinds of functions that are records over time: general, time response.
_OVER_TIME = (0, 1)


def recognise_uff58(head: bytes, file_name: str) -> bool:
    """Whether the first data set begins as universal files do: a line of -1, then the number of a
    data set.
    """
    first = rb"\s*-1\s*\r?\n\s*(?:58b?|151|164|15|18|55|82|1858|24\d\d)\b"
    return re.match(first, head) is not None


def read_uff58(path: Path, file_name: str) -> Recording:
    """Every function of time of the file."""
    try:
        import pyuff
    except ImportError as error:
        raise missing_library(file_name, "a universal file (UFF58)", "pyuff") from error
    budget, notes = Budget(file_name), []
    channels: list[RigChannel] = []
    descriptions: list[str] = []
    size = path.stat().st_size
    with path.open("rb") as stream:
        stream.seek(max(0, size - 200))
        if stream.read().split()[-1:] != [b"-1"]:
            raise InputError(
                f"'{file_name[:80]}' was cut short: its last data set has no end; export it again"
            )
    with warnings.catch_warnings(action="ignore"):
        file = pyuff.UFF(str(path))
        for index, kind in enumerate(file.get_set_types()):
            if int(kind) != 58:
                continue
            count = int(file.read_sets(index, header_only=True).get("num_pts", 0))
            if not 0 <= count <= size:
                raise InputError(
                    f"'{file_name[:80]}' is damaged: data set {index + 1} claims more samples than it has bytes"
                )
            content = file.read_sets(index)
            descriptions += [str(content.get(f"id{line}", "")) for line in range(1, 6)]
            if content.get("data") is not None and len(content["data"]) != count:
                raise InputError(
                    f"'{file_name[:80]}' was cut short: data set {index + 1} holds fewer samples than it claims"
                )
            channel = _uff_channel(content, index, budget)
            if channel is None:
                notes.append(
                    f"data set {index + 1} is left out: it is no row of real numbers over time"
                )
            else:
                channels.append(channel)
    return Recording(
        "universal file 58",
        tuple(channels),
        synthetic=says_synthetic(*descriptions),
        notes=tuple(notes),
    )


def _uff_channel(content: dict[str, Any], index: int, budget: Budget) -> RigChannel | None:
    values = np.asarray(content["data"])
    over_time = int(content.get("func_type", 0)) in _OVER_TIME
    if not over_time or values.dtype.kind != "f" or values.ndim != 1:
        return None
    budget.take(len(values))
    name, unit = (
        "" if label.upper() == "NONE" else label
        for label in (
            one_line(content.get("ordinate_axis_lab", "")),
            one_line(content.get("ordinate_axis_units_lab", "")),
        )
    )
    times = np.asarray(content["x"], dtype=float)
    even = int(content.get("abscissa_spacing", 1)) == 1
    step = float(content.get("abscissa_inc", 0.0))
    return RigChannel(
        name or one_line(content.get("id1", "")) or f"data set {index + 1}",
        unit,
        values.astype(float),
        float(content.get("abscissa_min", 0.0)),
        step if even and step > 0 else 0.0,
        None if even or len(times) != len(values) else times,
    )


UFF58_SPEC = RigFormat("universal file 58", recognise_uff58, read_uff58)
