"""One point of a study, and what came out of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from valvetrain.errors import InputError
from valvetrain.explore.space import ENGINE_SPEED, Varied
from valvetrain.parameters.case import Case
from valvetrain.solution.status import COMPLETED, Status

#: Quantities that follow from forces at the ends, lift and clashes alone: neither channels of the
#: wire nor its states at rest are needed.
LIGHT = frozenset((
    "peak_spring_force", "peak_spring_force_cam_angle", "minimum_spring_force", "minimum_spring_force_cam_angle", "peak_retainer_force",
    "minimum_retainer_force", "below_20_khz_peak_spring_force", "below_10_khz_peak_spring_force", "nominal_peak_shear_stress",
    "nominal_minimum_shear_stress", "peak_valve_lift", "coil_bind_clearance", "clash_count", "clash_energy", "peak_clash_force",
    "largest_clash_energy", "largest_clash_impulse", "time_step_duration", "steps_per_cycle_count", "steady_cycles_count",
))  # fmt: skip
#: Quantities of a spring at rest begin with one of these.
AT_REST = (
    "preload", "installed_", "mode_", "natural_", "stiffness_change_", "solid_", "free_length", "coil_1_2_installed_gap", "buckling_",
    "rigid_", "largest_pitch", "wire_mass", "wire_length", "smallest_i", "largest_index", "largest_outer", "estimated_", "card_",
    "total_coil", "active_coil", "coil_bind_lift", "formula_buckling",
)  # fmt: skip
#: Of these, what follows from the sizes of the spring alone, or from its card: no static curve is
#: needed.
BY_SIZE = (
    "free_length", "solid_height", "largest_pitch", "solid_force", "solid_nominal_shear_stress", "solid_compression", "wire_mass",
    "wire_length", "smallest_index_ratio", "largest_index_ratio", "largest_outer_diameter", "smallest_inner_diameter", "estimated_rate",
    "estimated_surge_frequency", "total_coil_count", "active_coil_count", "coil_bind_lift", "installed_compression", "installed_height",
    "formula_buckling_compression", "card_rate", "card_preload", "card_mass", "card_installed_height", "card_open_force", "card_open_lift",
    "card_solid_height", "card_surge_frequency",
)  # fmt: skip
#: What rigid theory says of a train whose parts stand still.
RIGID = "rigid_"


@dataclass(frozen=True, slots=True)
class PointRequest:
    """Which numbers a point gives.

    ``outputs``: names of quantities (docs/quantities.md); empty for all that there are, which costs
    most. ``rest_model``: word of the
    spring model that numbers at rest (preload, rate, frequencies) come from; empty for the
    finite-element rod, as in a run.
    """

    outputs: tuple[str, ...] = ()
    rest_model: str = ""

    @property
    def light(self) -> bool:
        """Whether the forces at the ends and the clashes are enough for the motion."""
        return bool(self.outputs) and all(
            name in LIGHT or is_at_rest(name) for name in self.outputs
        )

    @property
    def rest(self) -> bool:
        """Whether a number at rest is asked for."""
        return not self.outputs or any(map(is_at_rest, self.outputs))

    @property
    def sizes_alone(self) -> bool:
        """Whether of a spring at rest nothing but its sizes is asked for."""
        still = [name for name in self.outputs if is_at_rest(name)]
        return bool(self.outputs) and all(
            _bare(name) in BY_SIZE or name.startswith(RIGID) for name in still
        )

    @property
    def rigid(self) -> bool:
        """Whether rigid theory is asked for."""
        return any(name.startswith(RIGID) for name in self.outputs)

    @property
    def motion(self) -> bool:
        """Whether a number of a run is asked for."""
        return not self.outputs or not all(map(is_at_rest, self.outputs))


def is_at_rest(name: str) -> bool:
    """Whether a quantity belongs to a spring at rest, of one of a nested pair too."""
    return _bare(name).startswith(AT_REST)


def _bare(name: str) -> str:
    """A name without that of the spring of a nested pair in front."""
    first, _, rest = name.partition("_")
    return rest if first in ("outer", "inner") else name


@dataclass(frozen=True)
class Point:
    """One point: a case, what is varied in it (SI), the engine speed (rad/s of the crank; None for
    numbers at rest alone), the word of the
    spring model and the spring set of a train (empty: the case's own).

    >>> import valvetrain as vt
    >>> Point(vt.load_case("job-t"), ((Varied(ENGINE_SPEED, "rpm"), 300.0),)).speed
    300.0
    """

    case: Case
    values: tuple[tuple[Varied, float], ...] = ()
    engine_speed: float | None = None
    spring_model: str = ""
    spring_set: str = ""
    wanted: PointRequest = PointRequest()

    @property
    def speed(self) -> float | None:
        """Engine speed (rad/s), the varied one where it is varied."""
        return next(
            (value for varied, value in self.values if varied.key == ENGINE_SPEED),
            self.engine_speed,
        )


@dataclass(frozen=True)
class Outcome:
    """What came out of a point: how it ended, and values (SI) by quantity; a point that failed
    keeps what it has.
    """

    status: Status = COMPLETED
    values: Mapping[str, float] = field(default_factory=dict)

    def __getitem__(self, name: str) -> float:
        if name not in self.values:
            raise InputError(f"the point gave no '{name[:60]}'; it is {self.status.sentence()}")
        return self.values[name]
