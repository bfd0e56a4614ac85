"""MDF 4 (and 3), the recordings of measurement systems for vehicles; conversions are applied here, formulas are not evaluated."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from valvetrain.measurements.recording import Budget, Recording, RigChannel
from valvetrain.measurements.rig_formats.contract import RigFormat, missing_library, plain_word, says_synthetic


def recognise(head: bytes, name: str) -> bool:
    """Whether the content begins as a finished or unfinished MDF file does."""
    return head.startswith((b"MDF     ", b"UnFinMF "))


def read(path: Path, name: str, wanted: tuple[str, ...]) -> Recording:
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
    names = [(place, plain_word(channel.name)) for place, channel in enumerate(held.channels) if place != master]
    chosen = [(place, word) for place, word in names if budget.wants(word)]
    if not chosen or not cycles:
        return [], []
    if master is not None and _kind(held.channels[master].conversion) == FORMULA:
        return [], [f"{len(chosen)} channels beside '{chosen[0][1]}' are left out: the conversion of their times is {FORMULA}"]
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
            channels.append(RigChannel(word, unit, values, times=times if times is not None and len(times) == len(values) else None))
    return channels, notes


def _numbers(samples: Any) -> np.ndarray[Any, Any] | None:
    """Samples as floats; None for what is no row of numbers."""
    return np.asarray(samples, dtype=float) if samples.ndim == 1 and samples.dtype.kind in "fiub" else None


def _converted(values: Any, conversion: Any, name: str) -> tuple[Any, str]:
    """Raw values in physical units by linear, rational and tabular conversions; a sentence where they are left out."""
    if values is None:
        return None, ""
    kind = _kind(conversion)
    if kind == "none":
        return values, ""
    if kind == "linear":
        return values * float(conversion.a) + float(conversion.b), ""
    if kind == "rational":
        one, two, three, four, five, six = (float(getattr(conversion, f"P{place}")) for place in range(1, 7))
        with np.errstate(all="ignore"):
            return (one * values**2 + two * values + three) / (four * values**2 + five * values + six), ""
    if kind in ("line", "table"):
        count = conversion.ref_param_nr if _older(conversion) else conversion.val_param_nr // 2
        raw = np.array([float(getattr(conversion, f"raw_{place}")) for place in range(count)])
        physical = np.array([float(getattr(conversion, f"phys_{place}")) for place in range(count)])
        if kind == "line":
            return np.interp(values, raw, physical), ""
        return physical[np.clip(np.searchsorted((raw[1:] + raw[:-1]) / 2, values), 0, count - 1)], ""
    return None, f"channel '{name}' is left out: its conversion is {kind}, and nothing in a file is evaluated; store converted values"


def _older(conversion: Any) -> bool:
    return type(conversion).__module__.endswith("v2_v3_blocks")


def _kind(conversion: Any) -> str:
    """What a conversion does. Numbers of the kinds: ASAM MDF 4.1, CCBLOCK, and MDF 3.3, CCBLOCK, whose rational one runs backward."""
    if conversion is None:
        return "none"
    known = {65535: "none", 0: "linear", 1: "line", 2: "table"} if _older(conversion) else _KINDS
    return known.get(int(conversion.conversion_type), FORMULA)


#: Kinds that are not applied.
FORMULA = "a formula or words"
_KINDS = {0: "none", 1: "linear", 2: "rational", 4: "line", 5: "table"}
SPEC = RigFormat("MDF", recognise, read)
