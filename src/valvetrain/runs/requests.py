"""What may be requested of a case: one frozen model per command.

The fields of a model are the options on the command line, the arguments in Python and what is stored of the request.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

from valvetrain.errors import InputError
from valvetrain.runs.cost import Cost, Limits
from valvetrain.runs.request_fields import (
    Fields,
    option,
    options_of,
    read_amount,
    read_amounts,
    read_case,
    read_choices,
    read_count,
    read_limit,
    read_models,
    read_names,
    read_path,
    read_positive,
    read_speed,
    read_speeds,
    read_switch,
    read_text,
)

if TYPE_CHECKING:
    from valvetrain.parameters.case import Case
    from valvetrain.runs.critical_speeds import CriticalOptions
    from valvetrain.runs.outputs import RequestedOutputs
    from valvetrain.solution.result import Solution

RPM = math.pi / 30
#: Most runs at a time; largest count of steps or modes, since what a smaller one costs decides whether it is too large.
MAX_WORKERS, MAX_COUNTED = 256, 10**9


@dataclass(frozen=True)
class Watch:
    """Who watches what a request computes.

    ``progress``: called with the share done and a text; ``finished``: called with index and solution of each run as it
    arrives; ``created_at``: time (ISO) that the results bear.
    """

    progress: Callable[[float, str], None] | None = None
    finished: Callable[[int, Solution], None] | None = None
    created_at: str = ""


@dataclass(frozen=True, kw_only=True)
class Limited(Fields):
    """A request that may cost so much."""

    limit: Limits = option(
        read_limit,
        "Raise the limits of 10 min and 2 GB for this request: '2 h', '8 GB'. Repeatable.",
        "--limit",
        "BOUND",
        default=Limits(),
        repeatable=True,
    )


@dataclass(frozen=True, kw_only=True)
class Clustered(Fields):
    """What a cluster can compute."""

    dask: str = option(
        read_text,
        "Compute on a Dask cluster: 'local', the address of a scheduler, or the path of its file.",
        "--dask",
        "CLUSTER",
        default="",
    )


@dataclass(frozen=True, kw_only=True)
class Parallel(Fields):
    """A request of several runs at a time."""

    workers: int | None = option(
        partial(read_count, 1, MAX_WORKERS),
        "Runs at a time (default: the cores there are, at most 4).",
        "--workers",
        "N",
    )

    @property
    def worker_count(self) -> int:
        """Runs at a time: those requested, else what this machine or the cluster in use takes."""
        from valvetrain.runs.workers import worker_count

        return worker_count(self.workers)


@dataclass(frozen=True, kw_only=True)
class Request(Limited):
    """What every request of a case has: the case, and whether implausible values pass."""

    case: Case = option(
        read_case,
        "Name of a library case (see 'valvetrain cases') or path of a case file.",
        metavar="CASE",
    )
    implausible: bool = option(
        read_switch,
        "Accept values outside the plausible ranges instead of refusing them.",
        "--implausible",
        default=False,
    )

    def stored(self) -> dict[str, Any]:
        """What is stored of the request beside its case: each field as it was typed, else its value."""
        stored: dict[str, Any] = {"command": self.command}
        for name, asked in options_of(type(self)).items():
            if asked.flag and name not in ("workers", "limit"):
                value = self.typed.get(name) or asked.default or getattr(self, name)
                stored[name] = list(value) if isinstance(value, tuple) else value
        return stored


@dataclass(frozen=True, kw_only=True)
class SpringRequest(Request):
    """A request of chosen spring models and spring sets."""

    models: tuple[str, ...] = option(
        read_models,
        "Spring models, such as massless,multi-mass,wave-rod,finite-element; repeatable.",
        "--model",
        "MODELS",
        default=(),
        repeatable=True,
    )
    spring_sets: tuple[str, ...] = option(
        read_names,
        "Spring sets of a train, such as stock,performance; repeatable.",
        "--spring-set",
        "SETS",
        default=(),
        repeatable=True,
    )


@dataclass(frozen=True, kw_only=True)
class ParallelRequest(Parallel, Request):
    """A request of several runs of a case at a time."""


@dataclass(frozen=True, kw_only=True)
class SteadyRequest(ParallelRequest):
    """A request of runs at engine speeds. Without a speed those of the case are taken."""

    engine_speeds: tuple[float, ...] | None = option(
        read_speeds,
        "Crank speeds instead of the case's own, in rpm: '4200, 5600', '1000:9000:500' or '4000-8000'.",
        "--rpm",
        "SPEEDS",
    )


@dataclass(frozen=True, kw_only=True)
class SpeedRequest(SpringRequest, SteadyRequest):
    """A request of runs of chosen springs at engine speeds, and of what is kept of them."""

    compute: tuple[str, ...] = option(
        partial(read_choices, ("error_bars",)), "What else is computed.", default=()
    )
    outputs: tuple[str, ...] = option(
        read_names, "Quantities and channels that alone are computed.", default=()
    )
    whole: bool = option(read_switch, "Store the channels of every solution.", default=True)

    @cached_property
    def requested(self) -> RequestedOutputs | None:
        """The outputs that alone are computed; None for all."""
        if not self.outputs:
            return None
        from valvetrain.runs.outputs import RequestedOutputs

        return RequestedOutputs.of(self.outputs, self.case.train is not None)

    @property
    def critical_options(self) -> CriticalOptions | None:
        """How critical speeds are searched; None where they are not."""
        return None

    def cost(self) -> Cost:
        """Estimated time and memory."""
        from valvetrain.runs.cost import RunRequest, request_cost

        parts = self.models, self.spring_sets, self.worker_count
        costs = RunRequest(self.command, self.case, self.engine_speeds, *parts)
        return request_cost(costs, self.whole, self.critical_options is not None)

    def with_speeds(self) -> Self:
        """The request with the engine speeds that the command takes where none is given."""
        return self


@dataclass(frozen=True, kw_only=True)
class Run(SpeedRequest):
    """A case at its engine speeds, or at given ones."""

    command = "run"


@dataclass(frozen=True, kw_only=True)
class Compare(SpeedRequest):
    """A case by several spring models side by side."""

    command = "compare"


@dataclass(frozen=True, kw_only=True)
class Sweep(SpeedRequest):
    """A case over engine speed, with the critical speeds of a train."""

    command = "sweep"
    #: Step (rpm) between engine speeds where none is given.
    step: ClassVar[int] = 100
    #: Share of the highest speed in use (red line) from which it begins; 0: from 1000 rpm.
    begin: ClassVar[float] = 0.0

    critical_speeds: bool = option(
        read_switch,
        "Search where a train loses contact, floats and bounces.",
        "--critical-speeds/--no-critical-speeds",
        default=True,
    )
    resolution: float = option(
        partial(read_positive, "engine_speed"),
        "A fifth of the distance of the speeds at which critical speeds are looked for.",
        "--resolution",
        "SPEED",
        default="10 rpm",
    )
    float_lift: float = option(
        partial(read_positive, "length"),
        "Lift above the rigid lift beyond which a valve floats.",
        "--float-lift",
        "LIFT",
        default="0.05 mm",
    )
    ranges: bool = option(
        read_switch,
        "Repeat each critical speed with finer numerics and other damping.",
        "--ranges/--no-ranges",
        default=True,
    )
    measured: Path | None = option(
        read_path,
        "Bounce and loft of a spin rig over engine speed (CSV), laid over the sweep.",
        "--measured",
        "FILE",
    )
    whole: bool = option(read_switch, "Store the channels of every solution.", default=False)

    @property
    def critical_options(self) -> CriticalOptions | None:
        """How critical speeds are searched; None where none is requested."""
        if not self.critical_speeds or (self.requested and not self.requested.searches):
            return None
        from valvetrain.runs.critical_speeds import CriticalOptions
        from valvetrain.solution.critical import BOUNCE_HEIGHT

        bounce = self.case.limits.bounce or BOUNCE_HEIGHT
        return CriticalOptions(self.resolution, self.float_lift, bounce, self.ranges)

    def with_speeds(self) -> Self:
        """The request with speeds to 1.2 times the red line where none is given."""
        if self.engine_speeds is not None:
            return self
        speeds = sweep_speeds(self.case, self.step)
        first = min(self.begin * self.case.operation.top_speed, speeds[-1])
        return replace(self, engine_speeds=tuple(one for one in speeds if one >= first))


@dataclass(frozen=True, kw_only=True)
class CompareSprings(Sweep):
    """Two springs side by side in one engine over its speed, by default from half of its red line."""

    command = "compare-springs"
    step = 500
    begin = 0.5


@dataclass(frozen=True, kw_only=True)
class Parts(Sweep):
    """Parts of a train by the engine speed of control that each gains."""

    command = "study"

    def __post_init__(self) -> None:
        """Raise :class:`InputError` for a case without a train, and several spring sets or models."""
        train = self.case.train
        if train is None:
            raise InputError(
                f"case '{self.case.name}' has no [train], so no part of one can be ranked; give an engine, such as "
                "'valvetrain new my-engine --kind pushrod' writes"
            )
        for name, given in (("models", self.models), ("spring_sets", self.spring_sets)):
            if len(given) > 1:
                raise InputError("parts are ranked of one spring set by one model; give one", name)
        used = self.spring_sets or (train.spring_set or next(iter(train.springs)),)
        object.__setattr__(self, "spring_sets", used)

    def cost(self) -> Cost:
        """Estimated time and memory: those of a sweep, and of some twelve searches near its critical speed."""
        swept = super().cost()
        return Cost(3.3 * swept.seconds, swept.bytes)


@dataclass(frozen=True, kw_only=True)
class RunUp(SpringRequest, ParallelRequest):
    """A train from one engine speed to another at constant acceleration."""

    command = "run-up"

    first_engine_speed: float = option(
        read_speed,
        "Engine speed at the start, in steady motion.",
        "--from",
        "SPEED",
        default="1000 rpm",
    )
    last_engine_speed: float = option(
        read_speed,
        "Engine speed at the end; a lower one is a run-down.",
        "--to",
        "SPEED",
        default="6000 rpm",
    )
    duration: float = option(
        partial(read_positive, "time"),
        "Duration of the run-up.",
        "--duration",
        "TIME",
        default="2 s",
    )

    @property
    def ramp(self) -> tuple[float, float, float]:
        """First and last engine speed (rad/s) and the time between them (s)."""
        return self.first_engine_speed, self.last_engine_speed, self.duration

    def cost(self) -> Cost:
        """Estimated time and memory."""
        from valvetrain.runs.cost import RunRequest, run_up_cost

        parts = self.models, self.spring_sets, self.worker_count
        return run_up_cost(RunRequest(self.command, self.case, None, *parts), self.ramp)


#: Most cam revolutions of a march up and down.
MARCHED = 40_000


@dataclass(frozen=True, kw_only=True)
class March(SpringRequest):
    """A march of a train up and down through engine speeds."""

    command = "branches"

    engine_speeds: tuple[float, ...] = option(
        read_speeds,
        "Speeds of the march: '7000:9700:25 rpm' (default: from 0.7 to 1.2 times the red line).",
        "--rpm",
        "SPEEDS",
        default=(),
    )
    quantity: str = option(
        read_text,
        "loft_gap, seating_velocity, float_excess_lift, ...",
        "--quantity",
        "NAME",
        default="loft_gap",
    )
    revolutions: int = option(
        partial(read_count, 1, 10**7),
        "Cam revolutions of the march at most.",
        "--revolutions",
        "N",
        default=f"{MARCHED}",
    )

    @property
    def march_speeds(self) -> tuple[float, ...]:
        """Those that were asked for (rad/s), else from 0.7 to 1.2 times the top speed of the case in steps of 1 %."""
        top = self.case.operation.top_speed or 6000 * RPM
        return self.engine_speeds or tuple(top * share / 100 for share in range(70, 121))

    def cost(self) -> Cost:
        """Estimated time and memory."""
        from valvetrain.runs.cost import RunRequest, march_cost

        parts = self.march_speeds, self.models, self.spring_sets, 1
        return march_cost(RunRequest(self.command, self.case, *parts), self.revolutions)


@dataclass(frozen=True, kw_only=True)
class Static(SpringRequest):
    """Springs at rest: force, stiffness and stress over compression, and at heights and loads."""

    command = "static"

    largest_compression: float | None = option(
        partial(read_amount, "compression"),
        "Largest compression, such as '12 mm' (default: beyond full lift).",
        "--to",
        "LENGTH",
    )
    steps: int = option(
        partial(read_count, 2, MAX_COUNTED), "Number of even steps.", "--steps", "N", default="24"
    )
    heights: tuple[float, ...] = option(
        partial(read_amounts, "length"),
        "Height between the seats to solve too: '32 mm'. Repeatable.",
        "--height",
        "LENGTH",
        default=(),
        repeatable=True,
    )
    loads: tuple[float, ...] = option(
        partial(read_amounts, "force"),
        "Load to solve as well: '400 N'. Repeatable.",
        "--load",
        "FORCE",
        default=(),
        repeatable=True,
    )

    def cost(self) -> Cost:
        """Estimated time and memory."""
        from valvetrain.runs.cost import static_cost

        # a load takes some dozen heights to find
        heights = self.steps + len(self.heights) + 12 * len(self.loads)
        return static_cost(self.case, self.models, spring_sets=self.spring_sets, heights=heights)


@dataclass(frozen=True, kw_only=True)
class Modes(SpringRequest):
    """Natural frequencies of springs, and of a train with its springs."""

    command = "modes"
    #: Even steps of the static curve that is computed along with them.
    steps: ClassVar[int] = 24

    count: int = option(
        partial(read_count, 1, MAX_COUNTED),
        "Number of modes, lowest first.",
        "--count",
        "N",
        default="24",
    )
    compression: float | None = option(
        partial(read_amount, "compression"),
        "Compression to compute them at: '7 mm' (default: installed).",
        "--compression",
        "LENGTH",
    )
    attached_mass: float | None = option(
        partial(read_amount, "mass"),
        "Mass that moves with the retainer: '50 g' (default: both ends fixed).",
        "--attached-mass",
        "MASS",
    )
    free_end: bool = option(
        read_switch,
        "The retainer end is free to move along the axis, without a mass.",
        "--free-end",
        default=False,
    )

    def __post_init__(self) -> None:
        """Raise :class:`InputError` for a free end with a mass."""
        if self.free_end and self.attached_mass is not None:
            raise InputError(
                "a free end has no mass attached; give --free-end or --attached-mass", "free_end"
            )

    @property
    def end_mass(self) -> float | None:
        """Mass (kg) that moves with the retainer, 0 for a free end; None for both ends fixed."""
        return 0.0 if self.free_end else self.attached_mass

    def cost(self) -> Cost:
        """Estimated time and memory."""
        from valvetrain.runs.cost import static_cost

        sizes = {"heights": self.steps, "modes": self.count}
        return static_cost(self.case, self.models, spring_sets=self.spring_sets, **sizes)


@dataclass(frozen=True, kw_only=True)
class Refine(SteadyRequest):
    """Error bars of the headline numbers of a case."""

    command = "refine"

    def cost(self) -> Cost:
        """Estimated time and memory."""
        from valvetrain.runs.cost import refine_cost

        return refine_cost(self.case, self.engine_speeds, self.worker_count)


def sweep_speeds(case: Case, step: int = 100) -> tuple[float, ...]:
    """Crank speeds (rad/s) of a sweep that names none: from 1000 rpm to 1.2 times the red line, else the highest speed of
    the case, else to 9000 rpm.

    Parameters
    ----------
    case : the case that is swept
    step : between two speeds (rpm); larger by a whole factor where more than a hundred speeds would follow

    Examples
    --------
    >>> import valvetrain as vt
    >>> speeds = sweep_speeds(vt.parameters.loading.load_case("tdi-pushrod"))
    >>> round(speeds[-1] * 30 / math.pi)
    4800
    """
    top = 1.2 * case.operation.top_speed / RPM or 9000
    step *= math.ceil(top / (100 * step))
    last = max(step * math.ceil(top / step - 1e-9), 1000)
    return tuple(speed * RPM for speed in range(1000, last + 1, step))
