"""Result files: without loss, whole or not at all, and plain words for what is not one."""

from __future__ import annotations

from pathlib import Path

import h5netcdf
import numpy as np
import pytest

from valvetrain.errors import InputError
from valvetrain.solution import netcdf, textfile
from valvetrain.solution import netcdf as netcdf_layout
from valvetrain.solution.atomic import atomic_path, write_text
from valvetrain.solution.channels import arrays_of, spring_channels
from valvetrain.solution.modes import ModalResult
from valvetrain.solution.provenance import collect_provenance
from valvetrain.solution.result import Solution
from valvetrain.solution.static import StaticCurve
from valvetrain.solution.status import Event, Status

PAIRS = ((netcdf.save_netcdf, netcdf.load_netcdf, "run.nc"),)


def _solution() -> Solution:
    values = {
        "seat_force": [1.0, 0.1 + 0.2, np.nan],
        "axial_velocity": [[1e-300, -0.0], [np.inf, 5.0], [2.0, 1 / 3]],
        "coil_contact_force": [[0.0], [7.0], [1e5]],
        "contact_status": [[0], [2], [3]],
    }
    channels = spring_channels(
        [0.0, 1e-5, 2e-5], [0.0, 0.1, 0.2], values, coil_number=[1.0, 2.0], upper_coil=[2.25]
    )
    events = (
        Event(
            "clash",
            0.1,
            1e-5,
            2e-6,
            7.0,
            "N",
            "coils 1-2",
            {"impulse": 1e-4, "upper_coil": 2, "exact": True},
        ),
    )
    status = Status("solid", "all coils touch", 2e-5, "coil 2.25", "lower the lift")
    provenance = collect_provenance(
        "demo",
        "finite-element",
        engine_speed=838.0,
        case_digest="ab12",
        options={"step": 1e-5, "law": "Hertz, 'line'", "cap": None},
        created_at="2024-01-01T00:00:00Z",
        citations=('Ünal, "Springs", 1999\nsecond line',),
    )
    return Solution(
        channels,
        events,
        status,
        {"steps": 3, "wall_time": 0.25, "scheme": "generalised alpha"},
        provenance,
    )


def _curve() -> StaticCurve:
    steps = np.linspace(0, 7e-3, 8)
    gap = np.outer(8 - np.arange(8), [1.0, 2.0])
    return StaticCurve(
        steps,
        4e4 * steps,
        np.full(8, 4e4),
        gap,
        np.zeros((8, 2)),
        np.array([2.0, 3.0]),
        np.ones((8, 3)),
        np.arange(3.0),
    )


def _modes() -> ModalResult:
    shape = np.arange(18.0).reshape(2, 3, 3)
    return ModalResult(
        7e-3,
        np.array([400.0, 630.0]),
        shape,
        np.arange(3.0),
        np.array([0.01, 1.2]),
        (1,),
        Status("not-converged", "slow"),
    )


@pytest.mark.parametrize(("save", "load", "name"), PAIRS)
def test_solution_survives_storage(tmp_path, save, load, name):
    solution = _solution()
    assert save(solution, tmp_path / name) == tmp_path / name
    again = load(tmp_path / name)
    assert again.identical(solution)
    assert np.signbit(again.channel("axial_velocity")[0, 1])
    assert again.cite() == solution.cite()
    assert list(tmp_path.iterdir()) == [tmp_path / name]


def test_a_changed_number_is_not_identical():
    solution = _solution()
    channels = solution.channels.copy(deep=True)
    channels["seat_force"][0] = 1.0 + 1e-15
    assert not Solution(
        channels, solution.events, solution.status, solution.statistics, solution.provenance
    ).identical(solution)


def test_csv_header_names_units_and_places(tmp_path):
    textfile.save_csv(_solution(), tmp_path / "run.csv")
    header = (tmp_path / "run.csv").read_text().split("\n")[0].split(",")
    assert header[:3] == ["time [s]", "cam_angle [rad]", "seat_force [N]"]
    assert "axial_velocity at wire point 2 [m/s]" in header
    assert "coil_contact_force at coil pair 2.25 [N]" in header


def test_static_curve_and_modes_survive_storage(tmp_path):
    netcdf.save_static_curve(_curve(), tmp_path / "static.nc")
    curve = netcdf.load_static_curve(tmp_path / "static.nc")
    for name in (
        "compression",
        "force",
        "stiffness",
        "coil_gap",
        "coil_contact_force",
        "upper_coil",
        "axial_position",
        "coil_number",
    ):
        np.testing.assert_array_equal(getattr(curve, name), getattr(_curve(), name))
    netcdf.save_modal_result(_modes(), tmp_path / "modes.nc")
    modes = netcdf.load_modal_result(tmp_path / "modes.nc")
    np.testing.assert_array_equal(modes.shape, _modes().shape)
    assert (modes.compression, modes.axial_modes, modes.status) == (
        7e-3,
        (1,),
        Status("not-converged", "slow"),
    )
    assert modes.axial_frequencies == pytest.approx([630.0])


