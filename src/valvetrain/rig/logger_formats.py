"""MDF 4 (and 3), the recordings of measurement systems for vehicles; conversions are applied here,
formulas are not evaluated.
"""

from __future__ import annotations

import re
import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.errors import InputError
from valvetrain.rig.recording import (
    Budget,
    Recording,
    RigChannel,
    RigFormat,
    missing_library,
    plain_word,
    says_synthetic,
)


def recognise_mdf4(head: bytes, name: str) -> bool:
    """Whether the content begins as a finished or unfinished MDF file does."""
    return head.startswith((b"MDF     ", b"UnFinMF "))


def read_mdf4(path: Path, name: str, wanted: tuple[str, ...]) -> Recording:
    """Channels with the times of their group. Attachments and bus messages are left alone."""
    try:
        import asammdf
    except ImportError as error:
        raise missing_library(name, "MDF", "asammdf") from error
    budget, notes = Budget(name, wanted), []
    channels: list[RigChannel] = []
    with tempfile.TemporaryDirectory() as folder:
        options: dict[str, Any] = {"process_bus_logging": False, "temporary_folder": folder}
        file = asammdf.MDF(path, **options)
        try:
            for group in range(len(file.groups)):
                found, left = _group(file, group, budget)
                channels += found
                notes += left
            comment = getattr(file.header, "comment", "")
        finally:
            file.close()
    return Recording("MDF", tuple(channels), synthetic=says_synthetic(comment), notes=tuple(notes))


def _group(file: Any, group: int, budget: Budget) -> tuple[list[RigChannel], list[str]]:
    held = file.groups[group]
    cycles = int(held.channel_group.cycles_nr)
    master, notes = file.masters_db.get(group), []
    names = [
        (place, plain_word(channel.name))
        for place, channel in enumerate(held.channels)
        if place != master
    ]
    chosen = [(place, word) for place, word in names if budget.wants(word)]
    if not chosen or not cycles:
        return [], []
    if master is not None and _kind(held.channels[master].conversion) == FORMULA:
        return [], [
            f"{len(chosen)} channels beside '{chosen[0][1]}' are left out: the conversion of their times is {FORMULA}"
        ]
    budget.take(cycles)
    times = _numbers(file.get_master(group)) if master is not None else None
    channels = []
    for place, word in chosen:
        budget.take(cycles)
        signal = file.get(group=group, index=place, raw=True, ignore_invalidation_bits=True)
        values, left = _converted(_numbers(signal.samples), signal.conversion, word)
        if left:
            notes.append(left)
        if values is not None:
            unit = plain_word(getattr(signal.conversion, "unit", "") or signal.unit or "")
            channels.append(
                RigChannel(
                    word,
                    unit,
                    values,
                    times=times if times is not None and len(times) == len(values) else None,
                )
            )
    return channels, notes


def _numbers(samples: Any) -> np.ndarray[Any, Any] | None:
    """Samples as floats; None for what is no row of numbers."""
    return (
        np.asarray(samples, dtype=float)
        if samples.ndim == 1 and samples.dtype.kind in "fiub"
        else None
    )


def _converted(values: Any, conversion: Any, name: str) -> tuple[Any, str]:
    """Raw values in physical units by linear, rational and tabular conversions; a sentence where
    they are left out.
    """
    if values is None:
        return None, ""
    kind = _kind(conversion)
    if kind == "none":
        return values, ""
    if kind == "linear":
        return values * float(conversion.a) + float(conversion.b), ""
    if kind == "rational":
        one, two, three, four, five, six = (
            float(getattr(conversion, f"P{place}")) for place in range(1, 7)
        )
        with np.errstate(all="ignore"):
            return (one * values**2 + two * values + three) / (
                four * values**2 + five * values + six
            ), ""
    if kind in ("line", "table"):
        count = conversion.ref_param_nr if _older(conversion) else conversion.val_param_nr // 2
        raw = np.array([float(getattr(conversion, f"raw_{place}")) for place in range(count)])
        physical = np.array([float(getattr(conversion, f"phys_{place}")) for place in range(count)])
        if kind == "line":
            return np.interp(values, raw, physical), ""
        return physical[
            np.clip(np.searchsorted((raw[1:] + raw[:-1]) / 2, values), 0, count - 1)
        ], ""
    return (
        None,
        f"channel '{name}' is left out: its conversion is {kind}, and nothing in a file is evaluated; store converted values",
    )


def _older(conversion: Any) -> bool:
    return type(conversion).__module__.endswith("v2_v3_blocks")


def _kind(conversion: Any) -> str:
    """What a conversion does. Numbers of the kinds: ASAM MDF 4.1, CCBLOCK, and MDF 3.3, CCBLOCK,
    whose rational one runs backward.
    """
    if conversion is None:
        return "none"
    known = {65535: "none", 0: "linear", 1: "line", 2: "table"} if _older(conversion) else _KINDS
    return known.get(int(conversion.conversion_type), FORMULA)


#: Kinds that are not applied.
FORMULA = "a formula or words"
_KINDS = {0: "none", 1: "linear", 2: "rational", 4: "line", 5: "table"}
MDF4_SPEC = RigFormat("MDF", recognise_mdf4, read_mdf4)


