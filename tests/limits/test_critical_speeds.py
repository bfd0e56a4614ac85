"""Critical speeds against closed forms: rigid loss of contact, and the two jumps of an oscillator
that its contact softens.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

import valvetrain as vt
from train_parts import direct
from valvetrain.cam.closed_form import SinePower
from valvetrain.integrate.contract import Orbit
from valvetrain.integrate.train_record import TrainOptions
from valvetrain.integrate.train_run import runner
from valvetrain.integrate.train_steady import steady_train, train_multipliers
from valvetrain.mechanism.build import build_mechanism
from valvetrain.parameters.loading import load_case
from valvetrain.runs.critical_scan import Scan, SpeedSample
from valvetrain.runs.critical_speeds import CriticalOptions, critical_speed, sample_of
from valvetrain.runs.prepared import (
    Plan,
    integrate_from,
    prepare,
    provenance_of,
    with_quantities,
)
from valvetrain.runs.train_runs import member_statics
from valvetrain.springs.contract import SpringModel
from valvetrain.springs.massless import MasslessSpring
from valvetrain.springs.multi_mass import MultiMassSpring
from valvetrain.system.build import build
from valvetrain.system.train_system import TrainSystem

RPM = math.pi / 30
PRELOAD, RATE = 300.0, 30e3
TEMPLATE = str(files("valvetrain") / "templates" / "direct.toml")


LAW = """[lift_law]
kind = "sine-power"
lift_of = "valve"
maximum_lift = "5 mm"
opening_start = "90 deg"
closing_end = "270 deg"
"""


def single_mass_case(folder: Path) -> vt.Case:
    """The template of a bucket tappet as one mass on a massless spring known by its card, under a
    smooth lift without lash.
    """
    text = re.sub(
        r"\[lift_law\].*?(?=# Speeds)",
        LAW,
        Path(TEMPLATE).read_text(encoding="utf-8"),
        flags=re.DOTALL,
    )
    (folder / "own.toml").write_text(text, encoding="utf-8")
    return load_case(
        str(folder / "own.toml"),
        {
            "train.model": "single-mass",
            "train.spring_set": "stiff",
            "train.spring_model": "massless",
            "train.valve.damping": "0 N s/m",
            "train.lash": "0 mm",
            "train.contacts.cam.contact_stiffness": "100 kN/mm",
            "train.contacts.cam.damping": "1000 N s/m",
        },
    )


def least_force(cam_speed: float, mass: float, weight: float, contact_stiffness: float) -> float:
    """Least contact force (N) over the nose: Newton's for a rigid contact, F = preload + rate y -
    weight + m y'', less what the contact
    gives way, to first order in its compliance: (m F'' + rate F) / contact stiffness. y is the
    power of a half sine, written out."""
    angle = np.linspace(math.radians(120), math.radians(240), 24_001)
    sine, cosine = np.sin(angle - math.pi / 2), np.cos(angle - math.pi / 2)
    bend = 5e-3 * (12 * sine**2 * cosine**2 - 4 * sine**4)
    force = 320.0 + 42e3 * 5e-3 * sine**4 - weight + mass * cam_speed**2 * bend
    second = np.gradient(np.gradient(force, angle), angle) * cam_speed**2
    return float(np.min((force - (mass * second + 42e3 * force) / contact_stiffness)[10:-10]))


def test_a_nearly_rigid_train_loses_contact_at_the_speed_of_newton(tmp_path: Path) -> None:
    """Against the closed form, 1 % of which is the compliance of the contact."""
    case = single_mass_case(tmp_path)
    train = build(case, spring_set=("stiff",)).members[0].system()
    mass, weight = float(np.sum(train.masses)), train.mechanism.coordinates[0].force
    assert mass == pytest.approx(0.045 + 0.095 + 0.048 / 3)
    low, high = 300.0, 600.0
    for _ in range(60):
        low, high = (
            (middle, high)
            if least_force(middle := (low + high) / 2, mass, weight, 1e8) > 0
            else (low, middle)
        )
    exact = 2 * high
    one = vt.critical_speeds(
        case, [0.9 * exact, exact * 0.97, 1.1 * exact], spring_sets=["stiff"], workers=1
    ).of("contact-loss")
    assert one is not None and one.places == ("cam",) and one.both_motions is None
    assert one.engine_speed == pytest.approx(exact, abs=2 * RPM)


#: Mass on a contact that cannot pull, pressed by a spring, its foot moved as h/2 (1 - cos): the
#: oscillator of the second oracle.
MASS, CONTACT, DAMPING, LIFT = 0.1, 1e6, 18.0, 1e-4
KIND = "contact-loss"


def oscillator(
    contact_damping: float = DAMPING,
    mass_damping: float = 0.0,
    spring: SpringModel = MasslessSpring(RATE, PRELOAD, 0.0),
) -> TrainSystem:
    """The mass alone, without a seat: its whole motion is one harmonic of the cam while it keeps
    contact.
    """
    law = SinePower(maximum_lift=LIFT, opening_start=0.0, closing_end=2 * math.pi, power=2)
    mechanism = build_mechanism(
        direct(model="single-mass", lash=0.0, gravity=(0.0, 0.0)), law, "valve"
    )
    cam = mechanism.interactions[mechanism.interaction_index("cam")]
    contact = vt.contact.build_contact_law(
        "linear", contact_stiffness=CONTACT, damping=contact_damping
    )
    body = replace(
        mechanism.coordinates[0], mass=MASS, force=0.0, damping=mass_damping * MASS, friction=0.0
    )
    mechanism = replace(mechanism, coordinates=(body,), interactions=(replace(cam, law=contact),))
    return TrainSystem(mechanism, (spring,), name="oscillator")


def run_at(cam_speed: float, orbit: Orbit | None, precise: bool) -> SpeedSample:
    """The periodic motion at ``cam_speed`` (rad/s), from rest or from a motion, and the least
    contact force over all its steps.
    """
    ready = runner(OSCILLATOR, cam_speed, TrainOptions(360))
    settled = steady_train(ready, cycles=200, start=orbit)
    least = float(settled.record.least_forces[0])
    measure, repeats = least if least > 0 else -1.0, settled.status.completed
    return SpeedSample({KIND: measure}, {KIND: ("cam",)}, settled.orbit, repeats)


OSCILLATOR = oscillator()


def test_a_mass_on_its_contact_has_the_multipliers_of_a_linear_mode() -> None:
    """exp((-damping ± i frequency) T)."""
    ready = runner(OSCILLATOR, 300.0, TrainOptions(360))
    settled = steady_train(ready, cycles=200)
    assert settled.record.least_forces[0] > 0
    decay = DAMPING / (2 * MASS)
    frequency = math.sqrt((CONTACT + RATE) / MASS - decay**2)
    exact = np.exp((-decay + 1j * frequency) * 2 * math.pi / 300.0)
    found = train_multipliers(settled)
    assert abs(found[0]) == pytest.approx(abs(exact), rel=2e-3)


@pytest.mark.parametrize(("cam_speed", "leaves"), [(1000.0, False), (3300.0, True)])
def test_damping_proportional_to_mass_gives_the_product_of_all_multipliers(
    cam_speed: float, leaves: bool
) -> None:
    """Each of the masses shrinks areas by exp(-alpha t) whatever forces act, so also where the contact opens. A tenth of
    the spring's mass, half an element, moves with the body.
    """
    alpha, moving = 300.0, 0.04
    spring = MultiMassSpring.from_card(RATE, PRELOAD, moving, elements=5, mass_damping=alpha)
    train = oscillator(0.0, alpha * (1 + 0.1 * moving / MASS), spring)
    ready = runner(train, cam_speed, TrainOptions(360))
    settled = steady_train(ready, tolerance=1e-8, cycles=400)
    assert settled.search.converged and bool(settled.record.least_forces[0] > 0) is not leaves
    found = train_multipliers(settled)
    exact = -alpha * len(found) / 2 * 2 * math.pi / cam_speed
    assert np.log(np.prod(found).real) == pytest.approx(exact, rel=1e-4)


def linear_loss() -> float:
    """Lowest cam speed (rad/s) at which the linear forced oscillation takes the whole contact
    force: bisection of its closed form.

    With r = foot - mass: m r'' + c r' + (k + kc) r = m y'' + k y + F0, contact force kc r + c r'.
    """

    def least(w: float) -> float:
        mean = CONTACT * (PRELOAD + RATE * LIFT / 2) / (CONTACT + RATE)
        forced = (
            LIFT
            / 2
            * (MASS * w**2 - RATE)
            / abs(complex(RATE + CONTACT - MASS * w**2, DAMPING * w))
        )
        return mean - forced * abs(complex(CONTACT, DAMPING * w))

    low, high = 1000.0, math.sqrt((CONTACT + RATE) / MASS)
    for _ in range(60):
        low, high = (middle, high) if least(middle := (low + high) / 2) > 0 else (low, middle)
    return high


def open_share(
    cam_speed: float, state: tuple[float, float], turns: int = 80, steps: int = 160
) -> tuple[bool, tuple[float, float]]:
    """Whether the mass leaves its foot in the last of ``turns``, by the classical Runge-Kutta
    method on the equation itself.
    """

    def rates(angle: float, x: float, v: float) -> tuple[float, float, float]:
        y, u = LIFT / 2 * (1 - math.cos(angle)), LIFT / 2 * cam_speed * math.sin(angle)
        force = max(0.0, CONTACT * (y - x) + DAMPING * (u - v)) if y > x else 0.0
        return v, (force - PRELOAD - RATE * x) / MASS, force

    (x, v), h = state, 2 * math.pi / cam_speed / steps
    opened = False
    for step in range(turns * steps):
        angle = step * 2 * math.pi / steps
        half, full = angle + math.pi / steps, angle + 2 * math.pi / steps
        x1, v1, force = rates(angle, x, v)
        x2, v2, _ = rates(half, x + h / 2 * x1, v + h / 2 * v1)
        x3, v3, _ = rates(half, x + h / 2 * x2, v + h / 2 * v2)
        x4, v4, _ = rates(full, x + h * x3, v + h * v3)
        x, v = x + h / 6 * (x1 + 2 * x2 + 2 * x3 + x4), v + h / 6 * (v1 + 2 * v2 + 2 * v3 + v4)
        opened = opened or (step >= (turns - 1) * steps and force <= 0)
    return opened, (x, v)


def test_a_contact_that_opens_softens_so_that_rising_and_falling_speed_differ() -> None:
    """Rising, contact is lost where the linear oscillation says; falling, it comes back only below,
    where an integration of the equation
    that shares nothing with the package says so too."""
    jump, step = linear_loss(), 10.0
    scan = Scan(run_at, step)
    for speed in np.linspace(0.6 * jump, 1.02 * jump, 9):
        scan.at(float(speed))
    scan.fill(0.01 * jump)
    row = critical_speed(KIND, scan, "own", CriticalOptions(step / 2.5))
    assert row.engine_speed == pytest.approx(jump, rel=1e-3) and row.both_motions is not None
    falling = row.both_motions[0]
    assert falling < row.engine_speed - 100
    cam_speed, state, lost = 1.02 * jump, (LIFT, 0.0), True
    while lost and cam_speed > 0.6 * jump:
        lost, state = open_share(cam_speed, state)
        cam_speed -= step
    assert not lost
    assert falling == pytest.approx(cam_speed + step, abs=2 * step)


def test_the_verdict_on_the_performance_spring_does_not_follow_the_grid() -> None:
    """A resonance of its surge loses contact at 7810 rpm and regains it at 8095: grids of 200 and
    100 rpm say so alike.
    """
    found = []
    for step in (300, 100):
        one = vt.critical_speeds(
            "tdi-pushrod",
            f"7500:8400:{step} rpm",
            spring_sets=["performance"],
            resolution="40 rpm",
            ranges=False,
            workers=1,
        )
        ranges = [row.ranges[0] for row in one if row.found]
        found.append([(each.lower_engine_speed, each.upper_engine_speed) for each in ranges])
    assert np.array(found[0]) == pytest.approx(np.array(found[1]), rel=1e-5)
    assert len(found[0]) == 2


def test_margins_of_a_run_do_not_hang_on_whether_its_coils_are_watched() -> None:
    """The search leaves out what the coils do: margins, motion and cycles are the same bit by bit."""
    problem = build(vt.load_case("vaz-ohc"), spring_models=("multi-mass",))
    member = problem.members[0]
    one = prepare(problem, member, member_statics(problem, member), "")
    found = []
    for watched in (True, False):
        plan = Plan("ends", None, False, coil_contacts=watched)
        origin = provenance_of(problem, one.member, 4200 * RPM, "")
        solution, orbit = integrate_from(one, 4200 * RPM, plan, origin)
        clashes = sum(event.kind == "clash" for event in solution.events)
        found.append(
            (sample_of(with_quantities(one, solution, plan, {}), CriticalOptions()), clashes)
        )
        assert orbit is not None
    (first, clashes), (second, none) = found
    assert first.measures == second.measures and first.cam_force == second.cam_force
    assert clashes > none == 0


@pytest.mark.long
def test_critical_speeds_do_not_depend_on_workers_or_on_what_is_kept() -> None:
    def ask(workers: int, whole: bool) -> vt.Study:
        sets = ["stock", "performance"]
        return vt.sweep(
            "tdi-pushrod",
            "6900:7500:200 rpm",
            models=["massless"],
            spring_sets=sets,
            workers=workers,
            whole=whole,
        )

    one, other = ask(1, False), ask(2, True)
    assert one.critical_speeds == other.critical_speeds and len(one.critical_speeds) == 6
    row = one.critical_speeds.of("contact-loss", one.labels[0])
    assert row is not None and one.still[row.label]["contact_loss_engine_speed"] == row.engine_speed
