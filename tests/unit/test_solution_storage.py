"""Result files: without loss, whole or not at all, and plain words for what is not one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from synthetic_study import at_rest, rod_run
from valvetrain.errors import InputError
from valvetrain.solution import netcdf, result
from valvetrain.solution.atomic import atomic_path, write_text

RUN, (REST, *_) = rod_run(samples=24), at_rest()


def test_a_static_curve_and_modes_are_read_as_they_were_written(tmp_path):
    netcdf.save_netcdf(REST.curve, tmp_path / "static.nc")
    netcdf.save_netcdf(REST.modes, tmp_path / "modes.nc")
    again = (
        netcdf.load_result(tmp_path / "static.nc"),
        netcdf.load_result(tmp_path / "modes.nc"),
    )
    for found, given in zip(again, (REST.curve, REST.modes), strict=True):
        for name, value in vars(given).items():
            np.testing.assert_array_equal(getattr(found, name), value)


def test_one_kind_is_not_taken_for_another(tmp_path):
    netcdf.save_netcdf(REST.curve, tmp_path / "a.nc")
    with pytest.raises(InputError, match="StaticCurve"):
        netcdf.load_netcdf(tmp_path / "a.nc")


def test_any_netcdf_of_others_is_refused(tmp_path):
    import xarray

    xarray.Dataset({"a": ("sample", [1.0])}).to_netcdf(tmp_path / "b.nc", engine="h5netcdf")
    with pytest.raises(InputError, match="no result of valvetrain"):
        netcdf.load_netcdf(tmp_path / "b.nc")


@pytest.mark.parametrize("failure", [OSError("disk full"), KeyboardInterrupt()])
def test_failed_write_leaves_the_old_file_and_no_other(tmp_path, monkeypatch, failure):
    path = netcdf.save_netcdf(RUN, tmp_path / "run.nc")
    before = path.read_bytes()

    def break_off(self, content):
        with self.open("wb") as stream:
            stream.write(content[: len(content) // 2])
        raise failure

    monkeypatch.setattr(Path, "write_bytes", break_off)
    with pytest.raises(type(failure)):
        netcdf.save_netcdf(RUN, path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_csv_broken_off_in_the_middle_leaves_nothing(tmp_path, monkeypatch):
    rows = iter(["[0.0]"])

    def written(_):
        if (row := next(rows, None)) is None:
            raise KeyboardInterrupt
        return row

    monkeypatch.setattr(result, "repr", written, raising=False)
    with pytest.raises(KeyboardInterrupt):
        result.save_csv(RUN, tmp_path / "run.csv")
    assert list(tmp_path.iterdir()) == []


def test_atomic_path_gives_the_usual_mode_and_replaces(tmp_path):
    write_text(tmp_path / "new" / "a.txt", "one")
    write_text(tmp_path / "new" / "a.txt", "two")
    plain = tmp_path / "plain.txt"
    plain.write_text("x")
    assert (tmp_path / "new" / "a.txt").read_text() == "two"
    assert (tmp_path / "new" / "a.txt").stat().st_mode == plain.stat().st_mode


def test_unwritable_folder_is_an_input_error(tmp_path):
    (tmp_path / "file").write_text("not a folder")
    with (
        pytest.raises(InputError, match="cannot be written"),
        atomic_path(tmp_path / "file" / "a.txt"),
    ):
        pass
