"""Files of measured cycles: what is written is read, what cannot be read is one sentence."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.errors import InputError
from valvetrain.measured.cycles import MeasuredCycles, read_cycles, write_cycles

ANGLES = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)


def channel(quantity="valve_lift", unit="m", **more):
    values = 1e-3 * np.outer([1.0, 2.0, 3.0], 1.1 + np.cos(ANGLES))
    values[1, 3] = np.nan
    return MeasuredCycles(
        quantity, unit, ANGLES, values, 157.25, "own rig", True, ("one note", "and another"), **more
    )


@pytest.mark.parametrize("name", ["cycles.csv", "cycles"])
def test_what_is_written_is_read(tmp_path, name):
    kept = channel()
    found = read_cycles(write_cycles(tmp_path / name, kept))
    np.testing.assert_array_equal(found.values, kept.values)
    np.testing.assert_allclose(found.cam_angle, ANGLES, rtol=1e-15, atol=1e-15)
    for field in ("quantity", "unit", "cam_speed", "source", "synthetic", "notes"):
        assert getattr(found, field) == getattr(kept, field)


def test_a_table_of_ones_own_is_made_si(tmp_path):
    rows = [f"{angle};{angle / 10};" for angle in range(0, 360, 30)]
    head = ["# Quantity: valve_lift", "# unit: mm", "# engine speed: 3000 rpm", "angle;one;two"]
    (tmp_path / "own.txt").write_text("\n".join(head + rows), encoding="utf-8")
    found = read_cycles(tmp_path / "own.txt")
    assert found.unit == "m" and found.cam_speed == pytest.approx(50 * np.pi)
    np.testing.assert_allclose(found.values[0], np.arange(0, 36, 3) * 1e-3)
    assert np.isnan(found.values[1]).all() and not found.synthetic


@pytest.mark.parametrize(
    ("mark", "decimal", "gap"),
    [(";", ".", ""), (";", ",", "nan"), ("\t", ",", ""), ("|", ".", ""), (",", ".", "NaN"), (" ", ",", "nan")],
)  # fmt: skip
@pytest.mark.parametrize("count", [12, 12_000])
def test_a_table_of_any_delimiter_and_decimal_mark_has_the_same_numbers(
    tmp_path, mark, decimal, gap, count
):
    """Short files line by line, long ones by the form of their first lines."""
    angle = np.arange(count) * 360 / count
    values = np.column_stack([angle, np.round(angle / 7, 4), 1 + np.round(angle / 9, 3)])
    lines = [mark.join(f"{value:.6f}".replace(".", decimal) for value in row) for row in values]
    lines[3] = mark.join([f"{angle[3]:.6f}".replace(".", decimal), "1", gap])
    head = [
        "# quantity: valve_lift",
        "# unit: mm",
        "# note: a – b",
        mark.join(["angle", "c1", "c2"]),
    ]
    (tmp_path / "own.txt").write_text("\n".join(head + lines), encoding="utf-8")
    found = read_cycles(tmp_path / "own.txt")
    values[3, 1:] = 1, np.nan
    np.testing.assert_allclose(found.values, 1e-3 * values[:, 1:].T, rtol=1e-12)
    assert found.notes == ("a – b",)


ROWS = "\n".join(f"{angle},1" for angle in range(0, 360, 30))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("# unit: mm\n" + ROWS, "does not say its quantity"),
        ("# quantity: valve_lift\n" + ROWS, "does not say its unit"),
        ("# quantity: a\n# unit: furlong\n" + ROWS, "furlong"),
        ("# quantity: a\n# unit: N\n" + ROWS + "\n1,2,3", "line 15 .* has 3 numbers"),
        ("# quantity: a\n# unit: N\n" + ROWS + "\nx,2", "no row of numbers"),
        ("# quantity: a\n# unit: N\n0,1\n9,inf\n", "no row of numbers"),
        ("# quantity: a\n# unit: N\n" + "\n".join(["0,1"] * 9), "must rise"),
        ("# quantity: a\n# unit: N\n", "no row of numbers"),
        ("# quantity: a\n# unit: N\n0,1\n9,1e999\n", "beyond all bounds"),
        ("# quantity: a\n# unit: N\n# cam speed: 9\n" + ROWS, "has no unit"),
        ("", "is empty"),
        ("a\0b", "no text"),
    ],
)
def test_what_cannot_be_read_is_one_sentence(tmp_path, text, words):
    (tmp_path / "own.txt").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=words):
        read_cycles(tmp_path / "own.txt")
