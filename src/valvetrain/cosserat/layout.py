"""Rows of the rod's one flat buffer: structure of arrays with a constant stride, so that loops
vectorise.

Entry j of a row is ``buffer[row + j]``; the names below are row starts, stored as unsigned
constants (signed
indices would be checked for wrap-around and stop vectorisation). The stride is a compile-time
constant and no power
of two (cache sets). Vertex rows hold vertex i at j = i; edge rows hold edge e, between vertices e -
1 and e, at j = e.
"""

from __future__ import annotations

import numpy as np

from valvetrain.arrays import Array

#: Row stride of the buffer in entries: 1536 vertices and a pad for shifted reads at either end.
STRIDE = 1576
#: Entries left free before index 0 of each row.
PAD = 8

_NAMES = (
    # state: position and frame; velocity, body spin and the low-passed bending strain carried over
    # the step
    "X Y Z Q0 Q1 Q2 Q3 VX VY VZ W1 W2 W3 L1 L2 L3 "
    # work: section force (space) and its torque (body) per edge; torques of vertex i on edges i (A)
    # and i + 1 (B)
    "FX FY FZ T1 T2 T3 A1 A2 A3 B1 B2 B3 "
    # contact force per vertex; wire one turn below; force on it, indexed by the upper partner
    "CX CY CZ XL YL ZL VXL VYL VZL GX GY GZ "
    # constants: 1/h, kGA, EA, rest stretch, h; bend stiffness, rest bend; 1/mass, 1/inertia, mass,
    # seat limits
    "INVH GA EA U1 U2 U3 H K1 K2 K3 R1 R2 R3 IM IJ1 IJ3 MASS LOWER UPPER SEAT "
    # contact group 1: 1/d0^2, d0/2, stiffness, 1/slope^2; force on upper wire, foot weights;
    # impulse, peak, loss, stored energy
    "D0 DH KC IS PX PY PZ S0 S1 S2 IMPULSE PEAK LOSS STORED "
    # contact group 2 (coarse meshes)
    "D0b DHb KCb ISb PXb PYb PZb S0b S1b S2b IMPULSEb PEAKb LOSSb STOREDb "
    # walls of a guide: largest and smallest radius of the wire's axis, stiffness
    "BORE ROD WALL "
    # end coils that lift (end_coils)
    "END"
).split()

ROW = {name: np.uint64(PAD + number * STRIDE) for number, name in enumerate(_NAMES)}
ROWS = len(_NAMES)
#: Buffer distance between a row of the first and of the second contact group.
GROUP = np.uint64(ROW["D0b"] - ROW["D0"])
SIZE = ROWS * STRIDE


def row(buffer: Array, name: str, count: int) -> Array:
    """View of the first ``count`` entries of a row."""
    start = int(ROW[name])
    return buffer[start : start + count]


#: Bytes of a large memory page, and the size of an allocation from which numpy requests from the system for
#: such pages.
LARGE_PAGE, LARGE_ALLOCATION = 2**21, 2**23


def empty_buffer() -> Array:
    """A buffer of zeros at the start of a large memory page where the system gives one.

    The rows are on about 300 small pages, more than the processor caches addresses of: eight rods
    side by side took 0.23 s per variant
    instead of 0.16. Memory that is not touched costs nothing.
    """
    whole = np.zeros(LARGE_ALLOCATION // 8)
    start = -whole.ctypes.data % LARGE_PAGE // 8
    return whole[start : start + SIZE]
