"""Measures how well films are read: draws films of known motions, reads them, and prints the tables
of docs/film.md (some minutes).

Use: python scripts/film_accuracy.py
"""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import sample_film as drawn

import valvetrain as vt
from valvetrain.film.frames import open_film
from valvetrain.film.space_time import SightLine, read_space_time
from valvetrain.film.tracks import track

DEFAULT = drawn.Scene(columns=10)
COARSE = replace(DEFAULT, pixels_per_mm=1.5, rows=60, seat_row=55.5)
#: Words, scene, frames.
SCENES = (
    ("6 px a mm, noise 2.5 of 255, exposed for 0.3 of the time", DEFAULT, 300), ("noise 8 of 255", replace(DEFAULT, noise=8.0), 300),
    ("exposed for 0.9 of the time", replace(DEFAULT, exposure=0.9), 300), ("lamp dims by 60 %", replace(DEFAULT, light_drift=0.6), 300),
    ("lamp 50 deg above the camera", replace(DEFAULT, lamp=50.0), 300), ("wide, dull glare", replace(DEFAULT, shine=4.0), 300),
    ("2.5 px a mm", replace(DEFAULT, pixels_per_mm=2.5, rows=100, seat_row=92.5), 300), ("1.5 px a mm", replace(COARSE, blur=1.2), 300),
    ("1.5 px a mm, out of focus: glare lines merge", replace(COARSE, blur=2.2), 300),
    ("large: 48 x 800 px, 20 px a mm, 4000 frames a second", replace(
        DEFAULT, pixels_per_mm=20.0, rows=800, columns=48, seat_row=750.0, frame_rate=4000.0, blur=1.5), 2000),
)  # fmt: skip


def places() -> None:
    """Errors of places: six coils that close until all touch, twenty times a second, with a surge
    of 0.3 mm at 420 Hz.
    """
    print(
        "| film | error, rms px | largest | told | merged frames | processor time a frame |\n|---|---|---|---|---|---|"
    )
    for words, scene, frames in SCENES:
        film, truth = drawn.draw(scene, drawn.closing(6, 3.66, 6.5, 0.3), frames)
        middle = 0.5 * (scene.columns - 1)
        line = SightLine((middle, 0.0), (middle, scene.rows - 1.0))
        begun = time.process_time()
        found = track(read_space_time(open_film(film), line, scene.frame_rate, None, 3.0, 0, None))
        spent = (time.process_time() - begun) / frames
        off = found.places - truth[:, ::-1]
        off -= np.nanmedian(off, axis=0)
        told, merged = np.nanmedian(found.spread), found.merged.any(axis=1).mean()
        error, largest = np.sqrt(np.nanmean(off**2)), np.nanmax(np.abs(off))
        print(
            f"| {words} | {error:.3f} | {largest:.2f} | {told:.3f} | {100 * merged:.0f} % | {1e3 * spent:.1f} ms |"
        )


def damping(films: int = 12) -> None:
    """Surge line and damping of a turning cam over films that differ in their noise; how often the
    truth lies in the 95 % interval.
    """
    rows = []
    setup = vt.film.FilmSetup(
        frame_rate=2000,
        scale=((4, 0), (4, 120), 0.02),
        marker=(4, 4),
        marker_radius=2,
        line=((6, 10), (6, 239)),
        marker_angle=drawn.MARK_ANGLE,
    )
    for seed in range(1, films + 1):
        marks = drawn.mark_of(300, 2000.0, drawn.CAM_SPEED, drawn.FIRST_ANGLE, drawn.MARK_ANGLE)
        film, _ = drawn.draw(
            replace(DEFAULT, seed=seed, camera_drift=1.2), drawn.turning, 300, marks
        )
        surge = vt.film.coil_motion(film, setup).surge
        assert surge is not None
        line = max(surge.lines, key=lambda one: one.amplitude)
        off = line.natural_frequency - drawn.SURGE, line.damping_ratio / drawn.DAMPING - 1
        rows.append(
            (
                *off,
                abs(off[0]) < 1.96 * line.frequency_spread,
                abs(off[1] * drawn.DAMPING) < 1.96 * line.damping_spread,
            )
        )
    found = np.array(rows, dtype=float)
    print(
        f"frequency: rms {np.sqrt(np.mean(found[:, 0] ** 2)):.3f} Hz of {drawn.SURGE:g}, in its interval {found[:, 2].sum():.0f} of {films}"
    )
    print(
        f"damping: rms {100 * np.sqrt(np.mean(found[:, 1] ** 2)):.2f} %, largest {100 * np.abs(found[:, 1]).max():.2f} %, "
        f"in its interval {found[:, 3].sum():.0f} of {films}"
    )


def pictures(folder: Path) -> None:
    """The two pictures of docs/film.md: the film of vaz-ohc."""
    from plotly_pictures import save

    from valvetrain.views.results import figure_for_user

    _, rest, angle, moved, cam_speed = drawn.coils_of_case()
    scene = drawn.Scene(camera_drift=1.5)
    film, _ = drawn.draw(
        scene,
        drawn.driven(rest, angle, moved, cam_speed, 0.4),
        700,
        drawn.mark_of(700, 2000.0, cam_speed, 0.4, 1.0),
    )
    setup = vt.film.FilmSetup(
        frame_rate=2000,
        scale=((11, 0), (11, 120), 0.02),
        marker=(4, 4),
        marker_angle=1.0,
    )
    motion = vt.film.coil_motion(film, setup, synthetic=True)
    for name, figure in (("space-time", "space-time"), ("displacement", "coils")):
        save(figure_for_user(motion, figure), folder / f"film-{name}.svg")


if __name__ == "__main__":
    places()
    damping()
    pictures(Path(__file__).parents[1] / "docs" / "pictures")
