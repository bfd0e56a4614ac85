"""Result files that were damaged, or that lie: readers refuse in one sentence, make room for
nothing that is only claimed, and tell
damage from a difference."""

from __future__ import annotations

import io
import json
import zlib

import h5py
import numpy as np
import pytest
import xarray

from synthetic_study import rod_run
from valvetrain.errors import InputError
from valvetrain.runs.differences import input_differences
from valvetrain.runs.saved_runs import (
    Inputs,
    answer_text,
    find_run,
    list_saved_runs,
    read_answer,
    save_run,
)
from valvetrain.solution import atomic as checksum
from valvetrain.solution.channels import ChannelArrays
from valvetrain.solution.netcdf import TREE, load_netcdf, refuse_claims, save_netcdf, write_arrays
from valvetrain.solution.result import save_csv

RUN = rod_run(samples=90)
READERS = ((save_netcdf, load_netcdf, "run.nc"),)


def refused(load, path, words=None):
    """The sentence of a refusal, which names the file and is one line."""
    with pytest.raises(InputError, match=words) as refusal:
        load(path)
    said = str(refusal.value)
    assert path.name in said and said.isprintable() and len(said) < 800
    return said


@pytest.mark.parametrize(("save", "load", "name"), READERS)
@pytest.mark.parametrize("place", [0.001, 0.2, 0.5, 0.8, 0.97])
def test_one_exchanged_bit_anywhere_is_damage(tmp_path, save, load, name, place):
    path = save(RUN, tmp_path / name)
    content = bytearray(path.read_bytes())
    content[int(place * len(content))] ^= 1
    path.write_bytes(bytes(content))
    refused(load, path)


@pytest.mark.parametrize(("save", "load", "name"), READERS)
@pytest.mark.parametrize("end", [b"", bytes(43), b"# blake2f" + b"0" * 34])
def test_a_file_that_lost_its_closing_line_is_refused(tmp_path, save, load, name, end):
    path = save(RUN, tmp_path / name)
    path.write_bytes(path.read_bytes()[:-43] + end)
    refused(load, path)


@pytest.mark.parametrize(("save", "load", "name"), READERS)
@pytest.mark.parametrize("cut", [1, 20, 39])
def test_a_cut_closing_line_is_told(tmp_path, save, load, name, cut):
    path = save(RUN, tmp_path / name)
    path.write_bytes(path.read_bytes()[:-cut])
    refused(load, path, "cut short")


def test_other_programs_read_what_is_closed_by_a_checksum(tmp_path):
    with xarray.open_dataset(save_netcdf(RUN, tmp_path / "run.nc"), engine="h5netcdf") as dataset:
        np.testing.assert_array_equal(dataset["seat_force"].values, RUN.channel("seat_force"))
    table = np.genfromtxt(save_csv(RUN, tmp_path / "run.csv"), delimiter=",", skip_header=1)
    np.testing.assert_array_equal(table[:, 0], RUN.time)


def test_a_result_without_its_checksum_is_refused_before_the_library_sees_it(tmp_path, monkeypatch):
    """Bytes that claim terabytes, lie or hang the library are never opened by it."""
    path = save_netcdf(RUN, tmp_path / "run.nc")
    whole = checksum.checked_content(path)[0]
    monkeypatch.setattr(h5py, "File", lambda *_: pytest.fail("the library opened it"))
    for body in (b"", b"\x89HDF\r\n\x1a\n" + bytes(900), whole):
        path.write_bytes(body)
        refused(load_netcdf, path, "closing checksum is missing")


@pytest.mark.parametrize("text", ["[" * 100_000, '{"a":' * 50_000, "null", "{}", '"x"', "7"])
def test_deep_and_empty_descriptions_are_refused(tmp_path, text):
    path, memory = tmp_path / "run.nc", io.BytesIO()
    write_arrays(memory, ChannelArrays({}, {}), {TREE: text})
    path.write_bytes(memory.getvalue() + checksum.closing_line(memory.getvalue()))
    refused(load_netcdf, path, "is damaged")


