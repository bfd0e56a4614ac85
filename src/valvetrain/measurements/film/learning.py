"""Shapes of the highlights learnt from the film itself, those of neighbours that overlap told apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from valvetrain.measurements.film.matched_profile import FINE, Profiles, grounds_of

Array = NDArray[np.float64]
#: Distance (px) of the knots of a profile, frames from which it is learnt at most, and how smooth it is taken to be.
KNOT, LEARNT_FROM, SMOOTH = 0.7, 150, 1e-3


def learn(picture: Array, frames: NDArray[np.int64], places: Array, heights: Array, reach: float) -> Profiles:
    """Profiles of all coils and a smooth ground together, by least squares of the grey levels below.

    ``places``, ``heights`` (frames, coils) of the ``frames`` given. A profile is a cubic spline, zero from ``reach`` px on.
    """
    from scipy.interpolate import BSpline
    from scipy.sparse import csr_matrix

    pick = np.arange(len(frames))[:: max(1, len(frames) // LEARNT_FROM)]
    coils, stations = places.shape[1], picture.shape[1]
    inside = np.linspace(-reach, reach, int(np.ceil(2 * reach / KNOT)) + 1)
    step = inside[1] - inside[0]
    knots = np.concatenate([inside[0] - step * np.arange(3, 0, -1), inside, inside[-1] + step * np.arange(1, 4)])
    # The first and last two splines are left out, so value and slope at the ends are those of a third one's foot.
    count = len(knots) - 4 - 4
    distance = np.arange(stations) - places[pick][:, :, None]
    frame, coil, station = np.nonzero(np.abs(distance) < reach)
    basis = BSpline.design_matrix(distance[frame, coil, station], knots, 3).tocoo()
    kept = (basis.col >= 2) & (basis.col < count + 2)
    row, column = basis.row[kept], basis.col[kept] - 2
    value = basis.data[kept] * heights[pick][frame, coil][row]
    near = np.zeros((len(pick), stations), dtype=bool)
    near[frame, station] = True
    grounds, light = grounds_of(stations), heights[pick].mean(axis=1)
    at_frame, at_station = np.nonzero(near)
    ground_rows = np.tile(at_frame * stations + at_station, len(grounds))
    ground_columns = np.repeat(coils * count + np.arange(len(grounds)), len(at_frame))
    rows = np.concatenate([(frame * stations + station)[row], ground_rows])
    columns = np.concatenate([coil[row] * count + column, ground_columns])
    values = np.concatenate([value, (light[at_frame] * grounds[:, at_station]).ravel()])
    size = coils * count + len(grounds)
    matrix = csr_matrix((values, (rows, columns)), shape=(len(pick) * stations, size))
    normal = (matrix.T @ matrix).toarray()
    right = matrix.T @ np.where(near, picture[frames[pick]], 0.0).ravel()
    bend = np.diff(np.eye(count), 2, axis=0)
    weight = np.trace(normal[: coils * count, : coils * count]) / (coils * count)
    for one in range(coils):
        part = slice(one * count, (one + 1) * count)
        normal[part, part] += SMOOTH * weight * bend.T @ bend
    normal[np.arange(size), np.arange(size)] += 1e-7 * weight
    shares = np.linalg.solve(normal, right)
    half = int(np.floor(reach * FINE))
    fine = np.arange(-half, half + 1) / FINE
    table = [BSpline(knots, np.concatenate([[0, 0], shares[k * count : (k + 1) * count], [0, 0]]), 3)(fine) for k in range(coils)]
    return Profiles(np.array(table), half / FINE)
