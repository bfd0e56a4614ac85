"""Unit: small files of others that claim or unpack to far more than a table holds are refused by
what they state, at once, and end no process that reads them.
"""

import io
import os
import struct
import zipfile
import zlib

import numpy as np
import pytest
import xlsxwriter

from valvetrain.errors import InputError
from valvetrain.film.frames import open_film
from valvetrain.measured import tables
from valvetrain.measured.cycles import read_cycles
from valvetrain.measured.force_height import read_force_height
from valvetrain.measured.lift_file import read_lift
from valvetrain.measured.value_table import read_value_table
from valvetrain.parameters.loading import parse_case
from valvetrain.rig.reader import Budget, read_recording
from valvetrain.scan.clouds import open_cloud

MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
SHEET = "xl/worksheets/sheet1.xml"


def workbook(rows: bytes) -> bytes:
    """A workbook whose one sheet holds ``rows`` (XML)."""
    empty, memory = io.BytesIO(), io.BytesIO()
    with xlsxwriter.Workbook(empty) as book:
        book.add_worksheet("cam")
    body = f'<worksheet xmlns="{MAIN}"><sheetData>'.encode() + rows + b"</sheetData></worksheet>"
    with (
        zipfile.ZipFile(empty) as old,
        zipfile.ZipFile(memory, "w", zipfile.ZIP_DEFLATED) as archive,
    ):
        for name in old.namelist():
            archive.writestr(name, body if name == SHEET else old.read(name))
    return memory.getvalue()


def row(number: int, *cells: tuple[str, float]) -> bytes:
    inside = "".join(f'<c r="{column}{number}"><v>{value}</v></c>' for column, value in cells)
    return f'<row r="{number}">{inside}</row>'.encode()


LOBE = b"".join(row(k + 1, ("A", k), ("B", max(0.0, 8 - (k - 60) ** 2 / 400))) for k in range(121))
FAR = workbook(LOBE + row(1_048_576, ("XFD", 1.0)))
TALL = workbook(b"".join(row(k, ("A", k)) for k in range(1, 60_000)))
UNPACKS = workbook(b"<row/>" * 20_000_000)
WORKBOOKS = {
    "one cell at the far end": (FAR, "is damaged"),
    "many rows": (TALL, "sheet 'cam'.*has more than 50000 rows"),
    "unpacks to 120 MB": (UNPACKS, "unpacks to 120 MB"),
    "no workbook": (b"PK\x03\x04" + bytes(60), "no workbook that can be read"),
}


@pytest.mark.parametrize("which", WORKBOOKS)
def test_a_small_workbook_that_claims_much_is_refused(which, tmp_path):
    content, words = WORKBOOKS[which]
    assert len(content) < 1_000_000
    (tmp_path / "cam.xlsx").write_bytes(content)
    with pytest.raises(InputError, match=words):
        read_lift(tmp_path / "cam.xlsx")


def test_the_workbook_of_a_case_is_refused_and_the_reader_of_the_case_lives_on(tmp_path):
    (tmp_path / "cam.xlsx").write_bytes(FAR)
    text = '[lift_law]\nkind = "measured"\nfile = "cam.xlsx"\nangle_of = "cam"\nlift_of = "valve"\nlift_unit = "mm"\n'
    with pytest.raises(InputError, match="is damaged"):
        parse_case(text, "own", tmp_path)
    (tmp_path / "cam.xlsx").write_bytes(workbook(LOBE))
    columns = text + 'columns = "angle, lift"\n'
    assert max(parse_case(columns, "own", tmp_path).lift_law.values["lifts"]) == pytest.approx(8e-3)


@pytest.mark.parametrize("reader", [read_lift, read_force_height])
def test_a_text_of_more_lines_than_a_table_has_is_refused_before_they_are_read(reader, tmp_path):
    (tmp_path / "long.csv").write_text("1\n" * 1_000_000)
    with pytest.raises(InputError, match="1000000 lines, more than"):
        reader(tmp_path / "long.csv")


def test_a_recording_of_more_lines_than_samples_are_read_is_refused_unread(tmp_path, monkeypatch):
    monkeypatch.setattr(Budget, "SAMPLES", 1000)
    (tmp_path / "long.txt").write_text("time [s]; force [N]\n" + "no number\n" * 1001)
    with pytest.raises(InputError, match=r"claims more than 0\.001 million samples"):
        read_recording(tmp_path / "long.txt")


def test_measured_cycles_of_more_numbers_than_are_held_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(tables, "MAX_UNLIKE_NUMBERS", 100)
    lines = ["# quantity: valve_lift", "# unit: mm", *(f"{k},{k},{k}" for k in range(60))]
    (tmp_path / "cycles.csv").write_text("\n".join(lines))
    with pytest.raises(InputError, match="holds more than"):
        read_cycles(tmp_path / "cycles.csv")


def test_a_table_of_more_values_than_a_test_has_is_refused(tmp_path):
    """A hundred thousand rows within the bytes that are read: refused by their number, none is taken as a value."""
    (tmp_path / "values.csv").write_text("quantity,unit,value,scatter\n" + "a\n" * 100_000)
    with pytest.raises(InputError, match="holds more than 2000 values"):
        read_value_table(tmp_path / "values.csv")


def mat(path):
    """A matrix of 10 000 x 10 000 doubles whose header alone is there."""
    flags = struct.pack("<IIII", 6, 8, 6, 0)
    shape = struct.pack("<IIii", 5, 8, 10_000, 10_000)
    name, data = struct.pack("<II8s", 1, 5, b"force"), struct.pack("<II", 9, 800_000_000)
    body = flags + shape + name + data
    path.write_bytes(
        b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + struct.pack("<II", 14, len(body)) + body
    )


def hdf5(path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        file.create_dataset("force", (1_000_000_000,), "f8", chunks=(1000,))


@pytest.mark.parametrize("write", [mat, hdf5])
def test_a_recording_that_claims_more_than_it_holds_is_refused(write, tmp_path):
    write(tmp_path / "recording")
    with pytest.raises(InputError, match=r"damaged|claims more"):
        read_recording(tmp_path / "recording")


def png(rows: int, columns: int) -> bytes:
    def chunk(kind: bytes, content: bytes) -> bytes:
        return (
            struct.pack(">I", len(content))
            + kind
            + content
            + struct.pack(">I", zlib.crc32(kind + content))
        )

    head = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(b""))
        + chunk(b"IEND", b"")
    )


def test_frames_and_clouds_that_claim_much_are_refused_by_their_heads(tmp_path):
    pytest.importorskip("cv2")
    os.mkdir(tmp_path / "film")
    (tmp_path / "film" / "1.png").write_bytes(png(60_000, 60_000))
    with pytest.raises(InputError, match="larger than 16 million pixels"):
        open_film(tmp_path / "film")
    (tmp_path / "a.stl").write_bytes(bytes(80) + np.uint32(4_000_000_000).tobytes())
    with pytest.raises(InputError, match=r"facets|triangles"):
        open_cloud(tmp_path / "a.stl")
