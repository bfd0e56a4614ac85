"""Reads nodal fields (.frd, text) of CalculiX."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from validation.calculix.deck import MILLIMETRE
from valvetrain.continuum.mesh import SolidMesh
from valvetrain.errors import InputError
from valvetrain.parameters.spring import SpringDefinition

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Columns of a field line: marker, node number, then values of twelve characters.
_NODE, _FIRST, _WIDTH = slice(3, 13), 13, 12


@dataclass(frozen=True)
class NodalField:
    """One field: ``name`` (DISP, STRESS, ...), solver ``time``, ``nodes`` numbered from 1,
    ``values`` (nodes, components).

    Stress components are in the order xx, yy, zz, xy, yz, zx (MPa); displacements in mm.
    """

    name: str
    time: float
    nodes: Integers
    values: Array

    def dense(self, count: int) -> Array:
        """Values (count, components) by node number less one; absent nodes are NaN."""
        full = np.full((count, self.values.shape[1]), np.nan)
        full[self.nodes - 1] = self.values
        return full


def read_fields(text: str) -> list[NodalField]:
    """Every complete field block in order; a block cut off by a stopped run is dropped."""
    fields: list[NodalField] = []
    name, components, time = "", 0, 0.0
    nodes: list[int] = []
    values: list[list[float]] = []
    for line in text.splitlines():
        mark = line[:5]
        if mark == "  100":
            time = float(line[12:24])
        elif mark.startswith(" -4"):
            name, components = line[5:13].strip(), 0
            nodes, values = [], []
        elif mark.startswith(" -5"):
            # The magnitude line ("ALL") is declared but not written.
            components += 0 if line[5:13].strip() == "ALL" else 1
        elif name and mark.startswith(" -1"):
            nodes.append(int(line[_NODE]))
            values.append(
                [
                    float(line[_FIRST + _WIDTH * i : _FIRST + _WIDTH * (i + 1)])
                    for i in range(components)
                ]
            )
        elif name and mark.startswith(" -3"):
            fields.append(
                NodalField(
                    name,
                    time,
                    np.array(nodes, dtype=np.int64),
                    np.array(values).reshape(len(nodes), components),
                )
            )
            name = ""
    return fields


def last_field(fields: list[NodalField], name: str) -> NodalField | None:
    """The last field of that name, None without one."""
    found = [item for item in fields if item.name == name]
    return found[-1] if found else None


@dataclass(frozen=True)
class FibreStress:
    """Stress (Pa) along a fibre: ``shear`` between wire direction and circumference of the section,
    ``axial`` along the wire.

    ``coil`` (points,) coil numbers; ``equivalent`` after von Mises.
    """

    coil: Array
    shear: Array
    axial: Array
    equivalent: Array

    def mean_shear(self, first: float, last: float) -> float:
        """Mean of the shear (Pa) between two coil numbers; whole turns average out what varies once
        around.
        """
        if not self.coil[0] <= first < last <= self.coil[-1]:
            raise InputError(
                f"coils {first:g} to {last:g} are not within {self.coil[0]:g} to {self.coil[-1]:g}; choose a stretch inside"
            )
        fine = np.linspace(first, last, 2001)
        return float(np.trapezoid(np.interp(fine, self.coil, self.shear), fine) / (last - first))


def fibre_stress(
    mesh: SolidMesh, displacement: NodalField, stress: NodalField, x: float = -1.0, y: float = 0.0
) -> FibreStress:
    """Stress on the fibre nearest to section place (x, y) of the unit disc; (-1, 0) is the inner
    fibre, (1, 0) the outer.
    """
    from scipy.interpolate import CubicSpline

    nodes = mesh.fibre(x, y)
    coil = mesh.coil[nodes]
    moved = mesh.coordinates + np.nan_to_num(displacement.dense(len(mesh.coordinates))) / MILLIMETRE
    middle = _middle(mesh, moved, coil)
    # Direction of the wire, not of its fibre: the inner one climbs steeper, and would count a share
    # of the axial stress as shear.
    tangent = CubicSpline(coil, middle)(coil, 1)
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    across = moved[nodes] - middle
    across -= tangent * np.sum(across * tangent, axis=-1, keepdims=True)
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    around = np.cross(tangent, across)
    tensor = _tensor(stress.dense(len(mesh.coordinates))[nodes]) * 1e6
    shear = np.einsum("ni,nij,nj->n", tangent, tensor, around)
    axial = np.einsum("ni,nij,nj->n", tangent, tensor, tangent)
    deviator = tensor - np.eye(3) * np.trace(tensor, axis1=1, axis2=2)[:, None, None] / 3
    return FibreStress(
        coil, shear, axial, np.sqrt(1.5 * np.einsum("nij,nij->n", deviator, deviator))
    )


def wire_torque(spring: SpringDefinition, mesh: SolidMesh, coil: Array, reactions: Array) -> Array:
    """Torsional moment (N m) of the wire at ``coil`` from the printed nodal ``reactions`` (node, x,
    y, z in N) of the retainer.

    Equilibrium of the wire above the cut, in the free shape: for small compressions.
    """
    place = mesh.coordinates[reactions[:, 0].astype(int) - 1]
    centre = spring.centreline(coil)
    arms = place[None] - centre[:, None]
    moment = np.cross(arms, reactions[None, :, 1:4]).sum(axis=1)
    tangent = spring.centreline(coil + 1e-6) - spring.centreline(coil - 1e-6)
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    found: Array = np.sum(tangent * moment, axis=-1)
    return found


def _middle(mesh: SolidMesh, moved: Array, coil: Array) -> Array:
    """Middle of the section at every coil number: mean of four fibres a quarter turn of the section
    apart.
    """
    from scipy.interpolate import CubicSpline

    fibres = [mesh.fibre(*place) for place in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))]
    found: Array = np.mean(
        [CubicSpline(mesh.coil[nodes], moved[nodes])(coil) for nodes in fibres], axis=0
    )
    return found


def _tensor(components: Array) -> Array:
    """Tensors (n, 3, 3) from xx, yy, zz, xy, yz, zx."""
    xx, yy, zz, xy, yz, zx = components.T
    return np.stack(
        [np.stack([xx, xy, zx], -1), np.stack([xy, yy, yz], -1), np.stack([zx, yz, zz], -1)], -2
    )


_HEADING = re.compile(
    r"^\s*(?P<what>[a-zA-Z][a-zA-Z ]*?) \(.*?\) for set (?P<set>\S+) and time\s+(?P<time>\S+)"
)
_CONTACT = re.compile(
    r"^\s*statistics for slave set (?P<set>\S+?),? master set \S+ and time\s+(?P<time>\S+)"
)
_MODE = re.compile(r"E I G E N V A L U E\s+N U M B E R\s+(\d+)")
_PARTICIPATION = re.compile(r"P A R T I C I P A T I O N")
_STEP = re.compile(r"E I G E N V A L U E\s+O U T P U T")
#: More blocks than one mode or increment prints.
_MAX_SETS = 64


@dataclass(frozen=True)
class Table:
    """One printed block: quantity, node set (upper case), solver time, mode number (0 outside a
    modal step), rows.
    """

    quantity: str
    node_set: str
    time: float
    mode: int
    modal_step: int
    rows: Array


@dataclass(frozen=True)
class Printed:
    """All blocks of a .dat file in order; natural frequencies (Hz) and participation factors (mode,
    6) of each modal step.
    """

    tables: tuple[Table, ...]
    natural_frequencies: tuple[Array, ...]
    participation: tuple[Array, ...] = ()

    def history(self, quantity: str, node_set: str) -> tuple[Array, list[Array]]:
        """Times and rows of every non-modal block of that quantity and set."""
        found = [
            table
            for table in self.tables
            if (table.quantity, table.node_set, table.mode) == (quantity, node_set, 0)
        ]
        return np.array([table.time for table in found]), [table.rows for table in found]

    def modal(self, quantity: str, node_set: str, step: int = -1) -> list[Array]:
        """Rows of every mode of the modal step (-1 the last), in order."""
        modal_step = len(self.natural_frequencies) + step + 1 if step < 0 else step + 1
        return [
            t.rows
            for t in self.tables
            if (t.quantity, t.node_set, t.modal_step) == (quantity, node_set, modal_step)
            and t.mode > 0
        ]


def read_printed(text: str) -> Printed:
    """The blocks of a .dat file; an unfinished last block (a stopped run) is dropped."""
    tables: list[Table] = []
    frequencies: list[Array] = []
    participation: list[Array] = []
    lines = text.splitlines()
    position, mode = 0, 0
    while position < len(lines):
        line = lines[position]
        position += 1
        if _STEP.search(line):
            values, position = _mode_rows(lines, position, 5)
            frequencies.append(values[:, 3])
            mode = 0
        elif _PARTICIPATION.search(line):
            values, position = _mode_rows(lines, position, 7)
            participation.append(values[:, 1:])
        elif found := _MODE.search(line):
            mode = int(found[1])
        elif found := _HEADING.match(line) or _CONTACT.match(line):
            quantity = found.groupdict().get("what", "contact")
            rows, position = _rows(lines, position)
            key = (quantity.strip(), found["set"].rstrip(","))
            # A static step has no heading of its own: a block that a mode has printed already
            # belongs to the next step.
            if mode and any(
                (t.quantity, t.node_set, t.mode, t.modal_step) == (*key, mode, len(frequencies))
                for t in tables[-_MAX_SETS:]
            ):
                mode = 0
            if len(rows):
                tables.append(
                    Table(*key, float(found["time"]), mode, len(frequencies) if mode else 0, rows)
                )
    return Printed(tuple(tables), tuple(frequencies), tuple(participation))


def _mode_rows(lines: list[str], position: int, width: int) -> tuple[Array, int]:
    """Rows of ``width`` numbers that begin with a mode number, up to the first line that is none."""
    values: list[list[float]] = []
    while position < len(lines):
        items = lines[position].split()
        if len(items) == width and items[0].isdigit():
            values.append([float(item) for item in items])
        elif values:
            break
        position += 1
    return np.array(values).reshape(len(values), width), position


def _rows(lines: list[str], position: int) -> tuple[Array, int]:
    """Numbers up to the next line that holds words; blank lines and contact subtitles between are
    skipped.
    """
    rows: list[list[float]] = []
    while position < len(lines):
        numbers = _numbers(lines[position])
        if numbers is None:
            if not re.match(r"^\s*(total surface|center of gravity|area,|moment)", lines[position]):
                break
        elif numbers:
            rows.append(numbers)
        position += 1
    width = min((len(row) for row in rows), default=0)
    return np.array([row[:width] for row in rows]).reshape(len(rows), width), position


def _numbers(line: str) -> list[float] | None:
    """Numbers of a line, empty for a blank one, None when it holds words."""
    try:
        return [float(item) for item in line.split()]
    except ValueError:
        return None