def recognise_tdms(head: bytes, name: str) -> bool:
    """Whether the content begins with the mark of a segment."""
    return head.startswith(b"TDSm")


def read_tdms(path: Path, name: str, wanted: tuple[str, ...]) -> Recording:
    """Channels of numbers with the increments of their waveforms; an index file beside is not
    looked at.
    """
    try:
        from nptdms import TdmsFile
    except ImportError as error:
        raise missing_library(name, "TDMS", "npTDMS") from error
    budget, channels, notes = Budget(name, wanted), [], []
    size = path.stat().st_size
    with (
        path.open("rb") as stream,
        TdmsFile(stream, read_metadata_only=True, keep_open=True) as file,
    ):
        if getattr(file.file_status, "incomplete_final_segment", False):
            notes.append(
                "the last segment is not whole: the recording was cut short, and what is there was read"
            )
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
                    notes.append(
                        f"channel '{plain_word(channel.name)}' is left out: it holds no numbers"
                    )
                    continue
                budget.take(len(channel))
                channels.append(_channel(channel))
    return Recording("TDMS", tuple(channels), synthetic=says_synthetic(*words), notes=tuple(notes))


def _channel(channel: Any) -> RigChannel:
    told = channel.properties
    step, start = (_number(told.get(key, 0.0)) for key in ("wf_increment", "wf_start_offset"))
    values = np.asarray(channel[:], dtype=float)
    return RigChannel(
        plain_word(channel.name),
        plain_word(told.get("unit_string", told.get("unit", ""))),
        values,
        start,
        max(step, 0.0),
    )


def _number(value: Any) -> float:
    return (
        float(value) if isinstance(value, (int, float, np.number)) and np.isfinite(value) else 0.0
    )


TDMS_SPEC = RigFormat("TDMS", recognise_tdms, read_tdms)


#: Kinds of functions that are records over time: general, time response.
_OVER_TIME = (0, 1)


def recognise_uff58(head: bytes, name: str) -> bool:
    """Whether the first data set begins as universal files do: a line of -1, then the number of a
    data set.
    """
    return (
        re.match(rb"\s*-1\s*\r?\n\s*(?:58b?|151|164|15|18|55|82|1858|24\d\d)\b", head) is not None
    )


def read_uff58(path: Path, name: str, wanted: tuple[str, ...]) -> Recording:
    """Every function of time of the file."""
    try:
        import pyuff
    except ImportError as error:
        raise missing_library(name, "a universal file (UFF58)", "pyuff") from error
    budget, notes = Budget(name, wanted), []
    channels: list[RigChannel] = []
    words: list[str] = []
    size = path.stat().st_size
    with path.open("rb") as stream:
        stream.seek(max(0, size - 200))
        if stream.read().split()[-1:] != [b"-1"]:
            raise InputError(
                f"'{name[:80]}' was cut short: its last data set has no end; export it again"
            )
    with warnings.catch_warnings(action="ignore"):
        file = pyuff.UFF(str(path))
        for place, kind in enumerate(file.get_set_types()):
            if int(kind) != 58:
                continue
            header = file.read_sets(place, header_only=True)
            if not 0 <= int(header.get("num_pts", 0)) <= size:
                raise InputError(
                    f"'{name[:80]}' is damaged: data set {place + 1} claims more samples than it has bytes"
                )
            held = file.read_sets(place)
            words += [str(held.get(f"id{line}", "")) for line in range(1, 6)]
            if held.get("data") is not None and len(held["data"]) != int(header["num_pts"]):
                raise InputError(
                    f"'{name[:80]}' was cut short: data set {place + 1} holds fewer samples than it claims"
                )
            channel = _channel_uff58(held, place, budget)
            if channel is None:
                notes.append(
                    f"data set {place + 1} is left out: it is no row of real numbers over time"
                )
            elif budget.wants(channel.name):
                channels.append(channel)
    return Recording(
        "universal file 58", tuple(channels), synthetic=says_synthetic(*words), notes=tuple(notes)
    )


def _channel_uff58(held: dict[str, Any], place: int, budget: Budget) -> RigChannel | None:
    values = np.asarray(held["data"])
    if (
        int(held.get("func_type", 0)) not in _OVER_TIME
        or values.dtype.kind != "f"
        or values.ndim != 1
    ):
        return None
    budget.take(len(values))
    label = plain_word(held.get("ordinate_axis_lab", ""))
    name = (
        label
        if label and label.upper() != "NONE"
        else plain_word(held.get("id1", "")) or f"data set {place + 1}"
    )
    unit = plain_word(held.get("ordinate_axis_units_lab", ""))
    times = np.asarray(held["x"], dtype=float)
    even = int(held.get("abscissa_spacing", 1)) == 1
    step = float(held.get("abscissa_inc", 0.0))
    return RigChannel(
        name,
        "" if unit.upper() == "NONE" else unit,
        values.astype(float),
        float(held.get("abscissa_min", 0.0)),
        step if even and step > 0 else 0.0,
        None if even or len(times) != len(values) else times,
    )


UFF58_SPEC = RigFormat("universal file 58", recognise_uff58, read_uff58)
