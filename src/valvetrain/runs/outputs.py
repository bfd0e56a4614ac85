"""A study with requested ``outputs`` alone: quantities and channels by name."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

from valvetrain.errors import InputError
from valvetrain.quantities.request import LIGHT, is_at_rest
from valvetrain.solution.channels import FINE, SPRING_CHANNELS, empty_channels
from valvetrain.solution.critical import KINDS
from valvetrain.solution.definition import is_defined, near_names, tables
from valvetrain.solution.result import Solution
from valvetrain.solution.study import Study
from valvetrain.solution.uncertainty import ErrorBars
from valvetrain.springs.stress import STRESS_CHANNELS

#: Channels at the ends of a spring, and all that a spring alone can have.
END_CHANNELS = (
    "valve_lift", "retainer_velocity", "retainer_acceleration", "retainer_force", "seat_force", "work_done", "retainer_force_fine",
    "seat_force_fine",
)  # fmt: skip
CHANNELS = (
    *END_CHANNELS, *SPRING_CHANNELS, *FINE, *STRESS_CHANNELS, "modal_coordinate", "seat_force_as_printed",
)  # fmt: skip


@dataclass(frozen=True)
class RequestedOutputs:
    """``quantities`` and ``channels`` by name, of a train where ``in_train``.

    >>> RequestedOutputs.of(["seat_force", "preload"], in_train=False).channels
    ('seat_force',)
    """

    quantities: tuple[str, ...]
    channels: tuple[str, ...]

    @classmethod
    def of(cls, names: Sequence[str] | str, in_train: bool) -> RequestedOutputs:
        """The request by ``names``. Raises :class:`InputError` for one that is neither, with the
        nearest; a channel of a train is known after its run.
        """
        every = tuple(dict.fromkeys([names] if isinstance(names, str) else names))
        channels = tuple(name for name in every if not is_defined(name))
        for name in channels if not in_train else ():
            if name.removeprefix("outer_").removeprefix("inner_") not in CHANNELS:
                raise _no_output(name, CHANNELS)
        return cls(tuple(name for name in every if is_defined(name)), channels)

    @property
    def searches(self) -> bool:
        """Whether a critical speed is requested."""
        return any(name in KINDS.values() for name in self.quantities)

    @property
    def ends_alone(self) -> bool:
        """Whether the forces at the ends of a spring and its clashes are enough."""
        light = all(name in LIGHT or is_at_rest(name) for name in self.quantities)
        return light and all(name in END_CHANNELS for name in self.channels)

    @property
    def rest(self) -> bool:
        """Whether the springs at rest are needed."""
        return not self.ends_alone or any(map(is_at_rest, self.quantities))

    def of_study(self, study: Study) -> Study:
        """The study with these outputs alone."""
        still: dict[str, dict[str, float]] = {}
        if self.searches or any(map(is_at_rest, self.quantities)):
            for label, values in study.still.items():
                named = {name.removeprefix(f"{label}_") for name in self.quantities}
                still[label] = {name: one for name, one in values.items() if name in named}
        return Study(
            study.record,
            study.command,
            tuple(map(self.of_run, study.solutions)),
            still=still,
            lift_event=study.lift_event,
            provenance=study.provenance,
            wall_time=study.wall_time,
            critical_speeds=study.critical_speeds,
            error_bars=ErrorBars(
                tuple(row for row in study.error_bars.rows if row.quantity in self.quantities)
            ),
        )

    def of_run(self, run: Solution) -> Solution:
        """One run with these outputs alone. Raises :class:`InputError` for a channel that it does
        not have.
        """
        found = {name: run.quantities[name] for name in self.quantities if name in run.quantities}
        channels = empty_channels()
        if len(run.time) and self.channels:
            for name in self.channels:
                if not run.has(name) and name not in CHANNELS:
                    raise _no_output(name, run.arrays.variables)
                run.channel(name)
            channels = run.arrays.only(self.channels)
        gaps = () if len(found) == len(self.quantities) else run.gaps
        origin = run.statistics, run.provenance
        return Solution(channels, run.events, run.status, *origin, found, gaps)


def _no_output(name: str, channels: Iterable[str]) -> InputError:
    """The error for a name that is neither quantity nor channel, with the nearest of both."""
    known = dict.fromkeys([*channels, *(row.name for rows in tables().values() for row in rows)])
    near = dict.fromkeys([*near_names(name)[:2], *get_close_matches(name[:60], known, 2, 0.5)])
    hint = (
        f"did you mean {' or '.join(near)}?" if near else "`valvetrain quantities` lists the names"
    )
    return InputError(f"'{name[:60]}' is no quantity and no channel; {hint}", "outputs")
