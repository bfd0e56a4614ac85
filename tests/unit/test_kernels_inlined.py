"""Kernels of fast maths are inlined into the loops that are called: the same bits from code
compiled now and from code kept on disk.

A kernel that stays a function of its own has two copies, one in its own library and one beside each
loop, optimised apart. The process that
compiles calls the first, one that reads kept code the second: their sums, which fast maths may
reorder, differed in the last bits.
"""

from __future__ import annotations

import pytest
from numba.core.dispatcher import Dispatcher

from valvetrain.cosserat import lanes, step_kernels, time_stepping


def fast(module) -> dict[str, Dispatcher]:
    return {
        name: found
        for name, found in vars(module).items()
        if isinstance(found, Dispatcher) and found.targetoptions.get("fastmath")
    }


@pytest.mark.parametrize(
    "module",
    [step_kernels, time_stepping, lanes],
    ids=lambda module: module.__name__.rpartition(".")[2],
)
def test_every_kernel_of_fast_maths_is_inlined_into_its_caller(module):
    kernels = fast(module)
    assert len(kernels) >= 4
    assert not [
        name for name, kernel in kernels.items() if not kernel.targetoptions.get("forceinline")
    ]


@pytest.mark.parametrize(
    "caller",
    [
        time_stepping.all_contact,
        time_stepping.forces_now,
        time_stepping.kick_and_drift,
        lanes.contact_of_lanes,
        lanes.outer_forces_of_lanes,
        lanes.advance_lanes,
    ],
    ids=lambda caller: caller.py_func.__name__,
)
def test_what_holds_such_kernels_is_inlined_in_turn(caller):
    assert caller.targetoptions.get("forceinline")
