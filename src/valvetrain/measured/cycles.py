"""Measured cycles: one quantity over the cam angle, cycle by cycle, and its files (text, NetCDF).

Rig data are reduced to them, and a model is compared with them.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.measured.door import refuse_beyond
from valvetrain.measured.tables import comments_in, read_content, read_text_table, text_of
from valvetrain.solution.atomic import checked_content, closing_line, write_bytes, write_text
from valvetrain.solution.channels import ChannelArrays, Variable
from valvetrain.solution.display import Shown
from valvetrain.solution.netcdf import refuse_claims, write_arrays
from valvetrain.solution.read_apart import tried_apart
from valvetrain.units import DIMENSIONS, dimension_of, parse_quantity, unit_factor

Array = NDArray[np.float64]


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


#: How an HDF5 file begins.
HDF5_MARK = b"\x89HDF\r\n\x1a\n"
#: A name that a variable may bear.
NETCDF_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,79}")
_KIND = "valvetrain measured cycles"
_GRID = "cam_angle_of_"
_UNREADABLE = "cannot be read as NetCDF; it is another kind of file or was cut short"


def netcdf_image(cycles: Sequence[MeasuredCycles]) -> bytes:
    """Bytes of a NetCDF file. A second channel of one quantity is named ``<quantity>_2``."""
    variables: dict[str, Variable] = {}
    coords: dict[str, Variable] = {}
    for channel in cycles:
        name = channel.quantity
        if not NETCDF_NAME.fullmatch(name):
            raise InputError(
                f"quantity '{name[:40]}' is no name of a variable; use letters, digits and underscores"
            )
        count = sum(given.quantity == name for given in cycles[: len(variables)])
        label = f"{name}_{count + 1}" if count else name
        attributes = {
            "units": channel.unit, "long_name": name.replace("_", " "), "quantity": name, "cam_speed": float(channel.cam_speed),
            "cam_speed_units": "rad/s", "source": channel.source, "synthetic": "yes" if channel.synthetic else "no", "notes": "\n".join(channel.notes)
        }  # fmt: skip
        dims = f"cycle_of_{label}", f"{_GRID}{label}"
        variables[label] = Variable(dims, np.asarray(channel.values, dtype=float), attributes)
        coords[dims[1]] = Variable(
            dims[1:],
            np.asarray(channel.cam_angle, dtype=float),
            {"units": "rad", "long_name": "cam angle"},
        )
    with io.BytesIO() as memory:
        write_arrays(memory, ChannelArrays(variables, coords, {"title": _KIND}), {})
        return memory.getvalue()


def netcdf_cycles(path: Path) -> tuple[MeasuredCycles, ...]:
    """The channels of a NetCDF file of measured cycles. Raises :class:`InputError` for a damaged
    one or one of another kind.
    """
    checked_content(path)
    tried_apart(f"{__name__}:channels_of", path, path.name[:80], _UNREADABLE)
    try:
        return channels_of(path)
    except InputError:
        raise
    except Exception as error:  # the library raises many kinds for bytes that make no sense to it
        raise InputError(_UNREADABLE, path.name[:80]) from error


def channels_of(path: Path) -> tuple[MeasuredCycles, ...]:
    """The channels of a file of measured cycles; errors of the library pass. The file may come from
    anywhere: see :func:`netcdf_cycles`.
    """
    import h5py

    refuse_claims(path)
    with h5py.File(path, "r") as file:
        if _word(file.attrs.get("title", "")) != _KIND:
            raise InputError(
                "holds no measured cycles; a recording of a rig is read by 'valvetrain rig'",
                path.name[:80],
            )
        names = [name for name in file if not name.startswith((_GRID, "cycle_of_"))]
        return tuple(_channel(file, name, path.name[:80]) for name in names)


def _channel(file: Any, name: str, where: str) -> MeasuredCycles:
    dataset, grid = file[name], file.get(f"{_GRID}{name}")
    if (
        grid is None
        or dataset.dtype.kind != "f"
        or grid.dtype.kind != "f"
        or grid.ndim != 1
        or not np.isfinite(grid[()]).all()
    ):
        raise InputError(
            f"channel '{name[:40]}' lacks its cam angles or holds no numbers; write the file again",
            where,
        )
    attributes = dataset.attrs
    speed = float(np.ravel(attributes.get("cam_speed", 0.0))[0])
    return MeasuredCycles(
        _word(attributes.get("quantity", name)),
        _word(attributes["units"]),
        np.asarray(grid[()], dtype=float),
        np.asarray(dataset[()], dtype=float),
        speed if np.isfinite(speed) else 0.0,
        _word(attributes.get("source", "")),
        _word(attributes.get("synthetic", "no")) == "yes",
        tuple(note for note in _word(attributes.get("notes", "")).split("\n") if note),
    )


def _word(value: object) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


#: Larger files are no cycles of a few channels.
MAX_BYTES = 500_000_000
#: Most cycles (columns) of a text, and most of its lines.
MAX_CYCLES, MAX_ANGLES = 20_000, 100_000


def write_cycles(path: str | Path, cycles: Sequence[MeasuredCycles]) -> Path:
    """Write measured cycles whole or not at all: text (CSV) for one channel, NetCDF where the name
    ends in ``.nc``.

    Parameters
    ----------
    path : file to write; its folder is made if absent
    cycles : one MeasuredCycles a channel; a text takes one

    Returns
    -------
    Path of the file

    Raises
    ------
    InputError : no channel, several for a text, a path that cannot be written

    Examples
    --------
    >>> import pathlib, tempfile
    >>> angle = np.linspace(0.0, 2 * np.pi, 72, endpoint=False)
    >>> lifts = MeasuredCycles("valve_lift", "m", angle, 8e-3 + np.outer([1e-3, 2e-3], np.cos(angle)), 150.0, "own rig")
    >>> file = write_cycles(pathlib.Path(tempfile.mkdtemp(), "lift.csv"), [lifts])
    >>> read_cycles(file)[0]
    MeasuredCycles: valve_lift, 2 cycles of 72 angles, 0.006 to 0.01 m
    """
    if not cycles:
        raise InputError("there is no channel to write; give one MeasuredCycles at least", "cycles")
    if str(path).lower().endswith((".nc", ".netcdf")):
        image = netcdf_image(cycles)
        return write_bytes(path, image + closing_line(image))
    if len(cycles) > 1:
        raise InputError(
            f"a text holds one channel, not {len(cycles)}; name the file *.nc, or write one file a channel",
            str(path),
        )
    return write_text(path, _text(cycles[0]))


def read_cycles(path: str | Path) -> tuple[MeasuredCycles, ...]:
    """Read measured cycles, of :func:`write_cycles` or of a table somebody made.

    A text begins with comments such as ``# quantity: valve_lift``, ``# unit: mm``, ``# cam speed:
    1500 rpm`` (or ``engine speed``, of which it is half), ``# synthetic: no``, ``# source: ...``,
    ``# note: ...``; then a line of headings, then rows: cam angle in degrees, one value a cycle
    (empty or ``nan`` where nothing was measured).

    Parameters
    ----------
    path : the file; its content decides how it is read

    Returns
    -------
    One MeasuredCycles a channel

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
    >>> read_cycles(file)[0].unit
    'm'
    """
    place = Path(path)
    content = read_content(place, MAX_BYTES, "file of measured cycles")
    if content.startswith(HDF5_MARK):
        return netcdf_cycles(place)
    return (_from_text(text_of(content, place.name), place.name[:80]),)


def _text(cycles: MeasuredCycles) -> str:
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
    return "\n".join(lines) + "\n"


def _from_text(text: str, name: str) -> MeasuredCycles:
    said = comments_in(text)
    table = read_text_table(text, name, MAX_CYCLES + 1, MAX_ANGLES, gaps=True).rows
    if table.shape[1] < 2:
        raise InputError(
            f"{name} has one column; write cam angles in degrees and one value a cycle"
        )
    quantity, unit, source, synthetic = (
        said.get(key, [""])[0] for key in ("quantity", "unit", "source", "synthetic")
    )
    for key, answer in (("quantity", NETCDF_NAME.fullmatch(quantity)), ("unit", unit)):
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
