"""The wire followed from section to section: turns, radii and heights along it, and its hand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.arrays import Array
from valvetrain.errors import InputError

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
    """Centres of wire sections: number of the half plane ``wedge`` (k,) and place in it, ``plane`` (k, 2), radius and height."""

    wedge: NDArray[np.intp]
    plane: Array
    wire_radius: float


def find_sections(points: Array) -> list[Sections]:
    """Sections of the wire in half planes by the radii with the most votes, the best first;
    ``points`` (n, 3) in the frame
    of the axis. Empty for points that show no round wire."""
    from scipy.signal import find_peaks

    turn = np.mod(np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi), 1.0)
    plane = np.column_stack([np.hypot(points[:, 0], points[:, 1]), points[:, 2]])
    low, high = np.quantile(plane, (0.005, 0.995), axis=0)
    margin = 0.05 * float(np.max(high - low))
    inside = np.all((plane > low - margin) & (plane < high + margin), axis=1)
    order = np.argsort(turn[inside], kind="stable")
    turn, plane = turn[inside][order], plane[inside][order]
    parts = np.split(plane, np.searchsorted(turn, np.arange(1, WEDGES) / WEDGES))
    parts = [part[:: max(1, len(part) // MAX_VOTING)] for part in parts]
    coil = float(high[0])
    cell, chosen = CELL * coil, parts[:: WEDGES // CHOOSING]
    scores = np.array([
        np.mean([_votes(part, share * coil, cell)[0].max() for part in chosen]) for share in RADII
    ])  # fmt: skip
    tops = find_peaks(np.pad(scores, 1))[0] - 1
    sets = []
    for top in tops[np.argsort(-scores[tops], kind="stable")][:TRIED]:
        # Where a parabola through the score and its neighbours is highest, in logarithms of the share.
        middle = int(np.clip(top, 1, len(scores) - 2))
        before, at, after = scores[middle - 1 : middle + 2]
        bend = before - 2 * at + after
        away = 0.5 * (before - after) / bend if bend < 0 else 0.0
        share = RADII[middle] * (RADII[1] / RADII[0]) ** np.clip(away, -0.5, 0.5)
        sets.append(_with_radius(parts, float(share * coil), cell))
    return [sections for sections in sets if len(sections.wedge) >= WEDGES]


def _with_radius(parts: list[Array], wire: float, cell: float) -> Sections:
    """Sections of a wire of that radius in the points (n, 2) of each half plane: cells with the most votes about them."""
    from scipy.ndimage import maximum_filter

    wedges, places, strengths = [], [], []
    for wedge, part in enumerate(parts):
        votes, corner = _votes(part, wire, cell)
        around = maximum_filter(votes, size=2 * max(int(APART * wire / cell), 1) + 1)
        cells = np.argwhere((votes == around) & (votes > 0))
        strength = votes[tuple(cells.T)]
        best = np.argsort(-strength, kind="stable")[:60]
        wedges.append(np.full(len(best), wedge))
        places.append(corner + cell * cells[best])
        strengths.append(strength[best])
    strength = np.concatenate(strengths)
    keep = strength > LEAST * np.quantile(strength, 0.8) if len(strength) else strength > 0
    return Sections(np.concatenate(wedges)[keep], np.concatenate(places)[keep], wire)


def _votes(plane: Array, wire: float, cell: float) -> tuple[Array, Array]:
    """Smoothed votes for centres that are one wire radius from the points, and the corner of the
    cells.
    """
    from scipy.ndimage import convolve1d

    if len(plane) < 3:
        return np.zeros((1, 1)), np.zeros(2)
    corner = plane.min(axis=0) - wire - 2 * cell
    rows, columns = np.ceil((plane.max(axis=0) - corner + wire) / cell).astype(int) + 3
    if rows * columns > 4_000_000:
        return np.zeros((1, 1)), corner
    around = np.linspace(0, 2 * np.pi, int(2 * np.pi * wire / (0.7 * cell)) + 1, endpoint=False)
    circle = wire * np.column_stack([np.cos(around), np.sin(around)])
    cells = ((plane[:, None, :] + circle - corner) / cell).astype(int).reshape(-1, 2)
    counts = np.bincount(cells @ [columns, 1], minlength=rows * columns).reshape(rows, columns)
    # The votes of a point on its own circle are the same number for every radius; a share of the
    # points is what is compared. Neighbours share their votes, so that the place of the cells has no
    # influence.
    votes = counts / len(plane)
    for axis in (0, 1):
        votes = convolve1d(votes, (0.25, 0.5, 0.25), axis=axis, mode="constant")
    return votes, corner + 0.5 * cell


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


def follow(sections: Sections) -> Trace:
    """The wire through ``sections``.

    Raises :class:`InputError` where they are no wire of :data:`MIN_TURNS` turns.
    """
    plane = sections.plane
    members = [np.flatnonzero(sections.wedge == wedge) for wedge in range(WEDGES)]
    chains = sorted(_chains(plane, members, 2 * NEAR * sections.wire_radius), key=len, reverse=True)
    if len(chains[0]) < SHORTEST:
        raise InputError(
            "the sections of the wire do not join to a helix; give the scan of one spring, cleaned of its holder"
        )
    # where a part of the turn is not seen, every coil is a chain of its own, and some join further
    long = [chain for chain in chains[:STARTS] if len(chain) >= max(SHORTEST, len(chains[0]) // 2)]
    followed = [_followed(chain, sections, members) for chain in long]
    hand, by_place = max(followed, key=lambda pair: len(pair[1]))
    places = np.array(sorted(by_place))
    index = np.array([by_place[place] for place in places])
    turn = (places + 0.5 * hand) / WEDGES
    if turn[-1] - turn[0] < MIN_TURNS:
        raise InputError(
            f"the wire could be followed over {turn[-1] - turn[0]:.2g} turns only; give more points, less noise or a cloud cleaned of all "
            "but one spring"
        )
    return Trace(turn, plane[index, 0], plane[index, 1], hand, sections.wire_radius)


def _chains(plane: Array, members: list[NDArray[np.intp]], reach: float) -> list[list[int]]:
    """Runs of sections in half planes that follow each other, where each is the nearest of the other."""
    after: dict[int, int] = {}
    for here, there in zip(members, members[1:] + members[:1], strict=True):
        if len(here) and len(there):
            apart = np.linalg.norm(plane[here][:, None] - plane[there][None], axis=2)
            forward, back, place = apart.argmin(axis=1), apart.argmin(axis=0), np.arange(len(here))
            linked = (back[forward] == place) & (apart[place, forward] < reach)
            after.update(zip(here[linked].tolist(), there[forward[linked]].tolist(), strict=True))
    chains = []
    for first in sorted(set(after) - set(after.values())) or sorted(after)[:1]:
        chain = [first]
        while chain[-1] in after and after[chain[-1]] != first:
            chain.append(after[chain[-1]])
        chains.append(chain)
    return chains or [[]]


def _followed(
    chain: list[int], sections: Sections, members: list[NDArray[np.intp]]
) -> tuple[int, dict[int, int]]:
    """The hand of a wire that begins with ``chain``, and its section by half plane, counted on: continued at either end
    where the wire before it points to.
    """
    plane = sections.plane
    hand = 1 if np.polyfit(np.arange(len(chain)), plane[chain, 1], 1)[0] > 0 else -1
    chain = chain[::hand]
    begin = hand * int(sections.wedge[chain[0]])
    by_place = {begin + step: section for step, section in enumerate(chain)}
    used = set(chain)
    for direction in (1, -1):
        last = begin + len(chain) - 1 if direction > 0 else begin
        missing = 0
        while missing <= GAP * WEDGES:
            place = last + direction * (missing + 1)
            behind = range(last, last - direction * int(BEHIND * WEDGES), -direction)
            seen = [number for number in behind if number in by_place]
            values = plane[[by_place[number] for number in seen]]
            ahead = values[0]
            if len(seen) > 3:
                slope, start = np.polyfit(np.array(seen) - last, values, 1)
                slope[1] = max(slope[1], 0.0)  # the wire never runs back
                ahead = start + slope * (place - last)
            free = [section for section in members[(hand * place) % WEDGES] if section not in used]
            apart = np.linalg.norm(plane[free] - ahead, axis=1)
            reach = 2 * sections.wire_radius * min(NEAR + GROWTH * missing, FARTHEST)
            if not len(free) or apart.min() >= reach:
                missing += 1
                continue
            by_place[place] = int(free[int(apart.argmin())])
            used.add(by_place[place])
            last, missing = place, 0
    return hand, by_place


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
        return np.asarray((points - self.origin) @ self.base.T)

    def outside(self, points: Array) -> Array:
        """Points (n, 3) of this frame where the scan has them."""
        return np.asarray(points @ self.base + self.origin)

    def moved(self, across: Array, tilt: Array) -> Frame:
        """The frame whose axis passes ``across`` (2,) at height zero and leans by ``tilt`` (2,) per
        height, both in this frame.
        """
        axis = np.array([tilt[0], tilt[1], 1.0])
        return Frame(
            self.outside(np.array([[across[0], across[1], 0.0]]))[0],
            across_and_along(axis @ self.base, self.base[0]),
        )


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
    away = np.linalg.norm(some - middle, axis=1)
    size = float(np.median(away)) or 1.0
    near = some[away < 5 * size]
    # Directions spread evenly over a hemisphere, and those of the cloud itself.
    height = (np.arange(DIRECTIONS) + 0.5) / DIRECTIONS
    turn, ring = np.pi * (1 + 5**0.5) * np.arange(DIRECTIONS), np.sqrt(1 - height**2)
    directions = np.column_stack([ring * np.cos(turn), ring * np.sin(turn), height])
    principal = np.linalg.svd(near - near.mean(axis=0), full_matrices=False)[2]
    starts = []
    for direction in (*principal, *directions):
        start = Frame(middle, across_and_along(direction))
        starts.append((_step(near[::4], _step(near[::4], start, size)[1], size)[0], start))
    settled = []
    for _, frame in sorted(starts, key=lambda pair: pair[0])[:FOLLOWED]:
        for _ in range(12):
            scatter, better = _step(near, frame, size)
            settled.append((scatter, frame))
            frame = better
    return min(settled, key=lambda pair: pair[0])[1]


def _step(points: Array, frame: Frame, size: float) -> tuple[float, Frame]:
    """Scatter of the radii about a smooth function of the height, and the frame that lowers it: one
    robust Gauss-Newton step.
    """
    x, y, z = frame.inside(points).T
    radius = np.hypot(x, y) + 1e-9 * size
    cosine, sine = x / radius, y / radius
    smooth = np.vander(np.clip(z / (2 * size), -1.5, 1.5), POWER + 1)
    basis = np.column_stack([smooth, cosine, sine, z * cosine, z * sine])
    root = np.ones(len(radius))

    def fitted(columns: Array) -> Array:
        return np.asarray(np.linalg.lstsq(columns * root[:, None], radius * root, rcond=1e-10)[0])

    for _ in range(3):
        shares = fitted(basis)
        left = radius - basis @ shares
        scale = 1.4826 * float(np.median(np.abs(left))) + 1e-9 * size
        root = np.clip(1 - (left / (4.685 * scale)) ** 2, 1e-3, None)
    now = radius - smooth @ fitted(smooth)
    scatter = float(np.mean(np.minimum(np.abs(now), 0.5 * size))) / size
    across, tilt = np.split(shares[POWER + 1 :], 2)
    across = across * min(1.0, 0.5 * size / (float(np.linalg.norm(across)) + 1e-12))
    tilt = tilt * min(1.0, 0.3 / (float(np.linalg.norm(tilt)) + 1e-12))
    return scatter, frame.moved(across, tilt)
