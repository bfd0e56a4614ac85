"""From a film to the motion of the coils: displacements over the cam angle, peaks along the spring,
surge lines and their damping.
"""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.film.cycles import (
    SPOKEN_OF,
    TURN,
    CamPhase,
    CoilPeak,
    Lift,
    by_lift,
    by_marker,
    camera_drift,
    closed_window,
    is_closed,
    mean_of,
    on_grid,
    peaks,
    segments,
    whole_turns,
)
from valvetrain.film.frames import Picture, open_film
from valvetrain.film.result import CoilMotion
from valvetrain.film.setup import FilmSetup
from valvetrain.film.space_time import SightLine, SpaceTime, find_line, read_space_time
from valvetrain.film.surge import fit_surge
from valvetrain.film.tracks import Tracks, track
from valvetrain.measured.cycles import MeasuredCycles

#: Cam angles of the written curves: whole degrees.
ANGLES = 360
#: Uncertainty (px) with which a point of the scale is picked.
PICKED = 0.5
NO_SCALE = "the scale is not known: give two points of the picture and their distance, such as the edges of the two seats"


def coil_motion(
    film: str | os.PathLike[str] | Picture,
    setup: FilmSetup,
    valve_lift: Lift | None = None,
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
    >>> motion = coil_motion(film, FilmSetup(frame_rate=2000, scale="4, 0, 4, 50, 10 mm", free_decay=True))
    >>> motion
    CoilMotion of array: 3 coils in 120 frames, free decay
    >>> f"{motion.surge.lines[0].natural_frequency:.1f} Hz, damping ratio {motion.surge.lines[0].damping_ratio:.4f}"
    '400.0 Hz, damping ratio 0.0080'
    """
    opened = open_film(film)
    by_lift_alone = valve_lift is not None and setup.first_angle is None
    has_phase = setup.marker is not None or setup.cam_speed is not None or by_lift_alone
    if not (setup.free_decay or has_phase):
        raise InputError(
            "the cam angle is not known: give a marker's place, the cam speed (which an angle of the first frame needs too), or the lift; or "
            "say that the spring decays freely",
            "marker",
        )
    if setup.scale is None and valve_lift is None:
        raise InputError(NO_SCALE, "scale")
    notes = []
    line = SightLine(*setup.line, setup.line_width) if setup.line else None
    if line is None:
        line = find_line(opened, setup.line_width)
        (x, y), (x_end, y_end) = line.start, line.end
        notes.append(f"the line was chosen where highlights are clearest: from {x:g}, {y:g} to {x_end:g}, {y_end:g} px")  # fmt: skip
    seen = read_space_time(
        opened,
        line,
        setup.frame_rate,
        setup.marker,
        setup.marker_radius,
        setup.first_frame,
        setup.last_frame,
    )
    tracks, towards, said = _from_the_seat(track(seen, setup.coils), setup.seat)
    notes += [*seen.notes, *tracks.notes, *said]
    phase = None
    if not setup.free_decay:
        phase = _phase(seen, towards * tracks.places[:, -1], setup, valve_lift)
    angle = None if phase is None else phase.cam_angle
    drift, still = camera_drift(tracks.places, seen.time, angle)
    if phase is not None and phase.zero_by == "lift":  # the drift was in what was laid on the lift
        phase = _phase(seen, towards * (tracks.places[:, -1] - drift), setup, valve_lift)
    places, reach = tracks.places - drift[:, None], float(np.ptp(drift))
    if still is None:
        notes.append(
            "no coil is at rest, so a shift of the camera cannot be separated from the spring's motion and stays in it"
        )
    elif reach >= SPOKEN_OF:
        notes.append(
            f"the camera drifted by {reach:.2g} px over the film, as coil {still + 1}, which is at rest, shows; this was subtracted"
        )
    scale, scale_spread, sentence = _scale(setup, phase)
    moved, frames = towards * scale * places, np.arange(len(places))
    cycles: tuple[MeasuredCycles, ...] = ()
    tops: tuple[CoilPeak, ...] = ()
    dwell = setup.dwell
    if phase is None:
        moved = moved - np.nanmean(moved, axis=0)
        # The longest stretch of frames without a lost one.
        closed = [max(np.split(frames, np.flatnonzero(np.diff(seen.number) > 1) + 1), key=len)]
    else:
        notes += phase.notes
        turns, grid = whole_turns(phase.cam_angle), np.arange(ANGLES) * TURN / ANGLES
        if dwell is None:
            upper = on_grid(phase.cam_angle, moved[:, -1], turns, grid)
            dwell = closed_window(grid, mean_of(upper))
        closed = segments(phase.cam_angle, seen.number, dwell)
        rest = np.concatenate(closed or [frames[is_closed(phase.cam_angle, dwell)]])
        if not len(rest):
            raise InputError(
                "the film shows no frame with the valve closed; correct the dwell, or film a whole turn",
                "dwell",
            )
        moved = moved - np.nanmean(moved[rest], axis=0)
        tops = peaks(phase.cam_angle, moved, scale * tracks.spread, turns)
        step = float(np.degrees(phase.cam_speed / seen.frame_rate))
        about = (
            "positive towards the seat, from rest with the valve closed: minus the channel axial_displacement of a run",
            f"splines between frames {step:.3g} cam deg apart: motion faster than half the frame rate is folded into them",
            sentence,
        )
        cycles = tuple(
            MeasuredCycles(
                f"coil_{coil}_displacement",
                "m",
                grid,
                on_grid(phase.cam_angle, place, turns, grid),
                float(phase.cam_speed),
                f"{seen.name}, coil {coil} from the seat",
                synthetic,
                about,
            )
            for coil, place in enumerate(moved.T, 1)
        )
    surge = fit_surge(moved, closed, seen.frame_rate)
    return CoilMotion(
        seen,
        places,
        tracks.spread,
        tracks.merged,
        moved,
        phase,
        cycles,
        tops,
        dwell,
        surge,
        scale,
        scale_spread,
        drift,
        (*notes, sentence),
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
    places, spread, merged = tracks.places[:, ::-1], tracks.spread[:, ::-1], tracks.merged[:, ::-1]
    return Tracks(places, spread, merged, tracks.notes), 1.0, said


def _phase(seen: SpaceTime, moved: Array, setup: FilmSetup, lift: Lift | None) -> CamPhase:
    """Cam angle by the marker, the lift or the speed; where the mark has no angle, the lift gives the zero."""
    if setup.marker is not None:
        phase = by_marker(seen.time, seen.marker, setup.marker_angle or 0.0, setup.cam_speed)
        if setup.marker_angle is not None or lift is None:
            return phase if setup.marker_angle is not None else replace(phase, zero_by="nobody")
        laid = by_lift(seen.time, moved, lift, phase.cam_speed)
        off = float(np.mean(np.unwrap(np.mod(laid.cam_angle - phase.cam_angle, TURN))))
        notes = (*phase.notes, "the marker gives the speed, the lift the zero of the cam angle")
        return replace(
            phase,
            cam_angle=phase.cam_angle + off,
            metres_per_pixel=laid.metres_per_pixel,
            notes=notes,
            zero_by="lift",
        )
    if lift is not None and setup.first_angle is None:
        return by_lift(seen.time, moved, lift, setup.cam_speed)
    assert setup.cam_speed is not None
    angle = (setup.first_angle or 0.0) + setup.cam_speed * seen.time
    zero_by = "nobody" if setup.first_angle is None else "told"
    return CamPhase(angle, setup.cam_speed, 0.0, "speed", zero_by=zero_by)


def _scale(setup: FilmSetup, phase: CamPhase | None) -> tuple[float, float, str]:
    """Metres a pixel, standard deviation, and what is said of it."""
    scale = setup.metres_per_pixel
    if setup.scale is not None:
        share = np.sqrt(2) * PICKED * scale / setup.scale[2]
        sentence = f"the scale is {1e3 * scale:.5g} mm a pixel, within {100 * share:.2g} % as far as points are picked"
        return scale, float(share * scale), sentence
    if phase is not None and phase.metres_per_pixel > 0:
        sentence = "the scale makes the uppermost coil move as far as the lift, too large a scale where that coil is not the retainer's"
        return phase.metres_per_pixel, 0.0, sentence
    raise InputError(NO_SCALE, "scale")
