"""Measurements that no spring and no valvetrain can give are refused in one sentence, at once."""

from __future__ import annotations

import numpy as np
import pytest

from valvetrain.errors import InputError
from valvetrain.measured.cycles import read_cycles
from valvetrain.measured.force_height import ForceHeight, read_force_height
from valvetrain.measured.lift_file import LiftAnswers, lifts_in
from valvetrain.measured.value_table import values_in
from valvetrain.rig.channels import RigAnswers
from valvetrain.rig.cycles import cycles_in
from valvetrain.rig.reader import Recording, RigChannel
from valvetrain.scan.clouds import open_cloud
from valvetrain.spring_card import tester
from valvetrain.spring_card.tester import card_from_table, spring_from_tester

HEIGHTS = np.linspace(40.0, 28.0, 7)


def table(tmp_path, heights, forces):
    file = tmp_path / "table.csv"
    rows = (
        f"{float(height)!r};{float(force)!r}" for height, force in zip(heights, forces, strict=True)
    )
    file.write_text("\n".join(["height (mm);force (N)", *rows]))
    return file


@pytest.mark.parametrize(
    ("heights", "forces"),
    [
        (HEIGHTS, 1e-150 * (43 - HEIGHTS)),
        (HEIGHTS, 1e-9 * (43 - HEIGHTS)),
        (HEIGHTS, 1e9 * (43 - HEIGHTS)),
        ([1e308, *HEIGHTS], [1.0, *(25 * (50 - HEIGHTS))]),
        ([*HEIGHTS, -1e308], [*(25 * (50 - HEIGHTS)), 900.0]),
        ([*HEIGHTS, -3.0], [*(25 * (50 - HEIGHTS)), 900.0]),
        ([*HEIGHTS, 0.0], [*(25 * (50 - HEIGHTS)), 900.0]),
        (1e-9 * HEIGHTS, 25 * (50 - HEIGHTS)),
        (1e6 * HEIGHTS, 25 * (50 - HEIGHTS)),
    ],
    ids=(
        "1e-150 N",
        "1e-9 N",
        "1e9 N",
        "1e308 mm",
        "-1e308 mm",
        "below zero",
        "zero",
        "picometres",
        "kilometres",
    ),
)
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_forces_and_heights_that_no_spring_has_are_refused_on_reading(tmp_path, heights, forces):
    with pytest.raises(InputError, match=r"outside|not above zero"):
        read_force_height(table(tmp_path, heights, forces))


def fitted(rate, lowest=28e-3, stations=6, wire=3.9e-3, outer=26e-3):
    heights = np.linspace(40e-3, lowest, stations)
    forces = ForceHeight(heights, 300 + rate * (40e-3 - heights))
    card = card_from_table(forces, wire_diameter=wire, outer_diameter=outer)
    return spring_from_tester(forces, card, installed_height=38e-3)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"rate": 25e3}, r"25 N/mm needs 8.5 active turns of 3.9 mm, which are solid at 33.2 mm"),
        ({"rate": 25e3, "stations": 40}, r"25 N/mm needs 8.5 active turns"),
        ({"rate": 27e3, "lowest": 30e-3, "stations": 12}, r"7.9 active turns"),
        ({"rate": 45e3, "wire": 6e-3}, r"active turns of 6 mm, which are solid"),
        ({"rate": 25e3, "wire": 2e-3}, r"25 N/mm needs 0.46 active turns of 2 mm"),
    ],
    ids=str,
)
def test_a_table_that_the_wire_cannot_make_is_refused_before_any_fit(monkeypatch, given, words):
    """G d^4 / (8 D^3 k) turns of the wire are higher than the table where they touch, or less than one."""
    monkeypatch.setattr(tester, "fit_closing", None)
    with pytest.raises(InputError, match=words):
        fitted(**given)


@pytest.mark.parametrize(("rate", "stations"), [(32e3, 6), (36e3, 8)])
def test_a_misfit_of_the_order_of_the_force_is_no_answer(monkeypatch, rate, stations):
    """Turns that fit into the lowest height, but with their closed ends do not."""
    monkeypatch.setattr(tester, "forces_by_rod", None)
    with pytest.raises(InputError, match=r"no spring of this wire .* N off"):
        fitted(rate, stations=stations)


def mesh(facets=40):
    corners = np.random.default_rng(1).uniform(-20, 20, (facets, 12)).astype("<f4")
    rows = b"".join(row.tobytes() + b"\0\0" for row in corners)
    return b"\0" * 80 + facets.to_bytes(4, "little") + rows


def points(faces, more=""):
    places = np.random.default_rng(2).uniform(-20, 20, (60, 3)).astype("<f4").tobytes()
    words = "property float x\nproperty float y\nproperty float z\n"
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex 60\n{words}{more}end_header\n"
    return head.encode() + places + faces, len(head) + 12 * 20