@pytest.mark.parametrize(("save", "load", "name"), PAIRS)
@pytest.mark.parametrize("kept", [0.0, 0.1, 0.5, 0.9, 0.999])
def test_truncated_file_is_refused_in_one_sentence(tmp_path, save, load, name, kept):
    path = save(_solution(), tmp_path / name)
    content = path.read_bytes()
    path.write_bytes(content[: int(kept * len(content))])
    with pytest.raises(InputError, match=name):
        load(path)


@pytest.mark.parametrize(("save", "load", "name"), PAIRS)
@pytest.mark.parametrize(
    "content", [b"", b"hello", b"\x89HDF\r\n\x1a\n", b"\xff\xfe\x00", b"angle,force\n1,2\n"]
)
def test_foreign_file_is_refused(tmp_path, save, load, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError):
        load(tmp_path / name)
    with pytest.raises(InputError, match="no such file"):
        load(tmp_path / "absent")


def test_one_kind_is_not_taken_for_another(tmp_path):
    netcdf.save_static_curve(_curve(), tmp_path / "a.nc")
    with pytest.raises(InputError, match="static-curve"):
        netcdf.load_netcdf(tmp_path / "a.nc")


def test_any_netcdf_of_others_is_refused(tmp_path):
    import xarray

    xarray.Dataset({"a": ("sample", [1.0])}).to_netcdf(tmp_path / "b.nc", engine="h5netcdf")
    with pytest.raises(InputError, match="not a valvetrain"):
        netcdf.load_netcdf(tmp_path / "b.nc")


def _told(path):
    """All that a NetCDF-4 file holds: attributes of the file and of each variable, with dimensions,
    types and bytes.
    """
    with h5netcdf.File(path) as file:
        variables = {
            name: (
                one.dimensions,
                str(one.dtype),
                np.asarray(one[...]).tobytes() if one.dtype.kind in "if" else one[...],
                sorted(one.attrs.items()),
            )
            for name, one in file.variables.items()
        }
        return (
            dict(file.attrs),
            {name: dim.size for name, dim in file.dimensions.items()},
            variables,
        )


@pytest.mark.parametrize("at_rest", [False, True])
def test_files_are_laid_out_as_xarray_writes_them(tmp_path, at_rest):
    """Coordinates with and without a channel along them, whole numbers, truth values, an attribute
    of the whole.
    """
    import xarray

    dataset = xarray.Dataset(
        {
            "a": ("sample", [1.0, np.nan]),
            "b": (("sample", "wire_point"), [[1, 2], [3, 4]]),
            "c": ("sample", [True, False]),
        },
        coords={
            "time": ("sample", [0.0, 1.0], {"units": "s"}),
            "coil_number": ("wire_point", [1.0, 2.0]),
            "lonely": ("other", [7.0]),
        },
        attrs={} if at_rest else {"title": "of the whole"},
    )
    if at_rest:
        dataset = dataset.swap_dims(wire_point="coil_number")
    without = {
        name: {"_FillValue": None} for name in dataset.variables if dataset[name].dtype.kind == "f"
    }
    dataset.assign(words=xarray.DataArray(np.array("Ü", dtype=object))).to_netcdf(
        tmp_path / "a.nc", engine="h5netcdf", encoding=without
    )
    netcdf_layout.write_arrays(tmp_path / "b.nc", arrays_of(dataset), {"words": "Ü"})
    assert str(_told(tmp_path / "a.nc")) == str(_told(tmp_path / "b.nc"))


@pytest.mark.parametrize("failure", [OSError("disk full"), KeyboardInterrupt()])
def test_failed_write_leaves_the_old_file_and_no_other(tmp_path, monkeypatch, failure):
    path = netcdf.save_netcdf(_solution(), tmp_path / "run.nc")
    before = path.read_bytes()

    def break_off(self, content):
        with self.open("wb") as stream:
            stream.write(content[: len(content) // 2])
        raise failure

    monkeypatch.setattr(Path, "write_bytes", break_off)
    with pytest.raises(type(failure)):
        netcdf.save_netcdf(_solution(), path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_csv_broken_off_in_the_middle_leaves_nothing(tmp_path, monkeypatch):
    rows = iter(["[0.0]"])

    def written(_):
        if (row := next(rows, None)) is None:
            raise KeyboardInterrupt
        return row

    monkeypatch.setattr(textfile, "repr", written, raising=False)
    with pytest.raises(KeyboardInterrupt):
        textfile.save_csv(_solution(), tmp_path / "run.csv")
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