def test_a_variable_whose_one_piece_is_far_larger_than_what_is_stored_is_refused(tmp_path):
    """Ten values, but 800 MB in the piece that they lie in: reading one makes room for all of it.
    Nothing stored claims nothing.
    """
    with h5py.File(tmp_path / "piece.nc", "w") as file:
        held = file.create_dataset(
            "force", (10,), "f8", maxshape=(None,), chunks=(100_000_000,), compression="gzip"
        )
        held.id.write_direct_chunk((0,), zlib.compress(bytes(4096)))
    with pytest.raises(InputError, match="'force' claims 8e\\+08 bytes and holds"):
        refuse_claims(tmp_path / "piece.nc")
    with h5py.File(tmp_path / "empty.nc", "w") as file:
        file.create_dataset(
            "force", (10,), "f8", maxshape=(None,), chunks=(100_000_000,), compression="gzip"
        )
    refuse_claims(tmp_path / "empty.nc")


# ---- kept runs

ANSWER = {
    "created_at": "2026-01-01T00:00:00+00:00", "case": "own", "command": "run", "completed": True,
    "quantities": {"preload": {"value": 300.0, "unit": "N"}}, "runs": [],
}  # fmt: skip


def kept(folder, answer=ANSWER):
    """A run on disk."""
    return save_run(
        folder,
        Inputs("own", 'name = "own"\n', {}, {"command": "run", "engine_speeds": [4000.0]}),
        answer,
    )


def test_a_kept_run_is_read_back_as_written(tmp_path):
    run = kept(tmp_path / "own" / "a")
    assert read_answer(run.folder) == json.loads(json.dumps(dict(run.answer)))


@pytest.mark.parametrize(
    ("old", "new"), [(b"300.0", b"301.0"), (b'"preload"', b'"preloax"'), (b"true", b"false")]
)
def test_a_changed_number_of_a_kept_run_is_damage_and_no_difference(tmp_path, old, new):
    kept(tmp_path / "own" / "a"), kept(tmp_path / "own" / "b")
    path = tmp_path / "own" / "b" / "run.json"
    assert old in path.read_bytes()
    path.write_bytes(path.read_bytes().replace(old, new, 1))
    with pytest.raises(InputError, match="checksum"):
        find_run(str(path.parent))
    assert [run.folder.name for run in list_saved_runs(root=tmp_path)] == ["a"]


@pytest.mark.parametrize(
    "more",
    [
        {"created_at": 3},
        {"case": ["own"]},
        {"quantities": []},
        {"quantities": {"preload": 3}},
        {"quantities": {"preload": {"value": "x"}}},
        {"runs": {}},
        {"runs": [3]},
        {"runs": [{"engine_speed": 4}]},
        {"runs": [{"quantities": [1]}]},
        {"files": "a"},
        {"choices": []},
        {"choices": {"engine_speeds": "4000 rpm"}},
        {"quantities_by_label": {"a": 3}},
    ],
)
def test_an_answer_of_another_shape_is_refused(tmp_path, more):
    folder = tmp_path / "own" / "a"
    folder.mkdir(parents=True)
    (folder / "run.json").write_text(answer_text(ANSWER | more), encoding="utf-8")
    refused(lambda path: find_run(str(path)), folder / "run.json", "not what a run writes")


@pytest.mark.parametrize("text", ["", "{", "[" * 100_000, '{"created_at": ' + "[" * 100_000])
def test_an_answer_that_is_no_json_is_refused(tmp_path, text):
    (tmp_path / "run.json").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="no JSON"):
        find_run(str(tmp_path / "run.json"))


def test_changed_inputs_of_a_kept_run_are_told(tmp_path):
    one, other = kept(tmp_path / "a"), kept(tmp_path / "b")
    assert not [key for key, *_ in input_differences(one, other)]
    other.case_file.write_text('name = "other"\n', encoding="utf-8")
    with pytest.raises(InputError, match="changed or damaged"):
        input_differences(one, other)
