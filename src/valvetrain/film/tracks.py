"""Tracks of all coils through a film, with their standard deviations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array, Flags, Ints
from valvetrain.errors import InputError
from valvetrain.film.profile import FINE, Profiles, find_coils, fit, grounds_of, light_of, ordered
from valvetrain.film.space_time import SpaceTime
from valvetrain.measured.stations import runs_of

#: Standard deviation of a prediction in parts of the coils' spacing.
PREDICTED = 0.12


def bridge(
    seen: SpaceTime,
    clear: Flags,
    places: Array,
    profiles: Profiles,
    light: Array,
    least_apart: float,
) -> tuple[Array, Array]:
    """Places of all frames, those of ``clear`` frames (frames,) being known, and how far (px) the
    two ways through a gap differ.

    In every other frame all coils are fitted together from where their motion predicts them and
    from the best ordered set of stations; the
    better fit continues. Gaps are gone through both ways, and the way with the smaller misfit is
    taken.
    """
    picture, number = seen.picture, seen.number
    places, apart = places.copy(), np.zeros(len(places))
    spacing = 4 * profiles.reach
    if places.shape[1] > 1:
        spacing = float(np.median(np.diff(np.median(places[clear], axis=0))))

    def through(frames: range) -> tuple[Array, float]:
        """Places (all frames, coils) with those of a gap, and the sum of squared misfits."""
        filled, misfit, step = places.copy(), 0.0, frames.step
        for frame in frames:
            before, earlier = frame - step, frame - 2 * step
            span = abs(int(number[frame] - number[before]))
            velocity = np.zeros(places.shape[1])
            if 0 <= earlier < len(places):
                velocity = (filled[before] - filled[earlier]) / abs(
                    number[before] - number[earlier]
                )
            expected = np.maximum.accumulate(filled[before] + velocity * min(span, 2))
            response, scale = profiles.responses(picture[frame] / light[frame]), np.sqrt(span)
            station = ordered(response, expected, spacing * scale, max(2, round(least_apart)))
            result = fit(
                np.repeat(picture[frame : frame + 1], 2, axis=0),
                np.stack([expected, station]),
                profiles,
                np.repeat(light[frame], 2),
                least_apart,
                PREDICTED * spacing * scale,
            )
            # The best stations must fit clearly better: where all has merged they only guess.
            better = int(result.noise[1] < 0.8 * result.noise[0])
            filled[frame] = result.places[better]
            misfit += float(result.noise[better] ** 2)
        return filled, misfit

    for first, end in runs_of(~clear):
        ways = [through(range(first, end))] if first > 0 else []
        ways += [through(range(end - 1, first - 1, -1))] if end < len(clear) else []
        places = min(ways, key=lambda way: way[1])[0]
        if len(ways) > 1:
            apart[first:end] = np.abs(ways[0][0] - ways[1][0])[first:end].max(axis=1)
    return places, apart


#: Distance (px) of the knots of a profile, frames from which it is learnt at most, and how smooth
#: it is taken to be.
KNOT, LEARNT_FROM, SMOOTH = 0.7, 150, 1e-3


def learn(picture: Array, frames: Ints, places: Array, heights: Array, reach: float) -> Profiles:
    """Profiles of all coils and a smooth ground together, by least squares of the grey levels
    below.

    ``places``, ``heights`` (frames, coils) of the ``frames`` given. A profile is a cubic spline,
    zero from ``reach`` px on.
    """
    from scipy.interpolate import BSpline
    from scipy.sparse import csr_array, diags_array, hstack

    pick = np.arange(len(frames))[:: max(1, len(frames) // LEARNT_FROM)]
    coils = places.shape[1]
    step = 2 * reach / np.ceil(2 * reach / KNOT)
    knots = np.arange(-reach - 3 * step, reach + 3.5 * step, step)
    # The first and last two splines are left out, so value and slope at the ends are those of a
    # third one's foot.
    count = len(knots) - 4 - 4
    distance = np.arange(picture.shape[1]) - places[pick][:, :, None]
    inside = np.abs(distance) < reach
    near = inside.any(axis=1)
    columns = []
    for coil in range(coils):
        at = np.where(inside[:, coil], distance[:, coil], 0.0).ravel()
        size = inside[:, coil] * heights[pick, coil, None]
        basis = csr_array(BSpline.design_matrix(at, knots, 3))[:, 2:-2]
        columns.append(diags_array(size.ravel()) @ basis)
    grounds, lamp = grounds_of(picture.shape[1]), heights[pick].mean(axis=1)[:, None] * near
    columns.append(csr_array((lamp[:, :, None] * grounds.T).reshape(-1, len(grounds))))
    matrix = hstack(columns).tocsr()
    normal = (matrix.T @ matrix).toarray()
    right = matrix.T @ (picture[frames[pick]] * near).ravel()
    bend = np.diff(np.eye(count), 2, axis=0)
    profile = slice(0, coils * count)
    weight = np.diagonal(normal)[profile].mean()
    normal[profile, profile] += SMOOTH * weight * np.kron(np.eye(coils), bend.T @ bend)
    normal += 1e-7 * weight * np.eye(len(normal))
    shares = np.linalg.solve(normal, right)[profile].reshape(coils, count)
    half = int(np.floor(reach * FINE))
    curve = BSpline(knots, np.pad(shares, ((0, 0), (2, 2))).T, 3)
    return Profiles(curve(np.arange(-half, half + 1) / FINE).T, half / FINE)


#: Rounds of learning the profiles and fitting the places.
ROUNDS = 2
#: Factor of the standard deviation of a place where highlights merge: there it depends on shapes
#: that are never known exactly.
MERGED = 2.0
#: Factor within which a highlight is as bright as it typically is where it is separate, and one
#: below which it may be of a rear coil.
ALIKE, DIM = 2.0, 0.5
#: Reach of a profile to either side in widths of a highlight.
WIDE = 1.6
#: A place is given up whose standard deviation is larger than this share of the highlight's width.
LOST = 0.5
#: Share of such places beyond which a film gives no result.
MAX_LOST = 0.5


@dataclass(frozen=True, eq=False)
class Tracks:
    """``places`` (frames, coils) px from the start of the line, in the order along it, and their
    ``spread`` (standard deviation);
    ``merged`` (frames, coils): the highlight was nearer to its neighbour than their widths, so
    its motion and order say which it is."""

    places: Array
    spread: Array
    merged: Flags
    notes: tuple[str, ...] = ()


def track(seen: SpaceTime, coils: int | None = None) -> Tracks:
    """The coils of a space-time picture. Raises :class:`InputError` for one without highlights."""
    picture = np.asarray(seen.picture, dtype=float)
    start = find_coils(picture, coils)
    light, width = light_of(picture, start.frames), start.width
    apart = max(1.5, 0.5 * width)
    clear, frames = np.zeros(len(picture), dtype=bool), start.frames
    clear[frames] = True
    places = np.zeros((len(picture), start.places.shape[1]))
    places[frames] = start.places
    lamp = light[frames, None]
    profiles = learn(picture, frames, start.places, 0 * start.places + lamp, start.reach)
    for _ in range(ROUNDS):
        result = fit(picture[frames], places[frames], profiles, light[frames], apart)
        places[frames] = result.places
        profiles = learn(picture, frames, result.places, result.heights, WIDE * width)
    shares = np.maximum(result.heights / lamp, 1e-6)
    alike = np.abs(np.log(shares / np.median(shares, axis=0))).max(axis=1) < np.log(ALIKE)
    sure = alike & (result.noise < 2.5 * np.median(result.noise))
    if sure.any():  # a peak next to a merged one is no coil: such a frame is followed like others
        clear[frames[~sure]] = False
    places, doubt = bridge(seen, clear, places, profiles, light, apart)
    result = fit(picture, places, profiles, light, apart)
    everywhere = np.arange(len(picture))
    profiles = learn(picture, everywhere, result.places, result.heights, WIDE * width)
    result = fit(picture, result.places, profiles, light, apart)
    spread = np.maximum(result.spread, np.where(doubt > width, doubt, 0.0)[:, None])
    close = np.diff(result.places, axis=1) < 1.5 * width
    merged = np.pad(close, ((0, 0), (1, 0))) | np.pad(close, ((0, 0), (0, 1)))
    spread = np.where(merged, MERGED * spread, spread)
    lost = spread > LOST * width
    if lost.mean() > MAX_LOST:
        raise InputError(
            "the highlights are too weak or too blurred to follow; light the spring with one lamp next to the camera, lay the line across "
            "the highlights, or give the number of coils",
            "line",
        )
    bright = profiles.table.max(axis=1)
    dim = int(np.sum(bright < DIM * np.median(bright)))
    notes = (
        f"{dim} of {len(bright)} highlights are less than half as bright as the others; where they are rear coils, say how many coils the "
        "line crosses" if dim else "",
        f"neighbouring highlights merge in {merged.any(axis=1).sum()} of {len(merged)} frames; there their order and their own profiles show "
        "which is which" if merged.any() else "",
        f"{lost.sum()} places of {lost.size} are too uncertain (highlight weak or hidden) and are left open" if lost.any() else "",
    )  # fmt: skip
    places = np.where(lost, np.nan, result.places)
    return Tracks(places, spread, merged, tuple(filter(None, notes)))
