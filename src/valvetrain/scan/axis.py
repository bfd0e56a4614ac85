"""The wire followed from section to section: turns, radii and heights along it, and its hand."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError

Array = NDArray[np.float64]
#: Half planes per turn; those that choose the radius of the wire, and the radii they try as shares
#: of the coil radius.
WEDGES, CHOOSING, RADII = 64, 8, np.geomspace(0.035, 0.36, 32)
#: Size of a cell of votes as a share of the coil radius; least distance between two sections, in
#: radii of the wire.
CELL, APART = 0.012, 1.4
#: Radii of the wire that are followed up.
TRIED = 4
#: Share of the typical number of votes from which a section counts.
LEAST = 0.3
#: Most points of a half plane that vote.
MAX_VOTING = 600


@dataclass(frozen=True, eq=False)
class Sections:
    """Centres of wire sections: ``turn`` of the half plane (0 to 1), ``radius`` and ``height``
    (k,), ``votes`` as shares.
    """

    turn: Array
    radius: Array
    height: Array
    votes: Array
    wire_radius: float


def find_sections(points: Array, wedges: int = WEDGES) -> list[Sections]:
    """Sections of the wire in ``wedges`` half planes by the radii with the most votes, the best
    first; ``points`` (n, 3) in the frame
    of the axis. Empty for points that show no round wire."""
    turn = np.mod(np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi), 1.0)
    plane = np.column_stack([np.hypot(points[:, 0], points[:, 1]), points[:, 2]])
    low, high = np.quantile(plane, 0.005, axis=0), np.quantile(plane, 0.995, axis=0)
    margin = 0.05 * float(np.max(high - low))
    inside = np.all((plane > low - margin) & (plane < high + margin), axis=1)
    turn, plane = turn[inside], plane[inside]
    order = np.argsort(turn, kind="stable")
    turn, plane = turn[order], plane[order]
    edges = np.searchsorted(turn, np.linspace(0.0, 1.0, wedges + 1))
    parts = [
        plane[first:last][:: max(1, (last - first) // MAX_VOTING)]
        for first, last in itertools.pairwise(edges)
    ]
    coil = float(high[0])
    chosen = parts[:: max(1, wedges // CHOOSING)]
    scores = [
        float(
            np.mean(
                [_votes(part, share * coil, CELL * coil)[0].max(initial=0.0) for part in chosen]
            )
        )
        for share in RADII
    ]
    answers = (
        _with_radius(parts, share * coil, CELL * coil) for share in _best_radii(np.array(scores))
    )
    return [one for one in answers if one is not None]


def _best_radii(scores: Array) -> list[float]:
    """Shares of the coil radius at which the votes peak, the highest peak first."""
    rising = np.concatenate([[True], np.diff(scores) > 0])
    peaks = np.flatnonzero(rising & ~np.concatenate([rising[1:], [False]]))
    order = peaks[np.lexsort((peaks, -scores[peaks]))][:TRIED]
    return [_peak_place(RADII, scores, int(place)) for place in order]


def _with_radius(parts: list[Array], wire: float, cell: float) -> Sections | None:
    """Sections of a wire of that radius in the points (n, 2) of each half plane; None for too few."""
    wedges = len(parts)
    found: list[tuple[float, float, float, float]] = []
    for place, part in enumerate(parts):
        votes, corner = _votes(part, wire, cell)
        for row, column, strength in _peaks(votes, int(APART * wire / cell)):
            found.append(
                (
                    (place + 0.5) / wedges,
                    corner[0] + row * cell,
                    corner[1] + column * cell,
                    strength,
                )
            )
    if len(found) < wedges:
        return None
    turns, radii, heights, strengths = np.array(found).T
    typical = float(np.quantile(strengths, 0.8))
    keep = strengths > LEAST * typical
    return Sections(turns[keep], radii[keep], heights[keep], strengths[keep] / typical, wire)


def _peak_place(shares: Array, scores: Array, place: int) -> float:
    """Where a parabola through the score at ``place`` and its neighbours is highest, in logarithms
    of the share.
    """
    top = int(np.clip(place, 1, len(scores) - 2))
    before, at, after = scores[top - 1 : top + 2]
    bend = before - 2 * at + after
    away = 0.5 * (before - after) / bend if bend < 0 else 0.0
    return float(shares[top] * (shares[top + 1] / shares[top]) ** np.clip(away, -0.5, 0.5))


def _votes(plane: Array, wire: float, cell: float) -> tuple[Array, Array]:
    """Smoothed votes for centres that are one wire radius from the points, and the corner of the
    cells.
    """
    if len(plane) < 3:
        return np.zeros((1, 1)), np.zeros(2)
    around = np.linspace(
        0, 2 * np.pi, int(np.ceil(2 * np.pi * wire / (0.7 * cell))), endpoint=False
    )
    circle = wire * np.column_stack([np.cos(around), np.sin(around)])
    corner = plane.min(axis=0) - wire - 2 * cell
    shape = np.ceil((plane.max(axis=0) - corner + wire) / cell).astype(int) + 3
    if shape[0] * shape[1] > 4_000_000:
        return np.zeros((1, 1)), corner
    rows, columns = (
        np.floor((plane[:, None, :] + circle - corner) / cell).astype(int).reshape(-1, 2).T
    )
    votes = (
        np.bincount(rows * shape[1] + columns, minlength=shape[0] * shape[1])
        .reshape(shape)
        .astype(float)
    )
    for _ in range(
        2
    ):  # neighbours share their votes, so that the place of the cells has no influence
        votes[1:-1] = 0.25 * votes[:-2] + 0.5 * votes[1:-1] + 0.25 * votes[2:]
        votes = votes.T
    # the votes of a point on its own circle are the same number for every radius; a share of the
    # points is what is compared
    return votes / len(plane), corner + 0.5 * cell


def _peaks(votes: Array, apart: int) -> list[tuple[int, int, float]]:
    """Cells with the most votes within ``apart`` cells about them, the highest first."""
    from scipy.ndimage import maximum_filter

    apart = max(apart, 1)
    tops = (votes == maximum_filter(votes, size=2 * apart + 1)) & (votes > 0)
    rows, columns = np.nonzero(tops)
    strength = votes[rows, columns]
    order = np.lexsort((columns, rows, -strength))[:60]
    return [(int(rows[k]), int(columns[k]), float(strength[k])) for k in order]


#: Distance, in wire diameters, up to which sections of neighbouring half planes belong together,
#: and by how much it grows a missing one.
NEAR, GROWTH, FARTHEST = 0.3, 0.02, 0.45
#: Turns without a section after which the wire is taken to end, and turns behind that show where it
#: continues.
GAP, BEHIND = 0.45, 0.25
#: Fewest linked sections that a wire is followed from, and chains that are tried.
SHORTEST, STARTS = 8, 8
#: Fewest turns of a wire that is a spring.
MIN_TURNS = 2.0


@dataclass(frozen=True, eq=False)
class Trace:
    """Sections along the wire: ``turn`` (k,) unwound and rising with the height, ``radius`` and
    ``height``; ``hand`` 1 right, -1 left.
    """

    turn: Array
    radius: Array
    height: Array
    hand: int
    wire_radius: float


def follow(sections: Sections, wedges: int) -> Trace:
    """The wire through ``sections`` in ``wedges`` half planes.

    Raises :class:`InputError` where they are no wire of :data:`MIN_TURNS` turns.
    """
    plane = np.column_stack([sections.radius, sections.height])
    wedge = np.round(sections.turn * wedges - 0.5).astype(int)
    members = [np.flatnonzero(wedge == one) for one in range(wedges)]
    after = _links(plane, members, 2 * NEAR * sections.wire_radius)
    chains = sorted(_chains(after), key=len, reverse=True)
    if len(chains[0]) < SHORTEST:
        raise InputError(
            "the sections of the wire do not join to a helix; give the scan of one spring, cleaned of its holder"
        )
    # where a part of the turn is not seen, every coil is a chain of its own, and some join further
    followed = [
        _followed(chain, sections, wedge, members)
        for chain in chains[:STARTS]
        if len(chain) >= max(SHORTEST, len(chains[0]) // 2)
    ]
    hand, known = max(followed, key=lambda one: len(one[1]))
    places = np.array(sorted(known))
    index = np.array([known[place] for place in places])
    turn = (places + 0.5 * hand) / wedges
    if turn[-1] - turn[0] < MIN_TURNS:
        raise InputError(
            f"the wire could be followed over {turn[-1] - turn[0]:.2g} turns only; give more points, less noise or a cloud cleaned of all "
            "but one spring"
        )
    return Trace(turn, plane[index, 0], plane[index, 1], hand, sections.wire_radius)


def _followed(
    chain: list[int], sections: Sections, wedge: NDArray[np.intp], members: list[NDArray[np.intp]]
) -> tuple[int, dict[int, int]]:
    """The hand of a wire that begins with ``chain``, and its section by half plane, counted on."""
    plane = np.column_stack([sections.radius, sections.height])
    steps = np.arange(len(chain))
    hand = 1 if float(np.polyfit(steps, plane[chain, 1], 1)[0]) > 0 else -1
    if hand < 0:
        chain = chain[::-1]
    known = {hand * int(wedge[chain[0]]) + step: chain[step] for step in range(len(chain))}
    used = set(chain)
    for direction in (1, -1):
        _extend(known, used, plane, members, hand, direction, sections.wire_radius)
    return hand, known


def _links(plane: Array, members: list[NDArray[np.intp]], reach: float) -> dict[int, int]:
    """Section -> the one in the next half plane, where each is the nearest of the other."""
    found: dict[int, int] = {}
    for here, there in zip(members, members[1:] + members[:1], strict=True):
        if not len(here) or not len(there):
            continue
        apart = np.linalg.norm(plane[here][:, None] - plane[there][None], axis=2)
        forward, back = np.argmin(apart, axis=1), np.argmin(apart, axis=0)
        for k, to in enumerate(forward):
            if back[to] == k and apart[k, to] < reach:
                found[int(here[k])] = int(there[to])
    return found


def _chains(after: dict[int, int]) -> list[list[int]]:
    """Runs of linked sections, each in the order of its links."""
    chains = []
    for first in sorted(set(after) - set(after.values())) or sorted(after)[:1]:
        chain = [first]
        while chain[-1] in after and after[chain[-1]] != first:
            chain.append(after[chain[-1]])
        chains.append(chain)
    return chains or [[]]


def _extend(
    known: dict[int, int],
    used: set[int],
    plane: Array,
    members: list[NDArray[np.intp]],
    hand: int,
    direction: int,
    wire: float,
) -> None:
    """Continue from the known end, half plane by half plane, where the wire before it
    points to.
    """
    wedges = len(members)
    place = max(known) if direction > 0 else min(known)
    missing = 0
    while missing <= GAP * wedges:
        place += direction
        last = max(known) if direction > 0 else min(known)
        behind = [
            one
            for one in range(last, last - direction * int(BEHIND * wedges), -direction)
            if one in known
        ]
        ahead = (
            np.polyval(_line(behind, plane[[known[one] for one in behind], 0]), place - last),
            _rise(behind, known, plane, place - last),
        )
        reach = 2 * wire * min(NEAR + GROWTH * missing, FARTHEST)
        nearest, best = -1, reach
        for one in members[(hand * place) % wedges]:
            apart = float(np.hypot(*(plane[one] - ahead)))
            if one not in used and apart < best:
                nearest, best = int(one), apart
        if nearest < 0:
            missing += 1
            continue
        known[place] = nearest
        used.add(nearest)
        missing = 0


def _line(behind: list[int], values: Array) -> Array:
    return (
        np.polyfit(np.array(behind) - behind[0], values, 1)
        if len(behind) > 3
        else np.array([values[0]])
    )


def _rise(behind: list[int], known: dict[int, int], plane: Array, away: int) -> float:
    """Height ahead: the wire never runs back."""
    values = plane[[known[one] for one in behind], 1]
    line = _line(behind, values)
    slope = max(float(line[0]), 0.0) if len(line) > 1 else 0.0
    return float(line[-1] + slope * away)


#: Points that look for the axis, directions that are tried, and those that are followed up.
LOOKED_AT, DIRECTIONS, FOLLOWED = 3000, 120, 5
#: Highest power of the height by which the mean radius may change along the axis.
POWER = 4


@dataclass(frozen=True, eq=False)
class Frame:
    """Axis through ``origin`` (3,) with the rows of ``base`` (3, 3): two directions across, then
    the axis.
    """

    origin: Array
    base: Array

    def inside(self, points: Array) -> Array:
        """Points (n, 3) in this frame: across, across, along."""
        found: Array = (points - self.origin) @ self.base.T
        return found

    def outside(self, points: Array) -> Array:
        """Points (n, 3) of this frame where the scan has them."""
        found: Array = points @ self.base + self.origin
        return found

    def moved(self, across: Array, tilt: Array) -> Frame:
        """The frame whose axis passes ``across`` (2,) at height zero and leans by ``tilt`` (2,) per
        height, both in this frame.
        """
        axis = np.array([tilt[0], tilt[1], 1.0])
        return Frame(
            self.outside(np.array([[across[0], across[1], 0.0]]))[0],
            across_and_along(axis @ self.base, self.base[0]),
        )

    def turned_over(self) -> Frame:
        """The same axis, looked along the other way."""
        return Frame(self.origin, self.base * np.array([[1.0], [-1.0], [-1.0]]))


def across_and_along(direction: Array, near: Array | None = None) -> Array:
    """Right-handed base (3, 3) whose last row is ``direction``, its first row close to ``near``."""
    along = direction / np.linalg.norm(direction)
    first = np.eye(3)[int(np.argmin(np.abs(along)))] if near is None else near
    first = first - (first @ along) * along
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(along, first), along])


def find_axis(points: Array) -> Frame:
    """The axis about which the radii of the points (n, 3), a smooth function of the height, scatter
    least; points in any order of draw.
    """
    some = points[:LOOKED_AT]
    middle = np.median(some, axis=0)
    size = float(np.median(np.linalg.norm(some - middle, axis=1))) or 1.0
    near = some[np.linalg.norm(some - middle, axis=1) < 5 * size]
    _, _, principal = np.linalg.svd(near - near.mean(axis=0), full_matrices=False)
    starts = [
        Frame(middle, across_and_along(one)) for one in (*principal, *_hemisphere(DIRECTIONS))
    ]
    coarse = near[::4]
    first = sorted(
        ((_scatter(coarse, frame, size), place) for place, frame in enumerate(starts)),
        key=lambda pair: pair,
    )
    best = [_settled(near, starts[place], size) for _, place in first[:FOLLOWED]]
    return min(best, key=lambda pair: pair[0])[1]


def _hemisphere(count: int) -> Array:
    height = (np.arange(count) + 0.5) / count
    turn = np.pi * (1 + 5**0.5) * np.arange(count)
    ring = np.sqrt(1 - height**2)
    return np.column_stack([ring * np.cos(turn), ring * np.sin(turn), height])


def _scatter(points: Array, frame: Frame, size: float) -> float:
    return _step(points, _step(points, frame, size)[1], size)[0]


def _settled(points: Array, frame: Frame, size: float) -> tuple[float, Frame]:
    best = np.inf, frame
    for _ in range(12):
        scatter, after = _step(points, frame, size)
        best = min(best, (scatter, frame), key=lambda pair: pair[0])
        frame = after
    return best


def _least_squares(basis: Array, values: Array, weight: Array) -> Array:
    heavy = basis * weight[:, None]
    matrix = heavy.T @ basis
    found: Array = np.asarray(
        np.linalg.solve(
            matrix + 1e-10 * np.diag(np.diag(matrix)) + 1e-30 * np.eye(len(matrix)),
            heavy.T @ values,
        )
    )
    return found


def _step(points: Array, frame: Frame, size: float) -> tuple[float, Frame]:
    """Scatter of the radii about a smooth function of the height, and the frame that lowers it: one
    robust Gauss-Newton step.
    """
    x, y, z = frame.inside(points).T
    radius = np.hypot(x, y) + 1e-9 * size
    cosine, sine = x / radius, y / radius
    height = np.clip(z / (2 * size), -1.5, 1.5)
    smooth = np.column_stack([height**power for power in range(POWER + 1)])
    basis = np.column_stack([smooth, cosine, sine, z * cosine, z * sine])
    weight = np.ones(len(radius))
    for _ in range(3):
        found = _least_squares(basis, radius, weight)
        left = radius - basis @ found
        scale = 1.4826 * float(np.median(np.abs(left))) + 1e-9 * size
        weight = np.clip(1 - (left / (4.685 * scale)) ** 2, 0.0, None) ** 2 + 1e-6
    now = radius - smooth @ _least_squares(smooth, radius, weight)
    scatter = float(np.mean(np.minimum(np.abs(now), 0.5 * size))) / size
    across, tilt = found[POWER + 1 : POWER + 3], found[POWER + 3 :]
    limit = 0.5 * size
    across = across * min(1.0, limit / (float(np.linalg.norm(across)) + 1e-12))
    tilt = tilt * min(1.0, 0.3 / (float(np.linalg.norm(tilt)) + 1e-12))
    return scatter, frame.moved(across, tilt)
