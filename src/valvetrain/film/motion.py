"""From a film to the motion of the coils: displacements over the cam angle, peaks along the spring,
surge lines and their damping.
"""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.film.cycles import (
    TURN,
    CamPhase,
    CoilPeak,
    Lift,
    by_lift,
    by_marker,
    by_speed,
    camera_drift,
    closed_window,
    mean_of,
    on_grid,
    peaks,
    segments,
    whole_turns,
)
from valvetrain.film.frames import Film, Picture, open_film
from valvetrain.film.result import CoilMotion, blur_text, drift_text
from valvetrain.film.setup import FilmSetup
from valvetrain.film.space_time import SightLine, SpaceTime, find_line, read_space_time
from valvetrain.film.surge import fit_surge, spectrum
from valvetrain.film.tracks import Tracks, track
from valvetrain.measured.cycles import MeasuredCycles

Array = NDArray[np.float64]
#: Cam angles of the written curves where none are requested: whole degrees.
ANGLES = 360
#: Uncertainty (px) with which a point of the scale is picked.
PICKED = 0.5
NO_SCALE = "the scale is not known: give two points of the picture and their distance, such as the edges of the two seats"


def coil_motion(
    film: str | os.PathLike[str] | Picture,
    setup: FilmSetup,
    valve_lift: Lift | None = None,
    curve_angles: int = ANGLES,
    synthetic: bool = False,
) -> CoilMotion:
    """The motion of the coils of a valve spring in a high-speed film, by the glare line that a lamp
    makes on each coil.

    Parameters
    ----------
    film : a video that OpenCV reads, a folder of pictures, or an array of grey levels (frames,
        rows, columns)
    setup : how it was filmed: rate, line, scale, phase
    valve_lift : lift (m) over the cam angle (rad) of the valve, for the phase where no marker gives it
        it
    curve_angles : number of cam angles of the written curves; nothing else depends on it
    synthetic : the film was computed, not taken

    Returns
    -------
    CoilMotion

    Raises
    ------
    InputError : one sentence on what cannot be read, is not given, or shows no coils

    Examples
    --------
    >>> import numpy as np
    >>> rows, frame = np.arange(80.0)[:, None], np.arange(120)[:, None, None]
    >>> moved = 3 * np.exp(-0.01 * frame) * np.cos(2 * np.pi * 0.2 * frame)
    >>> film = sum(np.exp(-(((rows - 20 * k - moved * (k in (2, 3))) / 2) ** 2)) for k in (1, 2, 3)) * np.ones((1, 1, 9)) * 100.0
    >>> found = coil_motion(film, FilmSetup(frame_rate=2000, scale_points=((4, 0), (4, 50)), scale_length="10 mm", free_decay=True))
    >>> found
    CoilMotion of array: 3 coils in 120 frames, free decay
    >>> f"{found.surge.lines[0].natural_frequency:.1f} Hz, damping ratio {found.surge.lines[0].damping_ratio:.4f}"
    '400.0 Hz, damping ratio 0.0080'
    """
    if not 24 <= curve_angles <= 36_000:
        raise InputError(
            f"curves of {curve_angles} cam angles are none; take 24 to 36000", "curve_angles"
        )
    opened = open_film(film)
    if (
        not setup.free_decay
        and setup.marker is None
        and setup.cam_speed is None
        and valve_lift is None
    ):
        raise InputError(
            "the cam angle is not known: give a marker's place, the cam speed, or the lift; or say that the spring decays freely",
            "marker",
        )
    if setup.scale_points is None and valve_lift is None:
        raise InputError(NO_SCALE, "scale_points")
    line, chosen = _line(opened, setup)
    seen = read_space_time(
        opened,
        line,
        setup.frame_rate,
        setup.marker,
        setup.marker_radius,
        setup.first_frame,
        setup.last_frame,
    )
    return _motion(
        seen, track(seen, setup.coils), setup, valve_lift, curve_angles, synthetic, chosen
    )


