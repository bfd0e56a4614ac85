"""Draws films of a valve spring as a high-speed camera sees it, from known motions of its coils:
folders of PNG frames.

The wire is a lit cylinder with a glare line; exposure, optics, noise, drift of light and camera,
and 8 bits are those of a camera. Nothing
of it knows how films are read.

Use: python scripts/sample_film.py FOLDER          the films of docs/film.md: decay/, train/
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Heights (mm) of wire centres above the seat at times (s): (times,) -> (times, coils).
Heights = Callable[[Array], Array]
#: Steps of the table of a wire's brightness within a pixel.
FINE = 32
#: Natural frequency (Hz) and damping ratio of the closed forms, speed of the cam (rad/s), angles of
#: first frame and mark (rad).
SURGE, DAMPING, CAM_SPEED, FIRST_ANGLE, MARK_ANGLE = 412.0, 0.015, 170.0, 0.7, 1.1
SHARE = np.array([0.0, 0.2, 0.4, 0.6, 0.8, 1.0])
REST = 2.0 + 32.0 * SHARE
LIFT, OPEN = 9.0, 2.2  # mm, rad


@dataclass(frozen=True)
class Scene:
    """What the camera sees, and how: lengths in px where nothing else is said, grey levels of 8
    bits.
    """

    frame_rate: float = 2000.0
    rows: int = 240
    columns: int = 24
    pixels_per_mm: float = 6.0
    seat_row: float = 225.0
    wire_diameter: float = 3.66  # mm
    exposure: float = 0.3  # share of the time between frames
    exposures: int = 6  # instants that make up one exposure
    blur: float = 0.8  # standard deviation of the optics
    noise: float = 2.5  # standard deviation of a pixel
    lamp: float = 20.0  # deg above the camera
    shine: float = 18.0  # exponent of the glare
    bright: float = 150.0
    background: float = 18.0
    rear: float = 0.12  # brightness of the rear of the coils beside the front
    slope: float = 0.07  # of the wire on the picture
    light_drift: float = 0.15  # share by which the lamp changes over the film
    camera_drift: float = 0.0  # px over the film
    seed: int = 1


def wire_table(scene: Scene) -> tuple[Array, Array, Array]:
    """Places (px from the wire's centre), brightness of the lit wire and share that it covers, both
    as a pixel sees them.
    """
    radius = 0.5 * scene.wire_diameter * scene.pixels_per_mm
    reach = radius + 6 * scene.blur + 2
    place = np.arange(-np.ceil(reach * FINE), np.ceil(reach * FINE) + 1) / FINE
    share = np.clip(place / radius, -1, 1)
    tilt = np.arcsin(share) - np.radians(scene.lamp)
    light = (
        0.06
        + 0.30 * np.clip(np.cos(tilt), 0, None)
        + 0.64
        * np.clip(np.cos(2 * np.arcsin(share) - np.radians(scene.lamp)), 0, None) ** scene.shine
    )
    covers = (np.abs(place) <= radius).astype(float)
    steps = np.arange(-int(5 * scene.blur * FINE) - FINE, int(5 * scene.blur * FINE) + FINE + 1)
    lens = np.exp(-0.5 * (steps / (scene.blur * FINE)) ** 2)
    pixel = (np.abs(steps) <= FINE / 2).astype(float)
    seen = np.convolve(lens / lens.sum(), pixel / pixel.sum(), mode="same")
    return (
        place,
        np.convolve(light * covers, seen, mode="same"),
        np.convolve(covers, seen, mode="same"),
    )


def draw(
    scene: Scene, heights: Heights, frames: int, marker: Array | None = None
) -> tuple[NDArray[np.uint8], Array]:
    """Film (frames, rows, columns) and the true rows (px) of the wire centres at mid exposure in
    its middle column (frames, coils).

    ``marker`` (frames,): brightness, 0 to 1, of a spot of 5 x 5 px in the upper left corner.
    """
    chance = np.random.default_rng(scene.seed)
    table, middle = wire_table(scene), 0.5 * (scene.columns - 1)
    row = np.arange(scene.rows, dtype=float)
    offsets = (
        ((np.arange(scene.exposures) + 0.5) / scene.exposures - 0.5)
        * scene.exposure
        / scene.frame_rate
    )
    film = np.zeros((frames, scene.rows, scene.columns), dtype=np.uint8)
    truth = []
    for frame in range(frames):
        time, share = frame / scene.frame_rate, frame / max(frames - 1, 1)
        moved = scene.camera_drift * np.sin(2.2 * share)
        rows = scene.seat_row - scene.pixels_per_mm * heights(np.append(time + offsets, time))
        truth.append(rows[-1] + moved)
        seen = np.zeros((scene.rows, scene.columns))
        for front in rows[:-1] + moved:
            seen += _instant(scene, table, row, middle, front)
        seen *= (1 - scene.light_drift * share) / scene.exposures
        if marker is not None:
            seen[2:7, 2:7] = 12.0 + 200.0 * marker[frame]
        film[frame] = np.clip(
            np.round(seen + scene.noise * chance.standard_normal(seen.shape)), 0, 255
        ).astype(np.uint8)
    return film, np.array(truth)


def _instant(
    scene: Scene, table: tuple[Array, Array, Array], row: Array, middle: float, front: Array
) -> Array:
    """The picture at one instant: rear half-turns, in part hidden by the front ones."""
    place, light, covers = table
    across = np.arange(scene.columns) - middle
    picture = np.zeros((scene.rows, scene.columns))
    picture += scene.background * (1 + 0.1 * np.sin(row / 17.0))[:, None]
    hidden = np.zeros_like(picture)
    rear = 0.5 * (front[1:] + front[:-1])
    for centres, slope, bright in ((rear, -scene.slope, scene.rear), (front, scene.slope, 1.0)):
        added, over = np.zeros_like(picture), np.zeros_like(picture)
        for centre in centres:
            near = np.abs(row - centre) < place[-1] + 2 + abs(slope) * middle
            apart = row[near, None] - (centre + slope * across)
            added[near] += np.interp(apart, place, light, 0, 0) * scene.bright * bright
            over[near] += np.interp(apart, place, covers, 0, 0)
        hidden = np.clip(over, 0, 1)
        picture = picture * (1 - hidden) + added
    return picture


def decaying(
    rest: Array,
    share: Array,
    amplitudes: tuple[float, ...],
    natural_frequency: float,
    damping_ratio: float,
) -> Heights:
    """Closed form: surge modes 1, 2... of a spring between fixed ends that decay freely; ``share``
    of the length at each coil.
    """

    def heights(time: Array) -> Array:
        moved = np.zeros((len(time), len(rest)))
        for order, amplitude in enumerate(amplitudes, start=1):
            rate = 2 * np.pi * order * natural_frequency
            swing = np.exp(-damping_ratio * rate * time) * np.cos(
                rate * np.sqrt(1 - damping_ratio**2) * time + 0.7 * order
            )
            moved += amplitude * swing[:, None] * np.sin(order * np.pi * share)
        return rest + moved

    return heights


def driven(
    rest: Array, cam_angle: Array, displacement: Array, cam_speed: float, first_angle: float = 0.0
) -> Heights:
    """A periodic motion: ``displacement`` (angles, coils) mm at equally spaced ``cam_angle`` (rad)
    of one turn, repeated.
    """
    from scipy.interpolate import CubicSpline

    whole = np.vstack([displacement, displacement[:1]])
    curve = CubicSpline(np.append(cam_angle, cam_angle[0] + 2 * np.pi), whole, bc_type="periodic")
    return lambda time: rest + curve(np.mod(cam_speed * time + first_angle, 2 * np.pi))


def mark_of(
    frames: int,
    frame_rate: float,
    cam_speed: float,
    first_angle: float,
    mark_angle: float,
    width: float = 0.5,
) -> Array:
    """Brightness of a white mark of ``width`` rad on the cam pulley that passes the spot once a
    turn, at ``mark_angle``.
    """
    angle = cam_speed * np.arange(frames) / frame_rate + first_angle - mark_angle
    apart = np.abs((angle + np.pi) % (2 * np.pi) - np.pi)
    return np.asarray(
        np.clip((0.5 * width - apart) / (0.25 * width) + 0.5, 0.0, 1.0), dtype=np.float64
    )


def lift(cam_angle: Array) -> Array:
    """Lift (m) of a closed form: fourth power of a sine over the open part, none before and after."""
    angle = np.mod(cam_angle, 2 * np.pi)
    return (
        1e-3
        * LIFT
        * np.where(angle < OPEN, np.sin(np.pi * np.minimum(angle, OPEN) / OPEN) ** 4, 0.0)
    )


def turning(time: Array) -> Array:
    """Heights (mm): each section follows its share of the lift; as the valve closes a surge begins
    that decays freely.
    """
    angle = CAM_SPEED * time + FIRST_ANGLE
    since = np.mod(angle - OPEN, 2 * np.pi) / CAM_SPEED
    rate = 2 * np.pi * SURGE
    swing = 0.7 * np.exp(-DAMPING * rate * since) * np.sin(rate * np.sqrt(1 - DAMPING**2) * since)
    return np.asarray(
        REST - 1e3 * lift(angle)[:, None] * SHARE + swing[:, None] * np.sin(np.pi * SHARE),
        dtype=np.float64,
    )


def closing(coils: int, wire: float, pitch: float, surge: float) -> Heights:
    """Heights (mm) of coils that close one after the other until all touch, twenty turns a second,
    and surge at 420 Hz.
    """
    share, room = np.arange(coils) / (coils - 1), (pitch - wire) * (coils - 1)

    def heights(time: Array) -> Array:
        angle = np.mod(2 * np.pi * 20 * time + 2.0, 2 * np.pi)
        opened = np.where(
            np.abs(angle - np.pi) < 0.8, np.cos((angle - np.pi) / 1.6 * np.pi) ** 2, 0.0
        )
        found = 2.0 + pitch * np.arange(coils) - room * opened[:, None] * share
        found = found + surge * np.sin(2 * np.pi * 420 * time)[:, None] * np.sin(np.pi * share)
        for one in range(1, coils):
            found[:, one] = np.maximum(found[:, one], found[:, one - 1] + wire)
        return found

    return heights


def coils_of_case(
    case: str = "vaz-ohc", first_turn: float = 0.6, model: str = "multi-mass"
) -> tuple[Array, Array, Array, Array, float]:
    """Turns, rest heights (mm), cam angles, displacements (angles, coils; mm) and cam speed of the
    front of the outer spring of a case.
    """
    import valvetrain as vt

    loaded = vt.load_case(case)
    run = vt.simulate(loaded, models=[model]).solutions[0]
    name = run.springs[0]
    coil = run.arrays.coords[f"{name}_coil_number"].values
    moved = run.channel(run.channel_of(name, "axial_displacement"))
    assert loaded.train is not None
    spring = loaded.train.spring_parts()[0]
    wire = spring.wire
    assert wire is not None and spring.installed_height is not None
    first, last = wire.free_coils
    if coil[-1] <= 1:  # models of a uniform bar count shares of the compliance
        from valvetrain.springs.equivalent import installed_gaps

        gaps = installed_gaps(wire, spring.precompression)
        coil = np.interp(coil, gaps.flow, gaps.turns)
    turns = np.arange(first_turn, wire.total_coils - 0.1, 1.0)
    fine = np.linspace(0.0, wire.total_coils, 2001)
    free = np.concatenate(
        [
            [0.0],
            np.cumsum(
                0.5 * (wire.pitch.value(fine[1:]) + wire.pitch.value(fine[:-1])) * np.diff(fine)
            ),
        ]
    )
    active = np.clip((fine - first) / (last - first), 0, 1)
    height = free - active * (
        free[-1] - (spring.installed_height - float(wire.wire_diameter.value(0.0)))
    )
    rest = np.interp(turns, fine, height) * 1e3 + 0.5e3 * float(wire.wire_diameter.value(0.0))
    displaced = np.stack(
        [1e3 * np.array([np.interp(one, coil, row) for row in moved]) for one in turns], axis=1
    )
    return turns, rest, run.cam_angle, displaced, run.engine_speed / 2


def write_frames(folder: Path, film: NDArray[np.uint8]) -> None:
    """The frames as ``frame-00000.png`` and so on."""
    import cv2

    folder.mkdir(parents=True, exist_ok=True)
    for place, picture in enumerate(film):
        cv2.imwrite(str(folder / f"frame-{place:05d}.png"), picture)


def main(folder: Path) -> None:
    """Write both films with the truth behind them."""
    share = np.linspace(0.0, 0.9, 7)
    heights = decaying(2.0 + 34.0 * share, share, (1.2, 0.4), 420.0, 0.012)
    film, truth = draw(Scene(), heights, 400)
    write_frames(folder / "decay", film)
    (folder / "decay.json").write_text(
        json.dumps({"natural_frequency": 420.0, "damping_ratio": 0.012, "rows": truth.tolist()})
    )
    _, rest, angle, displaced, cam_speed = coils_of_case()
    scene = Scene(camera_drift=1.5)
    mark = mark_of(700, scene.frame_rate, cam_speed, 0.4, 1.0)
    film, truth = draw(scene, driven(rest, angle, displaced, cam_speed, 0.4), 700, mark)
    write_frames(folder / "train", film)
    (folder / "train.json").write_text(
        json.dumps(
            {"cam_speed": cam_speed, "first_angle": 0.4, "mark_angle": 1.0, "rows": truth.tolist()}
        )
    )


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
