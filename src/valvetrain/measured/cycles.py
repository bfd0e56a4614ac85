"""Measured cycles: one quantity over the cam angle, cycle by cycle, and its files of text.

Rig data are reduced to them, and a model is compared with them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.measured.door import refuse_beyond
from valvetrain.measured.tables import comments_in, read_content, read_text_table, text_of
from valvetrain.solution.atomic import write_text
from valvetrain.solution.display import Shown
from valvetrain.units import DIMENSIONS, dimension_of, parse_quantity, unit_factor


@dataclass(frozen=True, eq=False)
class MeasuredCycles(Shown):
    """Repeats of one quantity on a common grid of cam angles.

    Parameters
    ----------
    quantity : what was measured, a name of the table of quantities' traces such as "spring_force"
        or "valve_lift"
    unit : unit of ``values``, SI ("N", "m", "Pa", "m/s", "m/s^2", "1")
    cam_angle : rad of cam, rising by equal steps over one cycle, 2 pi not included, shape (angles,)
    values : shape (cycles, angles); a repeat that was not measured at an angle holds NaN there
    cam_speed : rad/s, mean over the cycles; 0 where it is unspecified
    source : where the values come from, such as a file's name
    synthetic : computed, not measured; every page says so
    notes : what was found or done on the way, a sentence each

    Raises
    ------
    InputError : shapes that do not agree, angles that do not rise, no cycle at all

    Examples
    --------
    >>> import numpy as np
    >>> angle = np.linspace(0.0, 2 * np.pi, 360, endpoint=False)
    >>> MeasuredCycles("spring_force", "N", angle, 500 + np.outer([1.0, -1.0], np.sin(angle)))
    MeasuredCycles: spring_force, 2 cycles of 360 angles, 499 to 501 N
    """

    quantity: str
    unit: str
    cam_angle: Array
    values: Array
    cam_speed: float = 0.0
    source: str = ""
    synthetic: bool = False
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if (
            self.values.ndim != 2
            or self.values.shape[1] != len(self.cam_angle)
            or not len(self.values)
        ):
            shape = f"values of shape {self.values.shape} for {len(self.cam_angle)} cam angles"
            raise InputError(f"{self.source or self.quantity}: {shape}; one row a cycle is needed")
        if len(self.cam_angle) < 8 or not (np.diff(self.cam_angle) > 0.0).all():
            raise InputError(
                f"{self.source or self.quantity}: the cam angles must rise and be 8 at least"
            )
        refuse_beyond(self.values, self.unit, f"{self.quantity} of {self.source or 'the test'}")

    @property
    def mean(self) -> Array:
        """Mean over the cycles, shape (angles,)."""
        mean: Array = np.nanmean(self.values, axis=0)
        return mean

    def __repr__(self) -> str:
        reach = f"{np.nanmin(self.values):.4g} to {np.nanmax(self.values):.4g} {self.unit}"
        return f"MeasuredCycles: {self.quantity}, {len(self.values)} cycles of {len(self.cam_angle)} angles, {reach}"


#: A name that a quantity may bear.
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,79}")
#: Larger files are no cycles of a channel.
MAX_BYTES = 500_000_000
#: Most cycles (columns) of a text, and most of its lines.
MAX_CYCLES, MAX_ANGLES = 20_000, 100_000


def write_cycles(path: str | Path, cycles: MeasuredCycles) -> Path:
    """Write measured cycles as text (CSV), whole or not at all.

    Parameters
    ----------
    path : file to write; its folder is made if absent
    cycles : the MeasuredCycles of one channel

    Returns
    -------
    Path of the file

    Raises
    ------
    InputError : a path that cannot be written

    Examples
    --------
    >>> import pathlib, tempfile
    >>> angle = np.linspace(0.0, 2 * np.pi, 72, endpoint=False)
    >>> lifts = MeasuredCycles("valve_lift", "m", angle, 8e-3 + np.outer([1e-3, 2e-3], np.cos(angle)), 150.0, "own rig")
    >>> read_cycles(write_cycles(pathlib.Path(tempfile.mkdtemp(), "lift.csv"), lifts))
    MeasuredCycles: valve_lift, 2 cycles of 72 angles, 0.006 to 0.01 m
    """
    head = [
        f"quantity: {cycles.quantity}", f"unit: {cycles.unit}", f"cam speed: {float(cycles.cam_speed)!r} rad/s",
        f"synthetic: {'yes' if cycles.synthetic else 'no'}",
        *([f"source: {cycles.source}"] if cycles.source else []), *(f"note: {note}" for note in cycles.notes)
    ]  # fmt: skip
    lines = [f"# {' '.join(line.split())}" for line in head]
    names = [f"cycle {place} [{cycles.unit}]" for place in range(1, len(cycles.values) + 1)]
    lines.append(",".join(["cam angle [deg]", *names]))
    table = np.column_stack([np.degrees(cycles.cam_angle), cycles.values.T])
    lines += [
        ",".join("" if math.isnan(value) else repr(value) for value in row)
        for row in table.tolist()
    ]
    return write_text(path, "\n".join(lines) + "\n")


def read_cycles(path: str | Path) -> MeasuredCycles:
    """Read measured cycles, of :func:`write_cycles` or of a table somebody made.

    It begins with comments such as ``# quantity: valve_lift``, ``# unit: mm``, ``# cam speed:
    1500 rpm`` (or ``engine speed``, of which it is half), ``# synthetic: no``, ``# source: ...``,
    ``# note: ...``; then a line of headings, then rows: cam angle in degrees, one value a cycle
    (empty or ``nan`` where nothing was measured).

    Parameters
    ----------
    path : the file

    Returns
    -------
    MeasuredCycles

    Raises
    ------
    InputError : a file that is missing, damaged, cut short, of another kind, or does not say its
        quantity or unit

    Examples
    --------
    >>> import pathlib, tempfile
    >>> rows = [f"{angle},{8 - angle / 45}" for angle in range(0, 360, 30)]
    >>> file = pathlib.Path(tempfile.mkdtemp(), "own.txt")
    >>> _ = file.write_text(chr(10).join(["# quantity: valve_lift", "# unit: mm", "angle,first", *rows]))
    >>> read_cycles(file).unit
    'm'
    """
    place = Path(path)
    content = read_content(place, MAX_BYTES, "file of measured cycles")
    return cycles_in(text_of(content, place.name), place.name[:80])


def cycles_in(text: str, name: str) -> MeasuredCycles:
    """The cycles in ``text``; as :func:`read_cycles`."""
    said = comments_in(text)
    table = read_text_table(text, name, MAX_CYCLES + 1, MAX_ANGLES, gaps=True).rows
    if table.shape[1] < 2:
        raise InputError(
            f"{name} has one column; write cam angles in degrees and one value a cycle"
        )
    quantity, unit, source, synthetic = (
        said.get(key, [""])[0] for key in ("quantity", "unit", "source", "synthetic")
    )
    for key, answer in (("quantity", _NAME.fullmatch(quantity)), ("unit", unit)):
        if not answer:
            raise InputError(
                f"{name} does not say its {key}; write a line '# {key}: {'valve_lift' if key == 'quantity' else 'mm'}'"
            )
    if not np.isfinite(table[:, 0]).all():
        raise InputError(f"{name} holds a cam angle that is no number; correct it")
    factor, unit = _si_unit(unit, name)
    return MeasuredCycles(
        quantity,
        unit,
        np.radians(table[:, 0]),
        np.ascontiguousarray(table[:, 1:].T) * factor,
        stated_speed(said, name) / 2,
        source,
        synthetic.lower() in ("yes", "true", "1"),
        tuple(said.get("note", ())),
    )


def _si_unit(unit: str, name: str) -> tuple[float, str]:
    """Factor to SI and the SI unit of ``unit``."""
    try:
        dimension = dimension_of("" if unit == "1" else unit)
        factor = unit_factor("" if unit == "1" else unit)
    except InputError as error:
        raise InputError(f"{error.reason} (in {name})") from error
    if dimension is None:
        raise InputError(
            f"unit '{unit[:40]}' of {name} is none of a measured quantity; use one such as N, mm, MPa, m/s"
        )
    return factor, DIMENSIONS[dimension].si_unit or "1"


def stated_speed(said: Mapping[str, list[str]], name: str) -> float:
    """Speed of the crank (rad/s) that comments ``engine speed`` or ``cam speed`` state; 0 without."""
    for key, ratio in (("engine speed", 1.0), ("cam speed", 2.0)):
        if said.get(key):
            speed = parse_quantity(said[key][0], "angular speed", f"{key} of {name}")
            if speed < 0:
                raise InputError(f"{key} of {name} is below zero; give it as it turns")
            return ratio * speed
    return 0.0
