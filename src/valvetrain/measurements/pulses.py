"""Edges of a pulse channel and the teeth they stand for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from valvetrain.errors import InputError

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
#: Share of the swing at which a pulse counts as down or up: noise between them makes no edges.
LOW, HIGH = 0.35, 0.65
#: Intervals whose median is the usual one; a shorter interval than this share of it is no tooth.
AROUND, TOO_SHORT = 11, 0.4


def rising_edges(values: Array, start: float, step: float, name: str) -> Array:
    """Times (s) at which a pulse channel rises through the middle of its swing, between samples by a straight line.

    Raises :class:`InputError` where the channel does not swing.
    """
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if not np.isfinite(high - low) or high - low <= 0:
        raise InputError(f"channel '{name[:80]}' holds no pulses: it never changes; name the channel of the pulses")
    share = (values - low) / (high - low)
    decided = np.where(share >= HIGH, 1, np.where(share <= LOW, 0, -1))
    known = np.flatnonzero(decided >= 0)
    state = decided[known]
    flips = known[1:][(state[1:] == 1) & (state[:-1] == 0)]
    crossing = np.flatnonzero((share[:-1] < 0.5) & (share[1:] >= 0.5))
    if not len(crossing) or not len(flips):
        raise InputError(f"channel '{name[:80]}' holds no pulses that rise; name the channel of the pulses")
    found = crossing[np.maximum(np.searchsorted(crossing, flips) - 1, 0)]
    part = (0.5 - share[found]) / (share[found + 1] - share[found])
    times: Array = start + (found + part) * step
    return times


@dataclass(frozen=True, eq=False)
class Teeth:
    """Edges with the tooth each stands for: ``times`` (s), ``numbers`` that rise by one a tooth, ``marks`` the numbers at a mark."""

    times: Array
    numbers: Numbers
    marks: Numbers
    notes: tuple[str, ...] = ()


def numbered(times: Array, teeth: int, missing: int, name: str) -> Teeth:
    """Number the edges of a wheel of ``teeth`` places of which ``missing`` side by side are cut away; the mark is the tooth behind the gap.

    Edges in between that are no teeth are left out, lost ones are counted, both are told. Raises :class:`InputError` where the gap does
    not come back after the teeth that were told.
    """
    if len(times) < 2 * AROUND:
        raise InputError(f"channel '{name[:80]}' holds {len(times)} pulses, too few for cycles; give a longer recording")
    notes = []
    usual = median_filter(np.diff(times), AROUND, mode="nearest")
    extra = np.flatnonzero(np.diff(times) < TOO_SHORT * usual) + 1
    if len(extra):
        notes.append(f"{len(extra)} pulses of '{name}' follow too soon to be teeth and were left out, the first at {times[extra[0]]:.6g} s")
        times = np.delete(times, extra)
        usual = median_filter(np.diff(times), AROUND, mode="nearest")
    steps = np.maximum(np.rint(np.diff(times) / usual).astype(np.int64), 1)
    numbers: Numbers = np.concatenate([[0], np.cumsum(steps)])
    gaps = np.flatnonzero(steps == missing + 1) + 1 if missing else np.zeros(0, dtype=np.int64)
    if missing:
        gaps = _of_the_wheel(numbers, gaps, teeth, missing, name)
    lost = np.flatnonzero((steps > 1) & ~np.isin(np.arange(1, len(times)), gaps))
    if not missing and len(lost) > 2 and len(set(np.diff(numbers[lost + 1]).tolist())) == 1:
        every, gone = int(np.diff(numbers[lost + 1])[0]), int(steps[lost[0]]) - 1
        raise InputError(
            f"'{name[:80]}' lacks {gone} of every {every} teeth; say teeth {every} and missing {gone}",
            "missing",
        )
    if len(lost):
        notes.append(
            f"{len(lost)} pulses of '{name}' were lost, the first at {times[lost[0]]:.6g} s; the angle there follows from the others"
        )
    return Teeth(times, numbers, numbers[gaps], tuple(notes))


def _of_the_wheel(numbers: Numbers, gaps: Numbers, teeth: int, missing: int, name: str) -> Numbers:
    """Those gaps that come back once a turn."""
    if not len(gaps):
        raise InputError(f"'{name[:80]}' shows no gap of {missing} missing teeth; correct the number of missing teeth or leave it out")
    rest = numbers[gaps] % teeth
    counts = np.bincount(rest, minlength=teeth)
    most = int(np.argmax(counts))
    turns = (numbers[-1] - numbers[0]) / teeth
    if counts[most] < 0.6 * turns - 1:
        every = float(np.median(np.diff(numbers[gaps]))) if len(gaps) > 1 else 0.0
        raise InputError(
            f"the gap of '{name[:80]}' does not come back after {teeth} teeth but after {every:g}; correct the number of teeth (with those "
            "that are missing)", "teeth",
        )  # fmt: skip
    kept: Numbers = gaps[rest == most]
    return kept
