"""Springs and a compiled driver that the spring tests share."""

from __future__ import annotations

import numpy as np
from numba import njit

from spring_shapes import cylindrical
from valvetrain.cosserat.buffer import RodDynamics
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.massless import MasslessSpring, MasslessTable, massless_table
from valvetrain.springs.modal_uniform import ModalUniform
from valvetrain.springs.modal_varied import ModalVaried
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.nested import NestedSprings, RadialRubbing
from valvetrain.springs.reduced_rod import ReducedRod
from valvetrain.springs.wave_rod import WaveRod
from valvetrain.springs.wave_rod_clash import WaveRodWithClash

PRECOMPRESSION = 7e-3
CLOSED_ENDS = cylindrical(3.8e-3, 22e-3, 7e-3, 8.0)
OPEN_SPRING = cylindrical(3.8e-3, 22e-3, 7e-3, 6.0, ends="open")
UNIFORM = EquivalentSpring(rate=30e3, preload=250.0, active_mass=0.04, inactive_mass=0.004)
SLIM = EquivalentSpring(rate=14e3, preload=136.0, active_mass=0.02)
#: Natural frequencies (Hz) of the modal springs, not quite those of a uniform bar.
FREQUENCIES = (430.0, 800.0, 1200.0)


def straight_modal(damping_ratio: float = 0.0) -> ModalVaried:
    """The modal spring of varied stiffness on a straight line through the origin: 30 N/mm, 250 N as
    installed.
    """
    return ModalVaried(
        FREQUENCIES, damping_ratio, (1e-5, 0.1), (0.3, 3000.0), 250.0 / 30e3, residual_mass=0.002
    )


def curved_modal() -> ModalVaried:
    """The same on the static curve of a wire whose coils close, from its free state on."""
    curve = massless_table(CLOSED_ENDS, PRECOMPRESSION, 14e-3, points=81)
    compressions = tuple(x + PRECOMPRESSION for x in curve.displacements[1:])
    return ModalVaried(FREQUENCIES, 0.016, compressions, curve.forces[1:], PRECOMPRESSION)


def build_models() -> dict:
    """Every spring model of the package once, with and without contact and damping."""
    return {
        "massless": MasslessSpring(30e3, 250.0, 0.04),
        "massless-table": MasslessTable(
            (-1e-3, 0.0, 4e-3, 12e-3), (220.0, 250.0, 390.0, 710.0), 0.04
        ),
        "chain": MultiMassSpring.from_definition(CLOSED_ENDS, PRECOMPRESSION),
        "chain-damped": MultiMassSpring.from_definition(
            CLOSED_ENDS, PRECOMPRESSION, mass_damping=60.0, stiffness_damping=2e-6
        ),
        "chain-no-clash": MultiMassSpring.from_definition(
            CLOSED_ENDS, PRECOMPRESSION, contact_stiffness=0.0
        ),
        "chain-7-per-coil": MultiMassSpring.from_definition(
            CLOSED_ENDS.replace(total_coils=7.93), PRECOMPRESSION, masses_per_coil=7
        ),
        "chain-card": MultiMassSpring.from_card(30e3, 250.0, 0.04, elements=5),
        "chain-one-mass": MultiMassSpring.from_card(30e3, 250.0, 0.04, elements=2),
        "wave-rod": WaveRod(UNIFORM),
        "rod-damped": WaveRod(UNIFORM, friction=30.0),
        "wave-rod-clash": WaveRodWithClash.from_definition(CLOSED_ENDS, PRECOMPRESSION, cells=150),
        "modal-uniform": ModalUniform(UNIFORM, 6),
        "modal-damped": ModalUniform(
            UNIFORM, 3, (430.0, 800.0, 1200.0), damping_ratio=0.016, mass_damping=20.0
        ),
        "modal-varied": straight_modal(),
        "modal-varied-damped": straight_modal(0.016),
        "modal-varied-curved": curved_modal(),
        "finite-element": FiniteElementRod(CLOSED_ENDS, PRECOMPRESSION, elements_per_coil=24),
        "reduced-rod": ReducedRod(FiniteElementRod(CLOSED_ENDS, PRECOMPRESSION, 12)),
        "reduced-rod-damped": ReducedRod(
            FiniteElementRod(CLOSED_ENDS, PRECOMPRESSION, 12, RodDynamics(60.0, 2e-6))
        ),
        "nested": NestedSprings(
            MultiMassSpring.from_definition(CLOSED_ENDS, PRECOMPRESSION), WaveRod(SLIM, 100)
        ),
        "nested-rubbing": NestedSprings(
            MultiMassSpring.from_definition(CLOSED_ENDS, PRECOMPRESSION),
            WaveRod(SLIM, 100),
            RadialRubbing(0.12, 60.0),
        ),
    }


MODELS = build_models()
LINEAR_RATE = dict.fromkeys(
    ("massless", "chain-card", "chain-one-mass", "wave-rod", "rod-damped", "modal-uniform", "modal-damped", "modal-varied",
     "modal-varied-damped"), 30e3,
)  # fmt: skip


@njit
def _drive(kernel, parameters, integers, state, displacement, velocity, time_step, forces):
    for k in range(displacement.shape[0]):
        forces[k, 0], forces[k, 1] = kernel(
            parameters, integers, state, displacement[k], velocity[k], time_step
        )


def drive(model, state, displacement, velocity, time_step) -> np.ndarray:
    """Step ``state`` in place along a prescribed retainer motion; returns retainer and seat force,
    shape (steps, 2).
    """
    forces = np.empty((len(displacement), 2))
    _drive(
        model.kernel,
        model.parameters(),
        model.integers(),
        state,
        displacement,
        velocity,
        time_step,
        forces,
    )
    return forces


def raised_cosine(
    lift: float, duration: float, time_step: float, rest: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Displacement (m) and velocity (m/s) of one smooth opening and closing, then ``rest`` seconds
    closed.
    """
    time = np.arange(round((duration + rest) / time_step) + 1) * time_step
    # sin**4 keeps acceleration and jerk continuous at both ends.
    phase = np.where(time < duration, np.pi * time / duration, 0.0)
    return lift * np.sin(phase) ** 4, 4 * lift * np.pi / duration * np.sin(phase) ** 3 * np.cos(
        phase
    )


#: A spring that buckles before it is solid, and the same in a bore.
SLENDER = """
[spring]
wire_diameter = "1 mm"
mean_diameter = "10 mm"
pitch = "4 mm"
total_coils = 20
ends = "open"
material = { youngs_modulus = "206 GPa", shear_modulus = "79.6 GPa", density = "7850 kg/m^3" }
precompression = "8 mm"
[spring.options.finite-element]
elements_per_coil = 8
"""
GUIDED = SLENDER + '[spring.guide]\nbore = "12 mm"\n'
