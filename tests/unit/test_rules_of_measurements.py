"""Unit: rules of recordings, scans and traces: which cycles are whole, which points and samples
count, what is read at all.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from valvetrain.errors import InputError
from valvetrain.rig import array_formats as text
from valvetrain.rig.array_formats import channels_of
from valvetrain.rig.cutting import grid_of
from valvetrain.rig.result import student
from valvetrain.rig.shaft import ShaftAngle

TURN = 2 * np.pi


@pytest.mark.parametrize("begin", [-3.0, 0.0, 0.25, 100.0])
@pytest.mark.parametrize("reach", [0.0, 0.05, 0.1, 0.3])
@pytest.mark.parametrize(("late", "early"), [(0.0, 0.0), (0.2, 0.0), (0.0, 0.2), (0.2, 0.2)])
def test_cycles_lie_within_the_recording_by_the_reach_of_the_filter_wherever_time_begins(
    begin, reach, late, early
):
    """Five cam turns of 0.2 s, marks at the turns; the shaft is told ``late`` s after the recording
    begins, until ``early`` s before.
    """
    times = begin + np.linspace(late, 1.0 - early, 101)
    shaft = ShaftAngle(times, (times - begin) / 0.2 * TURN)
    first, last = max(reach, late), 1.0 - max(reach, early)
    due = 0.2 * np.arange(np.ceil(first / 0.2 - 1e-6), np.floor(last / 0.2 + 1e-6) + 1)
    found = grid_of(shaft, 90, 0.0, reach, (begin, begin + 1.0))
    assert found.cut_times - begin == pytest.approx(due, abs=1e-9)
    assert found.times[:, 0] - begin == pytest.approx(due[:-1], abs=1e-9)
    assert found.cam_speeds == pytest.approx(np.full(len(due) - 1, TURN / 0.2))


def test_a_recording_shorter_than_its_filter_reaches_has_no_cycle():
    times = 50.0 + np.linspace(0.0, 1.0, 101)
    with pytest.raises(InputError, match="shorter than the filter needs"):
        grid_of(ShaftAngle(times, (times - 50.0) / 0.2 * TURN), 90, 0.0, 0.5, (50.0, 51.0))


@pytest.mark.parametrize("count", [*range(2, 41), 60, 120, 1000])
def test_the_factor_of_a_mean_is_that_of_students_distribution(count):
    """The table to its last digit, the formula beyond it to 0.3 %."""
    assert student(count) == pytest.approx(
        stats.t.ppf(0.975, count - 1), rel=3e-4 if count <= 20 else 3e-3
    )


@pytest.mark.parametrize("count", [0, 1])
def test_one_value_says_nothing_of_its_mean(count):
    assert student(count) == np.inf


#: Units of times as files write them, in seconds.
TIMES = {"s": 1.0, "sec": 1.0, "": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9, "min": 60.0}
LONGER = {
    "seconds": 1.0,
    "milliseconds": 1e-3,
    "microseconds since 2026-01-01": 1e-6,
    "nanoseconds since 1970-01-01 00:00": 1e-9,
    " ms ": 1e-3,
    "seconds since midnight": 1.0,
    "minutes": 60.0,
}


@pytest.mark.parametrize(("unit", "factor"), [*TIMES.items(), *LONGER.items()])
def test_times_of_arrays_count_in_the_unit_that_stands_beside_them(unit, factor):
    arrays = {
        "time": 3.0 * np.arange(20),
        "force": np.arange(20.0),
        "short": np.arange(7.0),
        "rate": np.array([[250.0]]),
    }
    (force, short), scalars = channels_of(arrays, {"time": unit, "force": "N"})
    assert (
        force.times == pytest.approx(3 * factor * np.arange(20))
        and short.times is None
        and scalars == {"rate": 250.0}
    )
    assert (force.name, force.unit, short.unit) == ("force", "N", "")


@pytest.mark.parametrize(
    ("name", "unit"),
    [("t", "degC"), ("T", "K"), ("oil_T", "degC"), ("coolant T", "°C"), ("engine/t", "N m")],
)
def test_a_temperature_called_t_is_a_channel_like_any_other(name, unit, tmp_path):
    """It was left out, or taken for the times of all others."""
    arrays = {name: 80.0 + np.arange(20), "time": 2.0 * np.arange(20), "force": np.arange(20.0)}
    (path := tmp_path / "own.csv").write_text(
        "\n".join(
            [
                f"{name} [{unit}],time [ms],force [N]",
                *(f"{80 + place},{2 * place},{place}" for place in range(20)),
            ]
        )
        + "\n",
        encoding="utf-8",
    )
    of_arrays, _ = channels_of(arrays, {name: unit, "time": "ms", "force": "N"})
    for heat, force in (of_arrays, text.read_text(path, path.name).channels):
        assert (heat.name, heat.unit, force.name) == (name, unit, "force")
        assert heat.values == pytest.approx(80.0 + np.arange(20))
        assert all(one.times == pytest.approx(2e-3 * np.arange(20)) for one in (heat, force))


@pytest.mark.parametrize("unit", ["mm", "days", "cycles", "deg", "days since 1900-01-01"])
def test_times_in_a_unit_that_is_none_of_time_are_refused(unit):
    with pytest.raises(InputError, match="none of time; write s, ms or us"):
        channels_of({"time": np.arange(9.0), "force": np.arange(9.0)}, {"time": unit})


@pytest.mark.parametrize(
    ("line", "rate"),
    [
        ("sampling rate: 5000 Hz", 5e3),
        ("Sample rate = 20 kHz", 2e4),
        ("fs: 2.5e3 S/s", 2.5e3),
        ("rate=400 1/s", 400.0),
        ("rate: fast", None),
        ("heart rate: 70 Hz", None),
    ],
)
def test_the_sampling_rate_of_a_text_stands_in_its_heading(tmp_path, line, rate):
    path = tmp_path / "own.csv"
    path.write_text(
        "\n".join(
            [f"# {line}", "force [N],lift [mm]", *(f"{place},{2 * place}" for place in range(20))]
        )
        + "\n",
        encoding="utf-8",
    )
    found = text.read_text(path, path.name)
    assert found.scalars == ({} if rate is None else {"sampling_rate": rate})
    _, lift = found.channels
    assert (
        (lift.name, lift.unit) == ("lift", "mm")
        and lift.times is None
        and lift.values == pytest.approx(2.0 * np.arange(20))
    )