FACES = "element face 2\nproperty list uchar int vertex_indices\n"
CORNERS = b"".join(
    b"\3" + np.array(corners, "<i4").tobytes() for corners in ((0, 1, 2), (57, 58, 59))
)


@pytest.mark.parametrize("extra", [b"\0" * 8, b"\x12\x34\x56\x41" * 2, b"\0", b"\0" * 50])
@pytest.mark.parametrize(
    ("name", "whole", "place"),
    [
        ("a.stl", mesh(), 84 + 50 * 20 + 12),
        ("a.ply", *points(b"")),
        ("b.ply", *points(CORNERS, FACES)),
        ("c.ply", *points(b"", "element face 0\nproperty list uchar int vertex_indices\n")),
    ],
    ids=("stl", "points", "faces", "no face"),
)
def test_a_binary_scan_with_bytes_too_many_is_refused(tmp_path, name, whole, place, extra):
    file = tmp_path / name
    file.write_bytes(whole)
    assert len(open_cloud(file).points) in (60, 120)
    file.write_bytes(whole[:place] + extra + whole[place:])
    with pytest.raises(InputError, match="export it again"):
        open_cloud(file)


ROWS = "\n".join(f"{angle},{{0}}" for angle in range(0, 360, 30))


@pytest.mark.parametrize(
    ("unit", "value"),
    [("N", "3.7e8"), ("kN", "3.7e5"), ("N", "3.7e-7"), ("mm", "9e6"), ("MPa", "6e8"), ("m/s", "1e7")],
)  # fmt: skip
def test_values_that_no_valvetrain_has_are_refused_on_reading(tmp_path, unit, value):
    (tmp_path / "a.csv").write_text(f"# quantity: a\n# unit: {unit}\n{ROWS.format(value)}")
    with pytest.raises(InputError, match=r"outside .* of valvetrains"):
        read_cycles(tmp_path / "a.csv")
    with pytest.raises(InputError, match=r"outside .* of valvetrains"):
        values_in(f"quantity,unit,value,scatter\nraw_peak_spring_force,{unit},{value},1 %", "a.csv")


COLUMNS = ("angle", "lift", "velocity", "acceleration")
LIFT = LiftAnswers(angle_of="cam", lift_of="tappet", lift_unit="mm", columns=COLUMNS)


@pytest.mark.parametrize("column", [0, 1, 2, 3])
@pytest.mark.parametrize("value", ["1e308", "-1e308", "1e200", "1e-320"])
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_table_of_lifts_is_read_or_refused_without_a_warning_of_numpy(column, value):
    rows = [
        [f"{angle}", f"{angle * (60 - angle) / 100}", f"{60 - 2 * angle}", "-2"]
        for angle in range(60)
    ]
    for place in (30, 31):
        rows[place][column] = value
    text = "\n".join(" ".join(row) for row in rows)
    try:
        lifts_in(text.encode(), "lift.txt", LIFT)
    except InputError as error:
        assert column < 2, error


@pytest.mark.parametrize("value", [1e308, -1e308, 1e200, 3e8, 1e-320])
@pytest.mark.parametrize("channel", [0, 1])
@pytest.mark.parametrize("count", [1, 3, 2000])
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_a_recording_is_read_or_refused_without_a_warning_of_numpy(value, channel, count):
    time = np.arange(2000) / 5e3
    made = [0.3 + 0.05 * np.sin(40 * time), np.degrees(40 * time) % 720]
    made[channel][900 : 900 + count] = value
    if count == 2000:
        made[channel][:] = value
    channels = tuple(
        RigChannel(name, unit, values, 0.0, 2e-4)
        for name, unit, values in zip(
            ("Spring force", "Crank angle"), ("kN", "deg"), made, strict=True
        )
    )
    answers = RigAnswers(angle_of="crank", encoder="Crank angle")
    try:
        cycles_in(Recording("csv", channels), "rig.csv", answers)
    except InputError:
        return
    assert value == 1e-320, "a spike of this size is no measurement"


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_points_of_every_kind_of_nan_are_read_without_a_warning_of_numpy(tmp_path):
    whole, place = points(b"")
    signalling = b"\x01\x00\xa0\x7f"
    (tmp_path / "a.ply").write_bytes(whole[:place] + signalling + whole[place + 4 :])
    assert np.isnan(open_cloud(tmp_path / "a.ply").points).sum() == 1
    (tmp_path / "a.stl").write_bytes(mesh()[:96] + signalling + mesh()[100:])
    assert np.isnan(open_cloud(tmp_path / "a.stl").points).sum() == 1
