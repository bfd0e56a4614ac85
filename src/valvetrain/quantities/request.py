"""What a request for named quantities needs: motion, channels inside a spring, springs at rest."""

from __future__ import annotations

from dataclasses import dataclass

from valvetrain.solution.definition import NESTED, PAIR

#: Quantities that follow from forces at the ends, lift and clashes alone, without channels of the
#: wire or its static states.
LIGHT = frozenset((
    "peak_spring_force", "peak_spring_force_cam_angle", "minimum_spring_force", "minimum_spring_force_cam_angle", "peak_retainer_force",
    "minimum_retainer_force", "raw_peak_spring_force", "raw_peak_spring_force_cam_angle", "raw_peak_spring_force_duration",
    "raw_peak_retainer_force", "raw_peak_retainer_force_duration", "open_nominal_shear_stress",
    "closed_nominal_shear_stress", "open_uncorrected_shear_stress", "peak_valve_lift", "coil_bind_clearance", "wound_least_clearance",
    "wound_most_clearance", "clash_count", "clash_energy",
    "peak_clash_force", "surge_clash_peak_force", "largest_clash_energy", "largest_clash_impulse", "time_step_duration",
    "steps_per_cycle_count", "steady_cycles_count",
))  # fmt: skip
#: Static quantities of a spring begin with one of these.
AT_REST = (
    "preload", "installed_", "mode_", "natural_", "stiffness_change_", "solid_", "free_length", "coil_1_2_installed_gap", "buckling_",
    "rigid_", "largest_pitch", "wire_mass", "wire_length", "smallest_i", "largest_index", "largest_outer", "estimated_", "card_",
    "total_coil", "active_coil", "coil_bind_lift", "formula_buckling", "computed_solid",
)  # fmt: skip
#: Of these, what follows without a static curve from the dimensions of the spring or its card.
BY_SIZE = (
    "free_length", "solid_height", "largest_pitch", "solid_force", "solid_nominal_shear_stress", "solid_compression", "wire_mass",
    "wire_length", "smallest_index_ratio", "largest_index_ratio", "largest_outer_diameter", "smallest_inner_diameter", "estimated_rate",
    "estimated_surge_frequency", "total_coil_count", "active_coil_count", "coil_bind_lift", "installed_compression", "installed_height",
    "formula_buckling_compression", "card_rate", "card_preload", "card_mass", "card_installed_height", "card_open_force", "card_open_lift",
    "card_solid_height", "card_surge_frequency", "computed_solid_height",
)  # fmt: skip
#: Quantities of rigid theory for a train.
RIGID = "rigid_"


@dataclass(frozen=True, slots=True)
class PointRequest:
    """Names of the ``outputs`` of a point (docs/quantities.md), empty for all; ``rest_model``:
    spring model of the static quantities, empty for the finite-element rod, as in a run.
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
        """Whether a static quantity is requested."""
        return not self.outputs or any(map(is_at_rest, self.outputs))

    @property
    def sizes_alone(self) -> bool:
        """Whether the dimensions of the spring suffice for its static quantities."""
        still = [name for name in self.outputs if is_at_rest(name)]
        return bool(self.outputs) and all(
            _bare(name) in BY_SIZE or name.startswith(RIGID) for name in still
        )

    @property
    def rigid(self) -> bool:
        """Whether rigid theory is requested."""
        return any(name.startswith(RIGID) for name in self.outputs)

    @property
    def motion(self) -> bool:
        """Whether a quantity of a run is requested."""
        return not self.outputs or not all(map(is_at_rest, self.outputs))


def is_at_rest(name: str) -> bool:
    """Whether a quantity belongs to a spring at rest, of one of a nested pair too."""
    return _bare(name).startswith(AT_REST)


def _bare(name: str) -> str:
    """A name without that of the spring of a nested pair in front."""
    first, _, rest = name.partition("_")
    return rest if first in (*NESTED, PAIR) else name
