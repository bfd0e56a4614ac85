"""Reads nodal fields (.frd, text) of CalculiX."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

#: Columns of a field line: marker, node number, then values of twelve characters.
_NODE, _FIRST, _WIDTH = slice(3, 13), 13, 12


@dataclass(frozen=True)
class NodalField:
    """One field: ``name`` (DISP, STRESS, ...), solver ``time``, ``nodes`` numbered from 1,
    ``values`` (nodes, components).

    Stress components stand in the order xx, yy, zz, xy, yz, zx (MPa); displacements in mm.
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
