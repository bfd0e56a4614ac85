"""Unit: rules of recordings, scans and traces: which cycles are whole, which points and samples
count, what is read at all.
"""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from valvetrain.errors import InputError
from valvetrain.rig import array_formats as text
from valvetrain.rig.array_formats import channels_of
from valvetrain.rig.cutting import grid_of
from valvetrain.rig.gauge import finest_trace
from valvetrain.rig.result import student
from valvetrain.rig.shaft import ShaftAngle
from valvetrain.scan import axis as sections
from valvetrain.scan import fit as ends
from valvetrain.scan.axis import WEDGES, follow

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


def kept(samples: int, parts: int, known: tuple[str, ...]):
    """A run that keeps t^2 at even times from 5 s on, at ``parts`` points a sample, and extremes
    between them.
    """
    time = 5.0 + 0.1 * np.arange(samples)
    share = time[:, None] + 0.1 * np.arange(parts) / parts
    at = np.array([5.02, 5.537, np.nan, 4.0, 5.1])
    arrays = {
        "force": time**2,
        "force_fine": share**2,
        "force_highest": at**2,
        "force_highest_time": at,
        "force_lowest": (at + 0.011) ** 2,
        "force_lowest_time": at + 0.011,
    }
    return SimpleNamespace(
        time=time, cam_angle=time, has=("force", *known).__contains__, channel=arrays.__getitem__
    )


@pytest.mark.parametrize(
    ("known", "parts", "extremes"),
    [
        ((), 1, ()),
        (("force_fine",), 1, ()),
        (("force_fine",), 4, ()),
        (("force_highest", "force_highest_time"), 1, (5.02, 5.537)),
        (("force_fine", "force_lowest", "force_lowest_time"), 4, (5.031, 5.111, 5.548)),
    ],
)
def test_the_finest_trace_holds_all_that_a_run_keeps_of_a_channel(known, parts, extremes):
    """Samples, points between them and extremes, each once and in order; extremes outside, unknown
    or on a point add none.
    """
    time, values, spacing = finest_trace(kept(9, parts, known), "force")
    even = 5.0 + 0.1 / parts * np.arange(8 * parts + 1)
    assert time == pytest.approx(np.sort(np.concatenate([even, extremes])), abs=1e-12)
    assert values == pytest.approx(time**2) and spacing == pytest.approx(0.1 / parts)


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("stray", [0, 80])
def test_a_ground_face_is_laid_through_all_points_of_its_scatter_and_no_others(
    side, stray, monkeypatch
):
    """2000 points on a plane at 30 mm with a scatter of 0.03 mm, all amid the ground section;
    strays lie 0.4 mm inside the wire.
    """
    draw = np.random.default_rng(7)
    radius, angle = draw.uniform(8.0, 16.0, 2000 + stray), draw.uniform(0, 2 * np.pi, 2000 + stray)
    height = (
        30.0 + draw.normal(0.0, 0.03, 2000 + stray) - 0.4 * side * (np.arange(2000 + stray) >= 2000)
    )
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
    monkeypatch.setattr(
        ends,
        "place",
        lambda tube, points, reach: SimpleNamespace(distance=np.full(len(points), 0.5)),
    )
    monkeypatch.setattr(
        ends, "_in_section", lambda tube, face, points, turn: (0.0 * turn, np.ones(len(turn)))
    )
    face = ends.find_face(
        SimpleNamespace(section=np.array([2.0]), noise=0.03, hand=1), points, 0.0, side, (0.0, 6.0)
    )
    assert 1985 <= face.points <= 2000
    assert (
        face.height == pytest.approx(30.0, abs=4 * 0.03 / np.sqrt(2000))
        and np.hypot(*face.lean) < 4e-4
    )


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


@pytest.mark.parametrize("unit", TIMES)
def test_times_of_a_text_count_in_the_unit_of_their_heading(tmp_path, unit):
    head = f"time [{unit}]" if unit else "time"
    path = tmp_path / "own.csv"
    path.write_text(
        "\n".join([f"{head},force [N]", *(f"{3 * place},{10 + place}" for place in range(20))])
        + "\n",
        encoding="utf-8",
    )
    (force,) = text.read_text(path, path.name).channels
    assert force.times == pytest.approx(
        3 * TIMES[unit] * np.arange(20)
    ) and force.values == pytest.approx(10.0 + np.arange(20))
    assert (force.name, force.unit) == ("force", "N")


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


@pytest.mark.parametrize("hand", [1, -1])
@pytest.mark.parametrize("begin", [1, 32, 63])
@pytest.mark.parametrize(("count", "whole"), [(90, False), (125, False), (131, True), (200, True)])
def test_a_wire_is_followed_over_two_turns_at_least_wherever_it_begins(hand, begin, count, whole):
    """Sections of a helix of pitch 6 mm that begin in any half plane."""
    step = np.arange(count)
    plane = np.column_stack([np.full(count, 12e-3), 6e-3 * step / WEDGES])
    wedge = np.mod(hand * (begin + step), WEDGES)
    found = sections.Sections(wedge, plane, 1.5e-3)
    if not whole:
        with pytest.raises(InputError, match=f"over {(count - 1) / WEDGES:.2g} turns only"):
            follow(found)
        return
    trace = follow(found)
    assert trace.hand == hand
    assert np.diff(trace.turn) == pytest.approx(np.full(count - 1, 1 / WEDGES))
    assert trace.height == pytest.approx(6e-3 * step / WEDGES)