def _line(film: Film, setup: FilmSetup) -> tuple[SightLine, tuple[str, ...]]:
    if setup.line is not None:
        return SightLine(*setup.line, setup.line_width, setup.samples_across), ()
    line = find_line(film, setup.line_width, setup.samples_across)
    (x, y), (x_end, y_end) = line.start, line.end
    return line, (
        f"the line was chosen where highlights are clearest: from {x:g}, {y:g} to {x_end:g}, {y_end:g} px",
    )


def _motion(
    seen: SpaceTime,
    tracks: Tracks,
    setup: FilmSetup,
    lift: Lift | None,
    angles: int,
    synthetic: bool,
    notes: tuple[str, ...],
) -> CoilMotion:
    tracks, towards, said = _from_the_seat(tracks, setup.seat)
    phase = None if setup.free_decay else _phase(seen, towards * tracks.places[:, -1], setup, lift)
    drift, still = camera_drift(
        tracks.places, seen.time, None if phase is None else phase.cam_angle
    )
    if phase is not None and phase.zero_by == "lift":  # the drift was in what was laid on the lift
        phase = _phase(seen, towards * (tracks.places[:, -1] - drift), setup, lift)
    places = tracks.places - drift[:, None]
    notes = (
        *seen.notes,
        *notes,
        *tracks.notes,
        *said,
        *drift_text(drift, still),
        *(() if phase is None else phase.notes),
    )
    scale, scale_spread, sentence = _scale(setup, phase)
    moved = towards * scale * places
    spread = scale * tracks.spread
    grid = np.arange(angles) * TURN / angles
    cycles: tuple[MeasuredCycles, ...] = ()
    found: tuple[CoilPeak, ...] = ()
    if phase is None:
        whole = np.arange(len(moved))
        moved = moved - np.nanmean(moved, axis=0)
        surge = fit_surge(moved, _without_gaps(whole, seen.number), seen.frame_rate)
        dwell = None
    else:
        turns = whole_turns(phase.cam_angle)
        dwell = setup.dwell
        if dwell is None:
            dwell = closed_window(
                grid, mean_of(on_grid(phase.cam_angle, moved[:, -1], turns, grid))
            )
        closed = segments(phase.cam_angle, seen.number, dwell)
        moved = moved - _rest(moved, closed, phase.cam_angle, dwell)
        surge = fit_surge(moved, closed, seen.frame_rate)
        found = peaks(phase.cam_angle, moved, spread, turns)
        cycles = _cycles(seen, phase, moved, turns, grid, synthetic, sentence)
    if surge is not None:
        notes += blur_text(surge, setup.exposure)
    return CoilMotion(
        seen,
        places,
        tracks.spread,
        tracks.merged,
        moved,
        phase,
        cycles,
        found,
        dwell,
        surge,
        *spectrum(moved, seen.number, seen.frame_rate),
        scale,
        scale_spread,
        drift,
        (*notes, *sentence),
    )


def _from_the_seat(tracks: Tracks, seat: str) -> tuple[Tracks, float, tuple[str, ...]]:
    """Coils counted from the seat's end, and the sign of a motion towards it along the line."""
    said: tuple[str, ...] = ()
    if not seat:
        size = np.nanstd(tracks.places, axis=0)
        seat = "start" if size[0] < size[-1] else "end"
        if abs(size[0] - size[-1]) < 0.25 * size.max():
            said = (
                f"both ends of the spring move alike, so its seat is taken to be at the {seat} of the line; correct it if it is not",
            )
    if seat == "start":
        return tracks, -1.0, said
    turned = replace(
        tracks,
        places=tracks.places[:, ::-1],
        spread=tracks.spread[:, ::-1],
        merged=tracks.merged[:, ::-1],
    )
    return turned, 1.0, said


