"""Contact transitions of one cycle as the integrator saw them, and what follows from them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from valvetrain.arrays import Array, Flags, Ints
from valvetrain.integrate.clash import runs
from valvetrain.integrate.train_tuples import (
    ANGLE,
    CLOSES,
    MAX_FORCE,
    MAX_GAP,
    MAX_GAP_ANGLE,
    PLACE,
    RATE,
)
from valvetrain.solution.status import Event

#: Share of the largest rigid lift above which a stretch is an event of the lift law.
LAW_SHARE = 0.01
#: Statistic that is 1 where the log holds every opening and closing of a cycle.
CONTACTS_LOGGED = "contacts_logged_ratio"


@dataclass(frozen=True)
class Transitions:
    """Every opening and closing of a contact in one cycle, in order of time; arrays of one length,
    one entry per transition.

    ``interaction``: place of the contact; ``closes``: True for a closing. ``cam_angle`` (rad): a
    parabola through three steps passes zero there. ``gap_rate`` (m/s): closing positive, negative
    at an opening. ``largest_gap`` (m) with its ``largest_gap_cam_angle`` (rad): of the open stretch
    next to the transition; ``largest_force`` (N): of the touching stretch next to it; both over every
    step, the first and last stretch of a contact as far as they are in the cycle. ``overflow``:
    transitions that the log had no space for.
    """

    interaction: Ints
    closes: Flags
    cam_angle: Array
    gap_rate: Array
    largest_gap: Array
    largest_gap_cam_angle: Array
    largest_force: Array
    overflow: int = 0

    @classmethod
    def from_log(cls, log: Array, count: int) -> Transitions:
        """From the rows of ``Records.transitions`` and how many there would have been."""
        rows = log[: min(count, len(log))]
        return cls(
            rows[:, PLACE].astype(np.int64),
            rows[:, CLOSES] > 0.5,
            rows[:, ANGLE],
            rows[:, RATE],
            rows[:, MAX_GAP],
            rows[:, MAX_GAP_ANGLE],
            rows[:, MAX_FORCE],
            max(0, count - len(log)),
        )

    def __len__(self) -> int:
        return len(self.interaction)

    def of(self, interaction: int) -> Transitions:
        """Those of one contact."""
        return self.where(self.interaction == interaction)

    def where(self, flag: Flags) -> Transitions:
        """Those that are marked."""
        return Transitions(
            self.interaction[flag],
            self.closes[flag],
            self.cam_angle[flag],
            self.gap_rate[flag],
            self.largest_gap[flag],
            self.largest_gap_cam_angle[flag],
            self.largest_force[flag],
            self.overflow,
        )

    def open_stretches(self, interaction: int) -> Transitions:
        """One entry per open stretch of a contact of a PERIODIC cycle: its closing, with the
        largest gap of the whole stretch.

        A stretch that passes the end of the cycle is joined: its largest gap is the greater of what
        was seen on either side. A stretch that neither opens nor closes in the cycle has no entry.
        """
        own = self.of(interaction)
        gap, angle = own.largest_gap.copy(), own.largest_gap_cam_angle.copy()
        for place in np.flatnonzero(own.closes):
            if (
                not own.closes[place - 1] and own.largest_gap[place - 1] > gap[place]
            ):  # place - 1 of the first is the last: a ring
                gap[place], angle[place] = (
                    own.largest_gap[place - 1],
                    own.largest_gap_cam_angle[place - 1],
                )
        whole = replace(own, largest_gap=gap, largest_gap_cam_angle=angle)
        return whole.where(own.closes)

    def touches(self, names: tuple[str, ...], cam_speed: float) -> tuple[Event, ...]:
        """Closings of the contacts ``names`` of a PERIODIC cycle as events ``touch``: size is the
        closing velocity (m/s).
        """
        found = []
        for place, name in enumerate(names):
            own, whole = self.of(place), self.open_stretches(place)
            opened = own.cam_angle[np.flatnonzero(own.closes) - 1]
            for k in range(len(whole)):
                angle, velocity = float(whole.cam_angle[k]), float(whole.gap_rate[k])
                details = {
                    "largest_gap": float(whole.largest_gap[k]),
                    "release_cam_angle": float(opened[k]),
                }
                found.append(
                    Event("touch", angle, angle / cam_speed, 0.0, velocity, "m/s", name, details)
                )
        return tuple(found)

    def main_closing(self, interaction: int) -> int | None:
        """Place in :meth:`open_stretches` of the closing that ends the stretch of the largest gap;
        None where the contact never closes.
        """
        stretches = self.open_stretches(interaction)
        return int(np.argmax(stretches.largest_gap)) if len(stretches) else None

    def seating_velocity(self, seat: int) -> float | None:
        """Closing gap rate (m/s) at the first touch of the contact ``seat`` after its main event;
        None where it never closes.
        """
        place = self.main_closing(seat)
        return None if place is None else float(self.open_stretches(seat).gap_rate[place])


def openings_by_law(spans: Array, heights: Array, cam_angle: Array, rigid: Array) -> list[int]:
    """Places of the openings of the seat that the lift law makes; the others are bounces.

    Parameters
    ----------
    spans : (openings, 2) cam angles (rad) of release and touch
    heights : (openings,) largest gaps (m)
    cam_angle, rigid : (samples,) angle (rad) and rigid lift (m) of one turn, even

    Returns
    -------
    The highest opening, and of every further event of the law the highest that meets it
    """
    turn, law = 2 * np.pi, [int(np.argmax(heights))] if len(heights) else []
    begins, lengths = spans[:, 0], (spans[:, 1] - spans[:, 0]) % turn
    step = turn / len(rigid)
    for first, last in runs(rigid > LAW_SHARE * np.max(rigid), ring=True):
        begin = cam_angle[first]
        meets = (begin - begins) % turn < lengths
        meets |= (begins - begin) % turn < (last - first) * step
        if np.any(meets):
            law.append(int(np.argmax(np.where(meets, heights, -1.0))))
    return law
