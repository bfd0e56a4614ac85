"""Lift tables from text files: two columns, angle and lift, separated by commas, semicolons, tabs or blanks."""

from __future__ import annotations

import math
import re
from itertools import pairwise
from pathlib import Path

from valvetrain.errors import InputError
from valvetrain.parameters.bounded_file import bounded_bytes
from valvetrain.units import DIMENSIONS, dimension_of, unit_factor

_BLANKS = re.compile(r"\s+")


def read_lift_table(path: Path, angle_unit: str, angle_of: str, lift_unit: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Angles (cam rad) and lifts (m) of the table in ``path``.

    ``angle_unit`` deg or rad, ``angle_of`` cam or crank (two crank revolutions are one of the cam), ``lift_unit`` any length. Lines
    before the numbers and lines that begin with ``#`` are headings. Decimal commas are read where the separator is no comma. Rows
    may fall in angle. Raises :class:`InputError` naming the line that cannot be read.
    """
    if dimension_of(lift_unit) != "length":
        raise InputError(f"lift_unit '{lift_unit}' is no length; use one such as {DIMENSIONS['length'].usual_unit}")
    scale = unit_factor(angle_unit) * (0.5 if angle_of == "crank" else 1.0)
    rows = _rows(path)
    if len(rows) < 4:
        raise InputError(f"{path.name} holds {len(rows)} rows of angle and lift; a lift table needs at least four")
    if rows[0][0] > rows[-1][0]:
        rows.reverse()
    return tuple(angle * scale for angle, _ in rows), tuple(lift * unit_factor(lift_unit) for _, lift in rows)


def event_of_table(
    cam_angles: tuple[float, ...], lifts: tuple[float, ...], threshold: float = 0.0
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The lifting part of a table, from the last station of zero lift before it to the first after it.

    Lifts up to ``threshold`` (m) count as zero. A table over a whole revolution may start within the event. Raises
    :class:`InputError` when the table has no base circle on both sides, or no lift.
    """
    angles, lifted = cam_angles, [lift > threshold for lift in lifts]
    if not any(lifted):
        raise InputError("the table holds no lift above its base circle; check the unit and the smoothing")
    turn = 2 * math.pi
    gap, widest = angles[0] + turn - angles[-1], max(late - early for early, late in pairwise(angles))
    if (lifted[0] or lifted[-1]) and gap < 1.01 * widest:
        start = _middle_of_longest_rest(lifted)
        whole = angles[-1] - angles[0] > turn - 1e-6
        first, last = angles[start:], [angle + turn for angle in angles[int(whole) : start + 1]]
        angles, lifts = (*first, *last), (*lifts[start:], *lifts[int(whole) : start + 1])
        lifted = [lift > threshold for lift in lifts]
    if lifted[0] or lifted[-1]:
        raise InputError("a lift table must begin and end on the base circle; add stations of zero lift on both sides")
    begin, end = lifted.index(True) - 1, len(lifted) - lifted[::-1].index(True)
    return tuple(angles[begin : end + 1]), (0.0, *lifts[begin + 1 : end], 0.0)


def _middle_of_longest_rest(lifted: list[bool]) -> int:
    best, best_length, length = -1, 0, 0
    for index, up in enumerate([*lifted, True]):
        if up and length > best_length:
            best, best_length = index - 1 - length // 2, length
        length = 0 if up else length + 1
    if best < 0:
        raise InputError("the lift table never rests on the base circle; add stations of zero lift")
    return best


def _rows(path: Path) -> list[tuple[float, float]]:
    rows: list[tuple[float, float]] = []
    for number, line in enumerate(_read(path).splitlines(), start=1):
        text = line.strip()
        if not text or text.startswith("#"):
            continue
        row = _numbers(text)
        if row is None and rows:
            raise InputError(f"line {number} of {path.name} is no pair of angle and lift; correct it or mark it with #")
        if row is not None:
            rows.append(row)
    return rows


def _numbers(text: str) -> tuple[float, float] | None:
    # runs of blanks become one character, which no pattern below can share out in many ways
    text = _BLANKS.sub(lambda run: "\t" if "\t" in run[0] else " ", text)
    parts = re.split(r" ?[;\t] ?| ", text) if re.search(r"[;\t]|\d [-+.\d]", text) else re.split(r" ?, ?", text)
    try:
        angle, lift = (float(part.rstrip(",").replace(",", ".")) for part in parts[:2])
    except ValueError:
        return None
    return (angle, lift) if math.isfinite(angle) and math.isfinite(lift) else None


def _read(path: Path) -> str:
    try:
        return bounded_bytes(path, "lift table").decode("utf-8-sig")
    except InputError as error:
        raise InputError(f"lift table '{path.name[:80]}' {error.reason}") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path.name} is no text file; export the lift table as CSV") from error
    except (OSError, ValueError) as error:
        raise InputError(f"lift table '{path.name[:80]}' cannot be read; the path is taken from the folder of the case file") from error
