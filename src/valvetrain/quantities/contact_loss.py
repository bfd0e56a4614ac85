"""Contact forces of a train with rigid parts, and the speed at which the first contact is lost."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from valvetrain.arrays import Array, Ints
from valvetrain.mechanism.gaps import table_value
from valvetrain.system.rigid_pose import RigidPoses, soft_forces
from valvetrain.system.train_forces import gap_states
from valvetrain.system.train_system import TrainSystem

#: Distance (rad) from a jump of the law at which its two sides are looked at.
NEXT_TO = 1e-9
#: Lowest local minima of the coarse search that are followed to their exact angle: how many, and up
#: to which multiple of the lowest.
FOLLOWED, NEAR_LOWEST = 6, 1.1
#: A bracket is narrowed to an eighth in each round, all angles of a round at once.
ROUNDS, IN_ROUND = 8, 17


class ContactLoss(NamedTuple):
    """Cam speed (rad/s, infinite for never) at which a contact of the drive is first lost, the cam
    angle (rad) and the contact.
    """

    cam_speed: float
    cam_angle: float
    place: str


class ContactShares(NamedTuple):
    """Contact forces (S, contacts) by rigid theory as ``static`` (N) plus ``inertia`` (N s2) times
    cam speed squared, with the travel of the cam's normal per valve travel ``per_lift`` (S,) and
    per cam angle ``per_angle`` (S,) in m/rad.
    """

    static: Array
    inertia: Array
    per_lift: Array
    per_angle: Array


@dataclass(frozen=True, eq=False)
class RigidForces:
    """Newton's law for every body of a rigid train: M a = loads - G^T F, whose unknown F are the
    forces of contacts and links.

    ``static_spring_force``: force (N) of all springs at valve lifts (m).
    """

    system: TrainSystem
    poses: RigidPoses
    static_spring_force: Callable[[Array], Array]

    @cached_property
    def active(self) -> list[int]:
        """Interactions that carry unknown forces with the valve off its seat."""
        mechanism = self.system.mechanism
        return sorted({*mechanism.drive, *mechanism.held})

    @cached_property
    def places(self) -> tuple[str, ...]:
        """Contacts of the drive, which push and cannot pull, in the order of the shares."""
        return tuple(self.system.interaction_names[k] for k in self.system.mechanism.drive)

    def poses_at(self, valve_lift: Array) -> Array:
        """Lift (m) of the driving side, which is ahead of the valve by the lash once the valve is
        off its seat.
        """
        return np.where(valve_lift > 0, valve_lift + self.system.mechanism.kinematics.lash, 0.0)

    def gas(self, cam_angle: Array) -> Array:
        """Gas force (N, opening positive) on the valve at cam angles (S,) in rad."""
        arrays = self.system.arrays
        if arrays.gas_coordinate < 0:
            return np.zeros(len(cam_angle))
        return np.array([table_value(arrays.gas, 0, angle)[0] for angle in cam_angle.tolist()])

    def shares(self, cam_angle: Array) -> ContactShares:
        """Contact forces of the drive at cam angles (S,) in rad; meaningless where the valve is
        seated.
        """
        motion, system, arrays = self.system.mechanism.kinematics, self.system, self.system.arrays
        lift, velocity, acceleration = (motion.valve_lift(cam_angle, order) for order in range(3))
        tight = self.poses_at(lift)
        positions, modes = self.poses.positions(tight), self.poses.mode(tight)
        loads = arrays.body[:, 1] + soft_forces(system, positions)
        loads[:, arrays.retainer] -= self.static_spring_force(lift)
        loads[:, system.mechanism.index(system.mechanism.valve)] += self.gas(cam_angle)
        inertia = -system.masses * (
            modes * acceleration[:, None] + self.poses.mode(tight, 1) * velocity[:, None] ** 2
        )
        _, gradients, slopes = gap_states(system, positions, cam_angle)
        forces = _solved(
            np.swapaxes(gradients[:, self.active], 1, 2), np.stack([loads, inertia], axis=2)
        )
        driving, cam = [self.active.index(k) for k in system.mechanism.drive], system.mechanism.cam
        per_lift = -np.sum(gradients[:, cam] * modes, axis=1)
        return ContactShares(forces[:, driving, 0], forces[:, driving, 1], per_lift, slopes[:, cam])

    def first_loss(self, cam_angle: Array) -> ContactLoss:
        """The lowest cam speed at which a contact is lost, found to the exact angle from a coarse
        search over ``cam_angle`` (S,) in rad.

        A contact is lost where static + inertia * cam_speed**2 = 0. Between the jumps of the law
        that ratio is followed continuously, on both sides of every jump.
        """
        points, segment = self._points(cam_angle)
        squares = self._squares(points)
        starts = sorted(
            (squares[i, c], i, c)
            for c in range(len(self.places))
            for i in _low_points(squares[:, c], segment)
        )
        followed = [start for start in starts[:FOLLOWED] if start[0] <= NEAR_LOWEST * starts[0][0]]
        found = [ContactLoss(np.inf, np.nan, "")]
        for (square, place, contact), (angle, least) in zip(
            followed, self._minima(points, segment, followed), strict=True
        ):
            angle, least = (
                (angle, least) if least < square else (float(points[place]), float(square))
            )
            found.append(
                ContactLoss(
                    float(np.sqrt(least)), float(np.mod(angle, 2 * np.pi)), self.places[contact]
                )
            )
        # of equal minima on both sides of a symmetric nose the first
        least_speed = min(loss.cam_speed for loss in found)
        return min(
            (loss for loss in found if loss.cam_speed <= least_speed * (1 + 1e-9)),
            key=lambda loss: loss.cam_angle,
        )

    def _squares(self, cam_angle: Array) -> Array:
        """Squares of the cam speeds (S, contacts) at which each contact force is zero; infinite
        where it never is.
        """
        shares, opened = (
            self.shares(cam_angle),
            self.system.mechanism.kinematics.valve_lift(cam_angle)[:, None] > 0,
        )
        ratio = -shares.static / np.where(shares.inertia < 0, shares.inertia, -1.0)
        squares = np.where(shares.static <= 0, 0.0, np.where(shares.inertia < 0, ratio, np.inf))
        return np.where(opened, squares, np.inf)

    def _minima(
        self, points: Array, segment: Ints, starts: Sequence[tuple[float, int, int]]
    ) -> list[tuple[float, float]]:
        """Cam angle and value of the least square near each of ``starts`` (value, place, contact),
        within its own segment.
        """
        if not starts:
            return []
        near = [
            [n for n in (i - 1, i, i + 1) if 0 <= n < len(points) and segment[n] == segment[i]]
            for _, i, _ in starts
        ]
        low, high = np.array([[points[places[0]], points[places[-1]]] for places in near]).T
        rows, contacts = np.arange(len(starts)), np.array([contact for *_, contact in starts])
        for _ in range(ROUNDS):
            angles = np.linspace(low, high, IN_ROUND, axis=1)
            values = self._squares(angles.ravel()).reshape(len(starts), IN_ROUND, -1)[
                rows, :, contacts
            ]
            best = np.argmin(values, axis=1)
            low, high = (
                angles[rows, np.maximum(best - 1, 0)],
                angles[rows, np.minimum(best + 1, IN_ROUND - 1)],
            )
        return list(zip(angles[rows, best].tolist(), values[rows, best].tolist(), strict=True))

    def _points(self, cam_angle: Array) -> tuple[Array, Ints]:
        """Cam angles of the coarse search with both sides of every jump, and the smooth segment
        each is in.
        """
        motion = self.system.mechanism.kinematics
        turned = np.mod(np.asarray(motion.law.joints, dtype=float), 2 * np.pi)
        edges: Array = np.unique(np.round(np.append(turned, self.openings(cam_angle)), 12))
        points = np.unique(np.concatenate([cam_angle, edges - NEXT_TO, edges + NEXT_TO]))
        points = points[~np.isin(points, edges)]
        return points, np.searchsorted(edges, points)

    def openings(self, cam_angle: Array) -> Array:
        """Cam angles (rad) between those given where the valve leaves or meets its seat, by
        bisection.
        """
        motion = self.system.mechanism.kinematics
        ring = np.append(cam_angle, cam_angle[0] + 2 * np.pi)
        up = motion.valve_lift(ring) > 0
        places = np.flatnonzero(up[1:] != up[:-1])
        low, high, before = ring[places], ring[places + 1], up[places]
        for _ in range(50):
            middle = (low + high) / 2
            same = (motion.valve_lift(middle) > 0) == before
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        return np.asarray(np.mod(high, 2 * np.pi))


def _solved(matrices: Array, sides: Array) -> Array:
    """Least-squares answers (S, n, m) of systems (S, N, n): solved at once where they are square
    and regular, else by singular values.
    """
    if matrices.shape[1] == matrices.shape[2]:
        with suppress(np.linalg.LinAlgError):
            return np.asarray(np.linalg.solve(matrices, sides), dtype=float)
    return np.stack(
        [
            np.linalg.lstsq(matrix, side, rcond=None)[0]
            for matrix, side in zip(matrices, sides, strict=True)
        ]
    )


def _low_points(values: Array, segment: Ints) -> list[int]:
    """Indices of local minima of finite ``values`` within their segments."""
    before = np.where(
        np.append(-1, segment[:-1]) == segment, np.append(np.inf, values[:-1]), np.inf
    )
    after = np.where(np.append(segment[1:], -1) == segment, np.append(values[1:], np.inf), np.inf)
    return [
        int(i) for i in np.flatnonzero(np.isfinite(values) & (values <= before) & (values <= after))
    ]
