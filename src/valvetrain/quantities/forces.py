"""Spring forces of a cycle (extremes raw and band-limited, surge by cam order) the energy
balance of a run, and what its integrator counted.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from valvetrain.arrays import Array
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.quantities.cycle import Cycle, Frame
from valvetrain.quantities.signal import extreme_series, fine_series
from valvetrain.solution.definition import NESTED
from valvetrain.solution.force_peak import ForcePeak, bandwidth_of, force_peak
from valvetrain.solution.result import Solution

#: Channel of an end force -> its part of a quantity's name.
END_FORCES = {"seat_force": "spring_force", "retainer_force": "retainer_force"}
#: Numbers of the integrator that are quantities under the same name, next to every
#: ``peak_..._force`` and ``peak_..._moment``.
COUNTED = (
    "cycle_work_energy", "cycle_dissipated_energy", "spring_dissipated_energy", "contact_friction_dissipated_energy",
    "steady_cycles_count", "steady_residual_ratio", "steady_tolerance_ratio", "motion_period_count", "time_step_duration",
    "steps_per_cycle_count", "minimum_spring_force", "minimum_retainer_force", "peak_spring_force_cam_angle",
    "raw_peak_spring_force_cam_angle",
    "minimum_spring_force_cam_angle", "driver_difference_force",
    "peak_cam_torque", "minimum_cam_torque", "peak_valve_lift", "peak_valve_acceleration", "peak_lever_speed",
)  # fmt: skip
#: Share of peak force times lift below which a spring loses nothing: its sum over the steps has that
#: error.
ROUNDING = 2e-5
#: Front of the names of what differs from cycle to cycle.
SCATTER = "cycle_scatter_"


def fine_of_cycle(cycle: Cycle, channel: str) -> tuple[Array, Array]:
    """Cam angle (rad, from 0) and values of a force over the cycle at the finest stored sampling."""
    _, angle, values = fine_series(cycle.solution, channel)
    mine, begin = within_cycle(cycle, angle)
    return angle[mine] - begin, values[mine]


def extreme_of_cycle(cycle: Cycle, channel: str, kind: str) -> tuple[float, float]:
    """The ``highest`` or ``lowest`` value of a force over the cycle, of every step where they are
    recorded, and its cam angle (rad, from 0).
    """
    angle, values = extreme_series(cycle.solution, channel, kind)
    mine, begin = within_cycle(cycle, angle)
    place = int(np.argmax(values[mine]) if kind == "highest" else np.argmin(values[mine]))
    return float(values[mine][place]), float(angle[mine][place] - begin)


def within_cycle(cycle: Cycle, cam_angle: Array) -> tuple[slice, float]:
    """Slice of a finer record at ``cam_angle`` (rad, unwrapped) that belongs to the cycle, and the
    angle at which the cycle begins.
    """
    begin = float(cycle.solution.cam_angle[cycle.samples.start] - cycle.cam_angle[0])
    return slice(
        int(np.searchsorted(cam_angle, begin - 1e-9)),
        int(np.searchsorted(cam_angle, begin + 2 * np.pi - 1e-9)),
    ), begin


def force_quantities(cycle: Cycle) -> dict[str, float]:
    """Peak force at seat and retainer below the cut-off of the run, and raw with its duration; minimum
    force; of the seat with the cam angles.
    """
    found: dict[str, float] = {}
    for channel, word in END_FORCES.items():
        if not cycle.solution.has(channel):
            continue
        raw, raw_angle = extreme_of_cycle(cycle, channel, "highest")
        least, least_angle = extreme_of_cycle(cycle, channel, "lowest")
        peak = peak_of_cycle(cycle, channel, raw, raw_angle)
        found |= {f"raw_peak_{word}": raw, f"minimum_{word}": least} | peak.quantities(word)
        if channel == "seat_force":
            angles = {"peak": 2 * np.pi * peak.place, "raw_peak": raw_angle, "minimum": least_angle}
            found |= {f"{kind}_{word}_cam_angle": angle for kind, angle in angles.items()}
    return found


def peak_of_cycle(cycle: Cycle, channel: str, raw: float, raw_angle: float) -> ForcePeak:
    """Peak of a force below the cut-off of the run; ``raw`` peak (N) at ``raw_angle`` (rad).

    A whole cycle counts as closed: at its ends the filter sees what the cycle repeats. A part of
    one is closed by its mirror.
    """
    time, angle, series = fine_series(cycle.solution, channel)
    mine, begin = within_cycle(cycle, angle)
    time, values = time[mine], series[mine]
    interval = float(time[-1] - time[0]) / (len(time) - 1)
    even = time[0] + interval * np.arange(len(time))
    if np.max(np.abs(even - time)) > 1e-3 * interval:
        values = np.interp(even, time, values)
    start, turn = float(angle[mine][0] - begin), 2 * np.pi
    if not cycle.whole:
        turn = 2 * len(values) * float(np.ptp(angle[mine])) / (len(values) - 1)
        values = np.append(values, values[::-1])
    cutoff = bandwidth_of(cycle.solution.provenance)
    found = force_peak(values, interval, cutoff, raw, (raw_angle - start) / turn)
    place = found.place if cycle.whole else min(found.place, 1.0 - found.place)
    return replace(found, place=(place * turn + start) / (2 * np.pi) % 1.0)


def lift_quantities(cycle: Cycle, springs: tuple[InstalledSpring, ...]) -> dict[str, float]:
    """Maximum lift (m) of the cycle and the clearance to coil bind."""
    largest = largest_lift(cycle)
    if largest is None:
        return {}
    return {"peak_valve_lift": largest, **bind_clearances(springs, largest)}


def largest_lift(cycle: Cycle) -> float | None:
    """Largest lift (m) of the cycle, of every step where it is recorded; None without a lift."""
    if not cycle.solution.has("valve_lift"):
        return None
    logged = cycle.solution.statistics.get("peak_valve_lift")
    if isinstance(logged, (int, float)):
        return float(logged)
    return float(np.max(cycle.channel("valve_lift")))


def bind_clearances(springs: Sequence[InstalledSpring], largest: float) -> dict[str, float]:
    """Clearances (m) to coil bind at the ``largest`` lift (m), the least of all springs; of a pair those of each too."""
    found: dict[str, float] = {}
    for spring in springs:
        for name, left in spring.clearances(largest).items():
            found[name] = min(left, found.get(name, left))
            if len(springs) > 1 and spring.name in NESTED:
                found[f"{spring.name}_{name}"] = left
    return found


_CHANNELS = ("kinetic_energy", "elastic_energy", "work_done", "energy_dissipated")


def energy_quantities(solution: Solution, cycle: Cycle | None) -> dict[str, float]:
    """Energy imbalance and the energy turned to heat (J): in the whole run and, of a whole cycle,
    by the springs' damping. Nothing of a model without energies.

    The imbalance is stored energy plus heat less work, from the first sample on, over the span of the work.
    """
    if not solution.has(*_CHANNELS):
        return {}
    kinetic, elastic, work, heat = (solution.channel(name) for name in _CHANNELS)
    stored = kinetic + elastic
    if solution.has("contact_energy"):
        stored = stored + solution.channel("contact_energy")
    heat = heat - heat[0]
    scale = float(np.ptp(work))
    # zero where no work was done and none is missing
    imbalance = np.abs(stored - stored[0] + heat - (work - work[0]))
    largest = float(np.max(imbalance, initial=0.0))
    found = {
        "energy_imbalance_ratio": largest / scale if scale > 0 else largest,
        "dissipated_energy": float(heat[-1]),
    }
    if cycle is not None and cycle.whole:
        start, end = cycle.samples.start, cycle.samples.stop
        last = (
            heat[end] if end < len(heat) else 2 * heat[-1] - heat[-2]
        )  # the sample that closes it
        found["cycle_damper_energy"] = float(last - heat[start])
    return found


#: Cam orders whose amplitude is a quantity.
ORDERS = 40
#: Surge shows in the cam orders within this share of its own, below and above.
SURGE_BAND = (0.5, 1.5)
#: Share of the largest force below which no order makes the surge: it is chance.
SURGES = 2e-3


def order_amplitudes(cam_angle: Array, values: Array) -> Array:
    """Amplitude (0 to peak) of every order of ``values`` over one turn; ``cam_angle`` (rad)
    ascending.
    """
    count = len(cam_angle)
    even = np.arange(count) * 2 * np.pi / count
    amplitude: Array = (
        np.abs(np.fft.rfft(np.interp(even, cam_angle, values, period=2 * np.pi))) / count
    )
    amplitude[1 : (count + 1) // 2] *= 2
    return amplitude


def surge_engine_speeds(
    natural_frequency: float, lowest: float, highest: float
) -> dict[str, float]:
    """Engine speeds (rad/s) from ``lowest`` to ``highest`` at which a cam order, to :data:`ORDERS`,
    meets a natural frequency (Hz).

    By order: 4 pi f / n, where harmonic n of the lift turns n times as fast as the cam.
    """
    met = {n: 4 * np.pi * natural_frequency / n for n in range(1, ORDERS + 1)}
    return {
        f"surge_order_{n}_engine_speed": speed
        for n, speed in met.items()
        if lowest <= speed <= highest
    }


def surge_residual(cycle: Cycle, frame: Frame) -> tuple[Array, Array] | None:
    """Cam angle (rad) and seat force less the static force at the same lift (N) over the cycle, at
    the finest stored sampling.

    None where either force is not known. Output samples alone would fold the clashes' high
    frequencies into the low orders.
    """
    solution = cycle.solution
    if not solution.has("seat_force", "valve_lift"):
        return None
    known = solution.has("static_retainer_force")
    static = (
        cycle.channel("static_retainer_force")
        if known
        else frame.static_force(cycle.channel("valve_lift"), solution.model)
    )
    if static is None:
        return None
    angle, force = fine_of_cycle(cycle, "seat_force")
    return angle, force - np.interp(angle, cycle.cam_angle, static, period=2 * np.pi)


def surge_quantities(cycle: Cycle, frame: Frame) -> dict[str, float]:
    """Surge frequency, its cam order, the nearest harmonic of the lift, and the surge in the seat
    force by cam order.
    """
    found: dict[str, float] = {}
    residual, highest = surge_residual(cycle, frame), frame.surge_frequency
    amplitude = None if residual is None else order_amplitudes(*residual)
    if amplitude is not None:
        found |= {
            f"surge_order_{order}_force": float(size)
            for order, size in enumerate(amplitude[: ORDERS + 1])
            if order > 0
        }
    if highest is None or not cycle.solution.engine_speed > 0:
        return found
    place = highest * 2 * np.pi / (cycle.solution.engine_speed / 2)
    found |= {"surge_frequency": highest, "surge_cam_order": place}
    if len(frame.surge_frequencies) == len(cycle.solution.springs) > 1:
        found |= {
            f"{name}_surge_frequency": one
            for name, one in zip(cycle.solution.springs, frame.surge_frequencies, strict=True)
        }
    if frame.valve_lift is not None:
        nearest = max(1, round(place))
        found |= {
            "nearest_lift_harmonic_order": float(nearest),
            "nearest_lift_harmonic_lift": float(lift_harmonics(frame.valve_lift, nearest)[-1]),
        }
    first, last = int(np.ceil(SURGE_BAND[0] * place)), int(np.floor(SURGE_BAND[1] * place))
    if amplitude is not None and max(first, 1) <= last < len(amplitude):
        band = amplitude[max(first, 1) : last + 1]
        size = found["surge_amplitude_force"] = float(np.max(band))
        load = float(np.max(np.abs(cycle.channel("seat_force"))))
        if size > SURGES * load:
            found["surge_amplitude_cam_order"] = float(max(first, 1) + np.argmax(band))
    return found


def lift_harmonics(valve_lift: Callable[[Array], Array], highest: int = ORDERS) -> Array:
    """Amplitudes (m, 0 to peak) of the cam harmonics of a lift, by order from 0 to ``highest``."""
    count = max(4096, 16 * highest)
    lift = valve_lift(np.arange(count) * 2 * np.pi / count)
    return np.asarray(2 * np.abs(np.fft.rfft(lift)[: highest + 1]) / count)


def counted_quantities(solution: Solution) -> dict[str, float]:
    """Numbers that only the integrator could see: every step's peaks, work and losses, the way to
    the steady state.
    """
    peak = re.compile("(raw_)?peak_.*_(force|moment)(_duration)?")
    counted = {
        name: value
        for name, value in solution.statistics.items()
        if isinstance(value, (int, float))
    }
    found = {
        name: float(value)
        for name, value in counted.items()
        if name in COUNTED or name.startswith(SCATTER) or peak.fullmatch(name)
    }
    if "spring_dissipated_energy" in found:
        moved = found.get("peak_retainer_force", 0.0) * found.get("peak_valve_lift", 0.0)
        if abs(found["spring_dissipated_energy"]) < ROUNDING * moved:
            found["spring_dissipated_energy"] = 0.0
        found["cycle_damper_energy"] = found["spring_dissipated_energy"]
    return found
