"""What a run prints by default against the finest division of the same spring model: every headline
number of templates and library cases at three engine speeds up to float, and of a card against the
exact damped wave equation.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from importlib import resources
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from valvetrain.integrate.contract import STEP_FRACTION
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.loading import load_case, parse_case
from valvetrain.quantities.train_events import marginal_duration
from valvetrain.runs.error_bars import divided
from valvetrain.runs.own_error_bars import NAMES, SAME_SCATTER
from valvetrain.runs.prepared import Plan, integrate_from, prepare, provenance_of, with_quantities
from valvetrain.runs.requests import Run
from valvetrain.runs.run import run_problem
from valvetrain.solution.result import Solution
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.modal_uniform import oscillating_modes
from valvetrain.springs.spec import spring_model
from valvetrain.system.build import build
from valvetrain.system.contract import TRAIN
from valvetrain.system.problem import Member, Problem

RPM = math.pi / 30
#: Raw forces of one impact of coils, which no division resolves and whose contact no source states: only their bars describe them.
IMPACT_FORCES = ("peak_clash_force", "surge_clash_peak_force")
#: Models of a wire, that of a card being made up; models that are compared: chain, surge modes, rod of the
#: wave equation and, of a wire, reduced rod and rod.
OF_WIRES = ("reduced-rod", "finite-element")
MODELS = ("multi-mass", "modal-uniform", "wave-rod", *OF_WIRES)
#: Division of the finest run over that of the case (a chain of a card has at least CHAIN elements) and elements per coil
#: of the rod, which is the finest of a reduced rod too; its step over the default one, as far as that is stable.
FINER = {"multi-mass": 3.0, "modal-uniform": 2.0, "wave-rod": 1.0}
ROD, PER_COIL, STEP, CHAIN = "finite-element", 48, 0.25, 120
#: Share of a number, and of the preload for a force, up to which the default is converged; so are
#: lengths (m) and cam angles (rad) that differ by less than these.
SHARE, PRELOAD_SHARE, LENGTH, ANGLE = 0.01, 0.005, 0.5e-6, math.radians(0.5)

#: Share of a value that an error has at least where bars are compared with it.
FLOOR = 1e-3
#: Kinds of numbers by parts of their names, the first that fits.
KINDS = (
    ("blows of coils", ("clash",)), ("raw peaks", ("raw_",)), ("peak force of springs", ("peak_spring", "peak_retainer")),
    ("least force of springs", ("minimum_spring", "minimum_retainer")), ("surge", ("surge",)), ("stress", ("stress",)),
    ("blows at the seat", ("peak_seat", "peak_valve_acceleration")), ("forces of the train", ("contact_force",)),
    ("gaps, bounces, loss of contact", ("loft", "bounce", "loss_of", "lift_loss")), ("angles", ("angle",)),
)  # fmt: skip


def kind_of(name: str) -> str:
    """Kind of a quantity in the table of bars.

    >>> kind_of("largest_clash_impulse"), kind_of("seating_velocity")
    ('blows of coils', 'other')
    """
    return next((kind for kind, parts in KINDS if any(one in name for one in parts)), "other")


#: The same by the last part of a quantity.
NEAR = {
    "_gap": LENGTH,
    "_height": LENGTH,
    "_displacement": LENGTH,
    "_lift": LENGTH,
    "_angle": ANGLE,
}


class Subject(NamedTuple):
    """A template or library case with one of its spring sets, at engine speeds (rpm), the last one
    just below float. ``text``: the case, where it is neither.
    """

    name: str
    spring_set: str
    engine_speeds: tuple[float, ...]
    text: str = ""

    @property
    def label(self) -> str:
        """Name and spring set."""
        return f"{self.name} {self.spring_set}".strip()

    def case(self) -> Case:
        """The case, of its text, a template or the library."""
        file = resources.files("valvetrain").joinpath(f"templates/{self.name}.toml")
        text = self.text or (file.read_text("utf-8") if file.is_file() else "")
        return parse_case(text, self.name) if text else load_case(self.name)


#: Float by surge modes: direct 8055 and 7570 rpm, finger 8135 and 7445, rocker 8144 and 7594, pushrod 7302 and 6030, tdi-pushrod
#: 7090 and 7944, vaz-ohc 5073 and 5335.
SUBJECTS = (
    Subject("spring", "", (3000, 5000, 7000)),
    Subject("direct", "stock", (3000, 5500, 7900)),
    Subject("direct", "stiff", (3000, 5500, 7400)),
    Subject("finger", "stock", (3000, 5500, 8000)),
    Subject("finger", "stiff", (3000, 5500, 7400)),
    Subject("rocker", "stock", (3000, 5500, 8000)),
    Subject("rocker", "stiff", (3000, 5500, 7500)),
    Subject("pushrod", "card", (3000, 6000, 7200)),
    Subject("pushrod", "wire", (3000, 4500, 5900)),
    Subject("tdi-pushrod", "stock", (3000, 5000, 7000)),
    Subject("tdi-pushrod", "performance", (3000, 5500, 7900)),
    Subject("vaz-ohc", "nested", (2000, 3500, 5000)),
    Subject("vaz-ohc", "nested-cards", (2000, 3500, 5300)),
    Subject("gu2021-beehive-blind", "", (4200, 5600, 8000)),
    Subject("job-t", "", (3000, 5000, 8000)),
    Subject("job-c", "", (3000, 5000, 8000)),
)


@dataclass(frozen=True, slots=True)
class Compared:
    """One number (SI): the ``default`` with its printed ``bar`` (scatter of both runs included), the
    ``finest``, and ``near``, what counts as nothing. ``marginal``: of a time without contact, the gaps of the
    finest that are so small that they are there or not. ``printed``: the bar alone.
    """

    subject: Subject
    model: str
    engine_speed: float
    quantity: str
    default: float
    bar: float
    finest: float
    near: float
    repeats: bool = True
    marginal: float = 0.0
    printed: float = 0.0

    @property
    def ratio(self) -> float:
        """The printed bar over the error, of which :data:`FLOOR` of the value counts as the least."""
        return self.printed / max(self.error, FLOOR * abs(self.finest), 1e-300)

    @property
    def converged(self) -> float:
        """Error up to which the default counts as converged."""
        return max(SHARE * abs(self.finest), self.near)

    @property
    def allowed(self) -> float:
        """Largest error that is allowed."""
        return max(self.converged, self.bar)

    @property
    def error(self) -> float:
        """Size of the difference to the finest value."""
        return abs(self.default - self.finest)

    @property
    def verdict(self) -> str:
        """``converged``, ``inside its bar`` or ``missed``."""
        if self.error <= self.converged:
            return "converged"
        return "inside its bar" if self.error <= self.bar else "missed"


def compare(subject: Subject, models: Sequence[str] = MODELS) -> Iterator[Compared]:
    """Every headline number of a subject by each of ``models`` that its springs allow."""
    case, sets = subject.case(), (subject.spring_set,) if subject.spring_set else ()
    springs = case.springs if case.train is None else case.train.spring_parts(*sets)
    for model in models:
        if model in OF_WIRES and any(spring.wire is None for spring in springs):
            continue
        problem = build(case, spring_models=(model,), spring_set=sets)
        # rods at the last speed alone, since their finest take a minute each
        chosen = subject.engine_speeds[-1:] if model in OF_WIRES else subject.engine_speeds
        speeds = [rpm * RPM for rpm in chosen]
        study = run_problem(problem, speeds, Run(case=case, workers=1, compute=("error_bars",)))
        bars = {
            (round(row.engine_speed / RPM), row.quantity): row.numerical
            for row in study.error_bars.rows
            if row.engine_speed is not None
        }
        for default in study.solutions:
            rpm = round(default.engine_speed / RPM)
            own = {name: bar for (speed, name), bar in bars.items() if speed == rpm}
            finest = _finest(problem, problem.members[0], default)
            preload = default.quantities.get(
                "preload", study.still.get(default.label, {}).get("preload", math.nan)
            )
            yield from _numbers(subject, model, default, finest, own, preload)


def _finest(problem: Problem, member: Member, default: Solution) -> Solution:
    """The run of ``default`` again, its springs divided more finely and its step shortened; of a reduced rod its rod."""
    word = ROD if member.model.word in OF_WIRES else member.model.word
    springs = tuple(_divided(member, spring) for spring in member.springs)
    finer = replace(member, model=spring_model(word), springs=springs)
    ready = prepare(problem, finer, {}, problem.record.study)
    step, own = None, default.statistics.get("time_step_duration")
    if isinstance(own, (int, float)) and ready.system is not None:
        # the grid of the wave equation follows the step: it needs none
        limits = [
            STEP_FRACTION * float(spring.stable_time_step())
            for spring in ready.system.springs
            if hasattr(spring, "stable_time_step") and word != "wave-rod"
        ]
        step = min(STEP * float(own), *limits, math.inf)
    plan = Plan(cycles=problem.cycles, cycles_to_settle=problem.cycles_to_settle)
    if problem.kind != TRAIN:
        plan = replace(plan, samples=round(2 * math.pi / problem.output_step))
    provenance = provenance_of(problem, ready.member, default.engine_speed, "")
    found, _ = integrate_from(ready, default.engine_speed, plan, provenance, time_step=step)
    return with_quantities(ready, found, plan, {})


def _divided(member: Member, spring: InstalledSpring) -> InstalledSpring:
    word = member.model.word
    if word in OF_WIRES:
        return spring.with_options(ROD, elements_per_coil=PER_COIL)
    if word == "multi-mass" and spring.wire is None:
        own = member.model.read_options(spring.options_of(word)).model_dump()["elements"]
        return spring.with_options(word, elements=max(CHAIN, round(FINER[word] * own)))
    found = divided(member, spring, FINER[word])
    if word == "modal-uniform":  # no more than still oscillate
        count = found.options_of(word)["modes"]
        return found.with_options(word, modes=oscillating_modes(found, int(count)))
    return found


def _numbers(
    subject: Subject,
    model: str,
    default: Solution,
    finest: Solution,
    bars: dict[str, float],
    preload: float,
) -> Iterator[Compared]:
    runs = default, finest
    repeats = not any(name.startswith("cycle_scatter_") for run in runs for name in run.quantities)
    for name in NAMES:
        value, best = (run.quantities.get(name, math.nan) for run in runs)
        if not (math.isfinite(value) and math.isfinite(best)):
            continue
        own, other = (
            run.quantities.get(f"cycle_scatter_{SAME_SCATTER.get(name, name)}", 0.0) for run in runs
        )
        if name.endswith("_force"):
            near = PRELOAD_SHARE * preload
        else:
            near = next((one for end, one in NEAR.items() if name.endswith(end)), 0.0)
        bar = max(bars.get(name, 0.0), own) + other
        marginal = marginal_duration(finest.events) if name == "loss_of_contact_duration" else 0.0
        yield Compared(
            subject, model, default.engine_speed, name, value, bar, best, near, repeats, marginal, bars.get(name, 0.0),
        )  # fmt: skip


#: A card whose damping is of mass alone, and with a share of stiffness, under a lift with three continuous derivatives.
CARD = """
[spring]
preload = "420 N"
rate = "45 N/mm"
mass = "90 g"
[spring.damping]
ratio = 0.02
ratio_frequency = "350 Hz"
stiffness_share = {share}
[lift_law]
kind = "polynomial"
lift_of = "valve"
exponents = "4-5-6-7"
maximum_lift = "7 mm"
opening_start = "115 deg"
opening_end = "180 deg"
closing_start = "180 deg"
closing_end = "245 deg"
"""
CARD_SPEEDS = (4000, 5600, 6600)


def exact_seat_force(
    card: InstalledSpring, lifts: NDArray[np.float64], engine_speed: float
) -> NDArray[np.float64]:
    """Force (N) of a card on its fixed end over one cam revolution under ``lifts`` (m, evenly spaced in
    angle), at ``engine_speed`` (rad/s of the crank): the damped wave equation by harmonics.

    ``U'' + kappa^2 U = 0``, ``kappa^2 = (w^2 - i w a) / (k / m (1 + i w b))``; the force is
    ``k (1 + i w b) U'(0)``.
    """
    spring = EquivalentSpring.from_installed(card)
    circular = np.arange(len(lifts) // 2 + 1) * engine_speed / 2
    stiff = 1 + 1j * circular * card.damping.stiffness_damping
    square = (circular**2 - 1j * circular * card.damping.mass_damping) / (
        spring.wave_speed**2 * stiff
    )
    kappa = np.sqrt(square)
    kappa[0] = 1.0  # at rest the ratio is one, which the next line puts in
    transfer = spring.rate * np.where(circular > 0, stiff * kappa / np.sin(kappa), 1.0)
    return np.asarray(spring.preload + np.fft.irfft(np.fft.rfft(lifts) * transfer, len(lifts)))


def compare_exact() -> Iterator[Compared]:
    """Least and largest seat force of a card by the models that solve its equation: the wave rod where
    mass alone damps, chain and modes with a share of stiffness too.
    """
    for share, models in ((0.0, MODELS[:3]), (0.5, MODELS[:2])):
        what = "with stiffness" if share else "by mass"
        subject = Subject(
            f"wave equation, damped {what}", "", CARD_SPEEDS, CARD.format(share=share)
        )
        case = subject.case()
        for model in models:
            problem = build(case, spring_models=(model,))
            lifts = problem.valve_lift.lift(np.arange(2**13) * 2 * np.pi / 2**13)
            speeds = [rpm * RPM for rpm in CARD_SPEEDS]
            study = run_problem(problem, speeds, Run(case=case, workers=1, compute=("error_bars",)))
            bars = {
                (row.engine_speed, row.quantity): row.numerical for row in study.error_bars.rows
            }
            for run in study.solutions:
                exact = exact_seat_force(case.springs[0], lifts, run.engine_speed)
                for name, best in (
                    ("minimum_spring_force", exact.min()),
                    ("peak_spring_force", exact.max()),
                ):
                    near = PRELOAD_SHARE * EquivalentSpring.from_installed(case.springs[0]).preload
                    bar = bars.get((run.engine_speed, name), 0.0)
                    value = run.quantities[name]
                    yield Compared(
                        subject, model, run.engine_speed, name, value, bar, float(best), near
                    )
