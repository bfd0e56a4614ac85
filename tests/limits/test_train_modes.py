"""Modes of whole trains against two masses by hand, matrices written down, a bar with a mass on its
end, and the run itself.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from train_parts import LAW, direct
from valvetrain.mechanism.build import build_mechanism
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.parameters.schema_contact import ContactParameters
from valvetrain.parameters.templates import TEMPLATES
from valvetrain.parameters.train_parts import CamParameters, FollowerParameters, ValveParameters
from valvetrain.runs.train_runs import train_modes
from valvetrain.solution.modes import TrainModes
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.massless import MasslessSpring
from valvetrain.springs.modal_uniform import ModalUniform
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.system.train_modes import eigen_at, modes_from
from valvetrain.system.train_system import TrainSystem

CAM, TIP, SEAT, RATE = 80e6, 60e6, 90e6, 40e3
TAPPET, VALVE = 0.05, 0.09
CONTACTS = {
    place: ContactParameters("linear", {"contact_stiffness": value})
    for place, value in (("cam", CAM), ("valve_tip", TIP), ("seat", SEAT))
}
NOSE = float(np.linspace(0, math.tau, 3601)[np.argmax(LAW.lift(np.linspace(0, math.tau, 3601)))])


def modes_of(
    system: TrainSystem,
    installed: tuple[InstalledSpring, ...] = (),
    cam_angle: float = 0.0,
    state: str = "closed",
    label: str = "",
) -> TrainModes:
    return modes_from(system, eigen_at(system, installed, cam_angle), cam_angle, state, label)


def bucket(*springs: object, **changes: object) -> TrainSystem:
    parts = {
        "cam": CamParameters(0.040),
        "contacts": CONTACTS,
        "follower": FollowerParameters("flat", mass=TAPPET),
    } | changes
    return TrainSystem(build_mechanism(direct(valve=ValveParameters(VALVE), **parts), LAW), springs)


def test_a_bucket_at_full_lift_is_two_masses():
    """Tappet between cam and valve, valve between tappet and spring: the quadratic of two masses on
    three springs.
    """
    found = modes_of(bucket(MasslessSpring(RATE, 300.0)), cam_angle=NOSE, state="full_lift")
    a, b, c = (CAM + TIP) / TAPPET, (TIP + RATE) / VALVE, TIP**2 / (TAPPET * VALVE)
    roots = [((a + b) + sign * math.sqrt((a - b) ** 2 + 4 * c)) / 2 for sign in (-1, 1)]
    assert found.natural_frequency == pytest.approx(np.sqrt(roots) / math.tau, rel=1e-6)
    # Lower mode: both move the same way, the valve further, by (k_tip) / (k_tip + k_spring - m
    # w^2).
    ratio = TIP / (TIP + RATE - VALVE * roots[0])
    shape = found.shape[0] / found.shape[0][list(found.bodies).index("tappet")]
    assert shape[list(found.bodies).index("valve")] == pytest.approx(ratio, rel=1e-6)
    kinetic = np.array([TAPPET, VALVE * ratio**2])
    shares = dict(zip(found.parts, found.energy_share[0], strict=True))
    assert [shares["tappet"], shares["valve"]] == pytest.approx(kinetic / kinetic.sum(), rel=1e-6)
    assert found.open == ("seat",) and set(found.closed) == {"cam", "valve tip"}


def test_a_closed_valve_with_lash_swings_on_seat_and_spring_and_leaves_the_tappet_free():
    found = modes_of(bucket(MasslessSpring(RATE, 300.0), lash=0.2e-3, gravity=(0.0, 0.0)))
    assert (found.state, found.cam_angle, found.valve_lift) == (
        "closed",
        0.0,
        pytest.approx(0.0, abs=1e-5),
    )  # unless told otherwise
    assert found.natural_frequency[0] == 0.0
    assert found.natural_frequency[-1] == pytest.approx(
        math.sqrt((SEAT + RATE) / VALVE) / math.tau, rel=1e-6
    )
    assert "seat" in found.closed and "valve tip" in found.open


def test_an_elastic_stem_with_a_chain_of_masses_is_the_matrix_written_down():
    """Tappet, head, tip and the four inner masses of a chain of five elements, by NumPy's own
    solver of the pencil.
    """
    stem, spring_mass = 70e6, 0.06
    chain = MultiMassSpring.from_card(RATE, 300.0, spring_mass, elements=5)
    system = TrainSystem(
        build_mechanism(
            direct(
                valve=ValveParameters(VALVE, stem_stiffness=stem, head_fraction=0.6),
                cam=CamParameters(0.040),
                contacts=CONTACTS,
                follower=FollowerParameters("flat", mass=TAPPET),
            ),
            LAW,
        ),
        (chain,),
    )
    found = modes_of(system, cam_angle=NOSE, state="full_lift")
    each, link = spring_mass / 5, 5 * RATE
    masses = np.diag([TAPPET, 0.6 * VALVE, 0.4 * VALVE + each / 2, each, each, each, each])
    stiffness = np.zeros((7, 7))
    pairs = [(0, 2, TIP), (1, 2, stem), (2, 6, link), (6, 5, link), (5, 4, link), (4, 3, link)]
    for one, other, value in pairs:
        stiffness[np.ix_([one, other], [one, other])] += value * np.array([[1, -1], [-1, 1]])
    stiffness[0, 0] += CAM
    stiffness[3, 3] += link
    values = np.sort(np.linalg.eigvals(np.linalg.solve(masses, stiffness)).real)
    assert found.natural_frequency == pytest.approx(np.sqrt(values) / math.tau, rel=1e-5)


def test_a_mass_on_the_end_of_a_uniform_spring_follows_the_transcendental_equation():
    """M w^2 = k b cot(b) + c with b = w sqrt(m / k): a bar fixed at the seat, mass and contact at
    its other end.
    """
    spring_mass, contact = 0.06, 2e6
    model = ModalUniform(EquivalentSpring(RATE, 300.0, spring_mass), modes=60)
    soft = {**CONTACTS, "cam": ContactParameters("linear", {"contact_stiffness": contact})}
    rigid = {**soft, "valve_tip": ContactParameters("linear", {"contact_stiffness": 1e11})}
    found = modes_of(bucket(model, contacts=rigid), cam_angle=NOSE, state="full_lift")
    mass = TAPPET + VALVE

    def residual(omega: float) -> float:
        b = omega * math.sqrt(spring_mass / RATE)
        return (RATE * b * math.cos(b) + (contact - mass * omega**2) * math.sin(b)) / 1e6

    grid = np.linspace(50.0, 8000.0, 4000)
    signs = np.sign([residual(one) for one in grid])
    roots = [brentq(residual, grid[k], grid[k + 1]) for k in np.flatnonzero(np.diff(signs))]
    assert found.natural_frequency[:4] == pytest.approx(np.array(roots[:4]) / math.tau, rel=2e-3)


@pytest.mark.parametrize("word", ["multi-mass", "modal-uniform", "wave-rod"])
def test_every_spring_model_gives_the_first_modes_of_the_template(word):
    """The spring's surge by its card, 0.5 sqrt(k / m), and above it the train on its contacts."""
    closed, lifted = train_modes(load_case(str(TEMPLATES / "pushrod.toml")), [word])
    surge = SpringCard(220 * 4.4482216 / (0.55 * 0.0254), 578.0, 0.096).surge_frequency
    assert closed.natural_frequency[0] == pytest.approx(surge, rel=0.03)
    assert lifted.natural_frequency[0] == pytest.approx(surge, rel=0.03)
    assert closed.moving(0).startswith("spring") and lifted.state == "full_lift"


