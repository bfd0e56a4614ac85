"""Wrong input about springs: each slip gets one sentence that names it, or what was meant."""

import numpy as np
import pytest

from spring_shapes import FunctionCurve, cylindrical
from valvetrain.cosserat.mesh import mesh_spring
from valvetrain.cosserat.modes import natural_modes
from valvetrain.cosserat.state import free_state
from valvetrain.cosserat.static import RodStatics, TipLoads
from valvetrain.errors import InputError
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.curves import Constant, PiecewiseLinear
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.material import OTEVA_90_SC
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import OPEN_END
from valvetrain.runs.statics import rod_statics, statics_by_model
from valvetrain.springs.finite_element import FiniteElementRod
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.springs.spec import spring_model

WIRE = cylindrical("4 mm", "24 mm", "7 mm", 6)


def definition(wire=Constant(4e-3), mean=Constant(24e-3), pitch=Constant(7e-3), **other):
    usual = {
        "total_coils": 6.0,
        "material": OTEVA_90_SC,
        "lower_end": OPEN_END,
        "upper_end": OPEN_END,
    }
    return SpringDefinition(wire, mean, pitch, **{**usual, **other})


def installed(**options):
    return InstalledSpring(wire=WIRE, precompression=3e-3, options={"finite-element": options})


@pytest.mark.parametrize(("slip", "reason"), [
    (lambda: definition(wire="thin"), "'thin' is not a number with a unit; a length is needed here"),
    (lambda: definition(mean=24.0), "can only be meant as 24 mm"),
    (lambda: cylindrical("4 mm", "24 mm", "7 N", 6), "'7 N' is a force, but a length is needed"),
    (lambda: definition(material="steel"), "is not in the library"),
    (lambda: definition(mean=PiecewiseLinear((0, 3, 3.001, 6), (24e-3, 24e-3, 34e-3, 34e-3))), "coil 3.00 .* coil diameter jumps"),
    (lambda: definition(wire=FunctionCurve(lambda u: np.where(u < 2, 4e-3, 3e-3))), "at coil 2.00 .* wire diameter jumps"),
    (lambda: definition(mean=FunctionCurve(lambda u: np.where(u < 0, np.nan, 24e-3))), "at coil -0.50 .* not a finite number"),
    (lambda: definition(mean=FunctionCurve(lambda u: 24e-3 + np.where(u > 6, np.nan, 0.0))), "past both tips"),
    (lambda: InstalledSpring(wire=WIRE, precompression=3e-3, seats="clamp"), "seats .* 'clamp' is not among"),
    (lambda: FiniteElementRod(WIRE, 3e-3, seats="clamp"), "seats 'clamp' .* use planes or clamps"),
    (lambda: SpringCard(-1.0, 100.0), "rate of the card: .* above zero"),
    (lambda: SpringCard(0.0, 100.0), "rate of the card: .* above zero"),
    (lambda: spring_model("finite-element").build(installed(elements_per_coil=24.5)), "elements_per_coil .* is 24.5"),
    (lambda: spring_model("finite-element").build(installed(elements_per_coil=2)), "elements_per_coil .* is 2"),
    (lambda: mesh_spring(WIRE, 24.5), "give a whole number"),
    (lambda: MultiMassSpring.from_definition(WIRE, 3e-3, masses_per_coil=3.5), "give a whole number"),
])  # fmt: skip
def test_a_slip_about_a_spring_gets_one_sentence(slip, reason):
    with pytest.raises(InputError, match=reason):
        slip()


@pytest.mark.parametrize(
    "build",
    [
        lambda depth: InstalledSpring(wire=WIRE, precompression=depth),
        lambda depth: FiniteElementRod(WIRE, depth),
        lambda depth: MultiMassSpring.from_definition(WIRE, depth),
    ],
    ids=["installed", "finite-element", "multi-mass"],
)
def test_no_spring_is_installed_beyond_solid(build):
    room = WIRE.free_length - WIRE.solid_height
    assert WIRE.solid_compression == pytest.approx(room)
    assert build(0.9 * room)
    for depth in (room, 1.1 * room, 2 * room, -1e-3, float("nan")):
        with pytest.raises(InputError, match="compression"):
            build(depth)


def test_no_static_curve_goes_beyond_solid():
    """It gave forces of tens of kilonewtons."""
    spring, beyond = InstalledSpring(wire=WIRE, precompression=3e-3), 1.1 * WIRE.solid_compression
    with pytest.raises(InputError, match="solid"):
        rod_statics(FiniteElementRod(WIRE, 3e-3, 12), beyond, 4)
    for word in ("multi-mass", "wave-rod", "massless"):
        model = spring_model(word).build(spring)
        with pytest.raises(InputError, match="solid"):
            statics_by_model(spring, word, model, np.linspace(0.0, beyond, 5))


def test_an_open_spring_has_the_rate_of_all_its_turns():
    wire = cylindrical("4 mm", "24 mm", "7.5 mm", 6, ends="open")
    rate = MultiMassSpring.from_definition(wire, 0.0).layout.rate
    assert rate == pytest.approx(OTEVA_90_SC.shear_modulus * 4e-3**4 / (8 * 24e-3**3 * 6), rel=1e-6)


def test_modes_of_a_wire_with_a_free_tip():
    """A quarter wave: f = sqrt(k / m) / 4, half of the wire fixed at both ends."""
    wire = cylindrical("4 mm", "24 mm", "7 mm", 6, ends="open")
    mesh = mesh_spring(wire, 24)
    modes = natural_modes(RodStatics(mesh, loads=TipLoads()), free_state(mesh), 6)
    rate = natural_modes(RodStatics(mesh), free_state(mesh), 6).axial_stiffness
    axial = int(np.argmax(modes.axial_mass_share))
    assert modes.natural_frequency[axial] == pytest.approx(np.sqrt(rate / wire.mass) / 4, rel=0.01)
    assert modes.axial_mass_share[axial] == pytest.approx(8 / np.pi**2, rel=0.05)
    assert not np.any(modes.axial_transmission) and not len(modes.axial_modes())


def test_axial_mass_of_all_modes_is_the_mass_that_moves_whatever_hangs_on_the_retainer():
    """Completeness: the shares of all modes sum to 1; a retainer ten times as heavy as its wire
    takes all but a little of the first.
    """
    wire = cylindrical("4 mm", "24 mm", "7 mm", 3, ends="open")
    mesh = mesh_spring(wire, 8)
    for end_mass in (None, 0.01, 10 * wire.mass):
        every = natural_modes(RodStatics(mesh), free_state(mesh), 10_000, end_mass)
        assert np.sum(every.axial_mass_share) == pytest.approx(1.0, abs=0.02), end_mass
    assert every.axial_mass_share[np.argmin(every.natural_frequency)] > 0.9
