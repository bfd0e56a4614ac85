"""Unit: numbers and names of answers that fresh users took for something else."""

from __future__ import annotations

from valvetrain.parameters.summary import number


def test_what_rounding_leaves_is_printed_as_zero():
    """A least torque of -2.22e-16 N m stood on the page of a bucket."""
    assert [number(value) for value in (-2.22e-16, 9e-13, 0.0)] == ["0"] * 3
    assert number(4.24e-9).startswith("4.24")