def _phase(seen: SpaceTime, moved: Array, setup: FilmSetup, lift: Lift | None) -> CamPhase:
    if setup.marker is not None:
        phase = by_marker(seen.time, seen.marker, setup.marker_angle or 0.0, setup.cam_speed)
        if setup.marker_angle is None and lift is None:
            phase = replace(phase, zero_by="nobody")
        return (
            phase
            if setup.marker_angle is not None or lift is None
            else _zero_by_lift(phase, seen.time, moved, lift)
        )
    if lift is not None and setup.first_angle is None:
        return by_lift(seen.time, moved, lift, setup.cam_speed)
    if setup.cam_speed is None:
        raise InputError(
            "an angle of the first frame needs the cam speed too; give it", "cam_speed"
        )
    phase = by_speed(seen.time, setup.cam_speed, setup.first_angle or 0.0)
    return phase if setup.first_angle is not None else replace(phase, zero_by="nobody")


def _zero_by_lift(phase: CamPhase, time: Array, moved: Array, lift: Lift) -> CamPhase:
    """Speed by the marker, zero of the cam angle by the lift."""
    found = by_lift(time, moved, lift, phase.cam_speed)
    off = float(np.mean(np.unwrap(np.mod(found.cam_angle - phase.cam_angle, TURN))))
    sentence = "the marker gives the speed, the lift the zero of the cam angle"
    return replace(
        phase,
        cam_angle=phase.cam_angle + off,
        metres_per_pixel=found.metres_per_pixel,
        notes=(*phase.notes, sentence),
        zero_by="lift",
    )


def _scale(setup: FilmSetup, phase: CamPhase | None) -> tuple[float, float, tuple[str, ...]]:
    """Metres a pixel, standard deviation, and what is said of it."""
    if setup.scale_points is not None:
        assert setup.scale_length is not None
        scale = setup.metres_per_pixel
        share = np.sqrt(2) * PICKED * scale / setup.scale_length
        return (
            scale,
            float(share * scale),
            (
                f"the scale is {1e3 * scale:.5g} mm a pixel, within {100 * share:.2g} % as far as points are picked",
            ),
        )
    if phase is not None and phase.metres_per_pixel > 0:
        sentence = "the scale makes the uppermost coil move as far as the lift, too large a scale where that coil is not the retainer's"
        return phase.metres_per_pixel, 0.0, (sentence,)
    raise InputError(NO_SCALE, "scale_points")


def _without_gaps(frames: NDArray[np.int64], number: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """The longest stretch of frames without a lost one."""
    parts = np.split(frames, np.flatnonzero(np.diff(number) > 1) + 1)
    return [max(parts, key=len)]


def _rest(
    moved: Array, closed: list[NDArray[np.int64]], cam_angle: Array, dwell: tuple[float, float]
) -> Array:
    """Place of each coil (m) with the valve closed."""
    inside = (
        np.concatenate(closed)
        if closed
        else np.flatnonzero(np.mod(cam_angle - dwell[0], TURN) < dwell[1] - dwell[0])
    )
    if not len(inside):
        raise InputError(
            "the film shows no frame with the valve closed; correct the dwell, or film a whole turn",
            "dwell",
        )
    return np.asarray(np.nanmean(moved[inside], axis=0))


def _cycles(
    seen: SpaceTime,
    phase: CamPhase,
    moved: Array,
    turns: list[int],
    grid: Array,
    synthetic: bool,
    notes: tuple[str, ...],
) -> tuple[MeasuredCycles, ...]:
    """Displacement of every coil over the cam angle."""
    step = float(np.degrees(phase.cam_speed / seen.frame_rate))
    sentence = "positive towards the seat, from rest with the valve closed: minus the channel axial_displacement of a run"
    between = f"splines between frames {step:.3g} cam deg apart: motion faster than half the frame rate is folded into them"
    return tuple(
        MeasuredCycles(
            f"coil_{coil + 1}_displacement",
            "m",
            grid,
            on_grid(phase.cam_angle, moved[:, coil], turns, grid),
            float(phase.cam_speed),
            f"{seen.name}, coil {coil + 1} from the seat",
            synthetic,
            (sentence, between, *notes),
        )
        for coil in range(moved.shape[1])
    )