@pytest.mark.parametrize(
    ("kind", "nose"),
    [
        ("direct", 90.0),
        ("direct", 180.0),
        ("direct", 275.0),
        ("direct", 395.0),
        ("finger", 260.0),
        ("rocker", 300.0),
    ],
)
def test_both_states_stand_at_nose_and_base_circle_wherever_on_the_turn_the_lobe_lies(
    kind: str, nose: float
) -> None:
    """The lobe of the template, 80 cam degrees to either side of its nose, turned: full lift there,
    no lift with the valve closed.
    """
    text = (TEMPLATES / f"{kind}.toml").read_text(encoding="utf-8")
    edges = {
        "opening_start": nose - 80,
        "opening_end": nose,
        "closing_start": nose,
        "closing_end": nose + 80,
    }
    case = parse_case(
        text, kind, changes={f"lift_law.{key}": f"{angle} deg" for key, angle in edges.items()}
    )
    closed, lifted = train_modes(case, ["massless"])
    assert (closed.state, lifted.state) == ("closed", "full_lift")
    assert math.degrees(lifted.cam_angle) == pytest.approx(nose % 360, abs=0.25)
    assert (math.degrees(closed.cam_angle) - nose + 80) % 360 >= 160 - 0.25
    full = {"direct": 8e-3, "finger": 9e-3, "rocker": 9e-3}[kind]
    assert lifted.valve_lift == pytest.approx(
        full, rel=0.04
    ) and closed.valve_lift == pytest.approx(0.0, abs=0.01e-3)
    assert "seat" in closed.closed and "seat" in lifted.open


def test_a_spring_without_a_mass_only_presses():
    card = InstalledSpring(card=SpringCard(RATE, 300.0))
    with_card = modes_of(bucket(MasslessSpring(RATE, 300.0)), (card,), NOSE)
    assert len(with_card.natural_frequency) == 2 and with_card.energy_share[:, -1] == pytest.approx(
        0.0
    )


@pytest.mark.parametrize(
    ("label", "shown"), [("", "stock"), ("multi-mass, inner", "multi-mass, inner")]
)
def test_modes_are_named_by_their_label_and_else_by_their_train(label, shown):
    built = bucket(MasslessSpring(RATE, 300.0))
    named = TrainSystem(built.mechanism, built.springs, name="stock")
    assert modes_of(named, cam_angle=NOSE, label=label).label == shown
