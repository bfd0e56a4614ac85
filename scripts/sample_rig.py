"""Writes small recordings as a test rig makes them, from a known motion: one file in each format,
all marked synthetic.

Use: python scripts/sample_rig.py FOLDER

Truth is a simulation (valve lift and spring force of a shipped case over the cam angle). Added to
it: speed that varies from turn to turn
and within a turn, jitter and a missing tooth of the encoder, noise, a drift of the force, one cycle
that slipped.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TURN = 2 * np.pi


@dataclass(frozen=True)
class Rig:
    """How the rig records: speeds in rad/s of the cam, times in s, shares without unit."""

    cam_speed: float = TURN * 25.0
    cycles: int = 12
    sampling_rate: float = 50e3
    teeth: int = 60
    missing: int = 1
    turn_variation: float = 0.01
    drift_of_speed: float = 0.02
    jitter: float = 2e-7
    force_noise: float = 4.0
    lift_noise: float = 4e-6
    force_drift: float = 30.0
    force_offset: float = 55.0
    slipped: int = -9
    begin: float = 1.0
    seed: int = 5


@dataclass(frozen=True)
class Records:
    """What was recorded: times (s), force (N), lift (m), pulses of the crank wheel (V), pulse once
    a cam turn (V), cam angle (rad).
    """

    rig: Rig
    times: Array
    force: Array
    lift: Array
    pulses: Array
    once: Array
    cam_angle: Array

    @property
    def encoder(self) -> Array:
        """Angle of an encoder on the crank in steps of a tenth of a degree, 0 to 720 degrees."""
        return np.floor(np.degrees(2 * self.cam_angle) % 720 * 10 + 1e-9) / 10


def cam_angle_at(rig: Rig, times: Array) -> Array:
    """Cam angle (rad): mean speed, a slow rise of it, and a part that repeats twice a turn."""
    length = rig.cycles * TURN / rig.cam_speed
    mean = rig.cam_speed * times * (1 + rig.drift_of_speed * (times / length - 1) / 2)
    return mean + rig.turn_variation / 2 * np.sin(2 * mean) - rig.begin


def record(rig: Rig, lift: Callable[[Array], Array], force: Callable[[Array], Array]) -> Records:
    """Sample the ``lift`` (m) and ``force`` (N) over the cam angle (rad, periodic) as the rig does."""
    random = np.random.default_rng(rig.seed)
    length = (rig.cycles + 0.4) * TURN / rig.cam_speed
    times = np.arange(int(length * rig.sampling_rate)) / rig.sampling_rate
    angle = cam_angle_at(rig, times)
    cycle = np.floor(angle / TURN).astype(int)
    forces = force(angle % TURN) + rig.force_offset + rig.force_drift * times / length
    forces = np.where(cycle == rig.slipped, 1.08 * forces, forces) + random.normal(
        0, rig.force_noise, len(times)
    )
    lifts = lift(angle % TURN) + random.normal(0, rig.lift_noise, len(times))
    jittered = cam_angle_at(rig, times + random.normal(0, rig.jitter, len(times)))
    tooth = 2 * jittered / TURN * rig.teeth
    up = (tooth % 1.0) < 0.5
    there = np.floor(tooth) % rig.teeth < rig.teeth - rig.missing
    once = (jittered % TURN) < 0.05
    return Records(
        rig, times, forces, lifts, np.where(up & there, 5.0, 0.0), np.where(once, 5.0, 0.0), angle
    )


def columns(records: Records) -> list[tuple[str, str, Array]]:
    """Name, unit and values of each channel, in the units of a rig."""
    return [
        ("Spring force", "kN", 1e-3 * records.force),
        ("Valve lift", "mm", 1e3 * records.lift),
        ("Crank wheel", "V", records.pulses),
        ("Cam pulse", "V", records.once),
        ("Crank angle", "deg", records.encoder),
    ]


def write_csv(path: Path, records: Records) -> None:
    """Text with semicolons."""
    head = [
        "# synthetic: computed, not measured",
        ";".join(["Time [s]", *(f"{name} [{unit}]" for name, unit, _ in columns(records))]),
    ]
    rows = np.column_stack([records.times, *(values for _, _, values in columns(records))])
    path.write_text(
        "\n".join([*head, *(";".join(f"{value:.7g}" for value in row) for row in rows)]) + "\n",
        encoding="utf-8",
    )


def write_mdf(path: Path, records: Records) -> None:
    """MDF 4, the force with a linear conversion of 16 bit counts as amplifiers store it."""
    from asammdf import MDF, Signal

    signals = []
    for name, unit, values in columns(records):
        if name == "Spring force":
            scale = 4.0 / 32767
            counts = np.round(values / scale).astype(np.int16)
            signals.append(
                Signal(counts, records.times, unit, name, conversion={"a": scale, "b": 0.0})
            )
        else:
            signals.append(Signal(values, records.times, unit, name))
    with MDF(version="4.10") as file:
        file.header.comment = "synthetic: computed, not measured"
        file.append(signals, comment="rig")
        file.save(path, overwrite=True)


def write_tdms(path: Path, records: Records, segments: int = 3) -> None:
    """TDMS in several segments."""
    from nptdms import ChannelObject, RootObject, TdmsWriter

    step = 1 / records.rig.sampling_rate
    with TdmsWriter(str(path)) as file:
        for part in np.array_split(np.arange(len(records.times)), segments):
            told = {"wf_increment": step, "wf_start_offset": 0.0}
            file.write_segment(
                [
                    RootObject({"description": "synthetic: computed, not measured"}),
                    *(
                        ChannelObject("rig", name, values[part], told | {"unit_string": unit})
                        for name, unit, values in columns(records)
                    ),
                ]
            )


def write_mat(path: Path, records: Records) -> None:
    """MAT 7 (compressed), units as texts beside."""
    from scipy import io

    held: dict[str, object] = {
        "description": "synthetic: computed, not measured",
        "time": records.times,
    }
    for name, unit, values in columns(records):
        held |= {name.replace(" ", "_"): values, f"{name.replace(' ', '_')}_unit": unit}
    io.savemat(path, held, do_compression=True)


def write_hdf5(path: Path, records: Records) -> None:
    """HDF5 laid out as MAT 7.3 does: rows of one column, a class on each, texts as 16 bit codes."""
    import h5py

    def coded(text: str) -> Array:
        return np.array([[ord(letter)] for letter in text], dtype=np.uint16)

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, unit, values in [("time", "s", records.times), *columns(records)]:
            word = name.replace(" ", "_")
            file.create_dataset(word, data=values[np.newaxis, :], compression="gzip").attrs[
                "MATLAB_class"
            ] = np.bytes_("double")
            if word != "time":
                file.create_dataset(f"{word}_unit", data=coded(unit)).attrs["MATLAB_class"] = (
                    np.bytes_("char")
                )
        file.create_dataset("description", data=coded("synthetic: computed")).attrs[
            "MATLAB_class"
        ] = np.bytes_("char")


def write_netcdf(path: Path, records: Records) -> None:
    """NetCDF-4."""
    import h5netcdf

    with h5netcdf.File(path, "w") as file:
        file.attrs["title"] = "synthetic: computed, not measured"
        file.dimensions = {"time": len(records.times)}
        for name, unit, values in [("time", "s", records.times), *columns(records)]:
            made = file.create_variable(name.replace(" ", "_"), ("time",), float)
            made.attrs["units"] = unit
            made[...] = values


def write_uff(path: Path, records: Records, binary: bool = False) -> None:
    """Universal file 58, as text or in binary."""
    import pyuff

    path.unlink(missing_ok=True)
    file = pyuff.UFF(str(path))
    for name, unit, values in columns(records):
        held = pyuff.prepare_58(
            binary=int(binary),
            func_type=1,
            rsp_node=1,
            rsp_dir=1,
            ref_node=1,
            ref_dir=1,
            data=values,
            x=records.times,
            id1=name,
            id2="synthetic: computed",
            id3="NONE",
            id4="NONE",
            id5="NONE",
            abscissa_spacing=1,
            abscissa_inc=1 / records.rig.sampling_rate,
            abscissa_min=0.0,
            num_pts=len(values),
            ord_data_type=4,
            ordinate_axis_units_lab=unit,
            abscissa_axis_units_lab="s",
            abscissa_spec_data_type=17,
            ordinate_spec_data_type=13,
            orddenom_spec_data_type=0,
            z_axis_spec_data_type=0,
        )
        file.write_sets(held | {"ordinate_axis_lab": name}, "add")


#: Name of the file -> its writer.
WRITERS: dict[str, Callable[[Path, Records], None]] = {
    "rig.csv": write_csv, "rig.mf4": write_mdf, "rig.tdms": write_tdms, "rig.mat": write_mat, "rig-v73.mat": write_hdf5,
    "rig.nc": write_netcdf, "rig.uff": write_uff,
    "rig-binary.uff": lambda path, records: write_uff(path, records, True),
}  # fmt: skip


def simulated(
    engine_speed: str = "3000 rpm",
) -> tuple[Callable[[Array], Array], Callable[[Array], Array]]:
    """Valve lift (m) and spring force (N) over the cam angle (rad) of the shipped case job-t, last
    cycle of its run.
    """
    import valvetrain as vt

    (run,) = vt.simulate("job-t", engine_speed, models=["multi-mass"]).solutions
    angle, lift, force = run.cam_angle, run.channel("valve_lift"), run.channel("retainer_force")
    last = angle >= angle[-1] - TURN
    order = np.argsort(angle[last] % TURN)
    grid = (angle[last] % TURN)[order]
    return (lambda at: np.interp(at, grid, lift[last][order], period=TURN)), (
        lambda at: np.interp(at, grid, force[last][order], period=TURN)
    )


def main(folder: Path) -> None:
    """Write a recording in each format."""
    folder.mkdir(parents=True, exist_ok=True)
    lift, force = simulated()
    records = record(Rig(slipped=7), lift, force)
    for name, write in WRITERS.items():
        write(folder / name, records)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
