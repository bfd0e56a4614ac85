"""A case with all its parts built once: what studies run. Nothing after it sees the case."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from valvetrain.arrays import Array
from valvetrain.cam.contract import LiftLaw
from valvetrain.errors import InputError
from valvetrain.mechanism.parts import AssembledMechanism
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.train import TrainParameters
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.study import LiftEvent
from valvetrain.springs.contract import SpringModel, TabulatedSpring
from valvetrain.springs.nested import NestedSprings, RadialRubbing
from valvetrain.springs.spec import SpringModelSpec, spring_model
from valvetrain.system.contract import PRESCRIBED, TRAIN
from valvetrain.system.driven import DrivenSprings
from valvetrain.system.prescribed import PrescribedSpring
from valvetrain.system.train_system import TrainSystem

#: Why solids of a pair that rub do not run.
RUBBING = (
    "solid finite elements move each spring of a pair alone, and these two rub on one another; leave rubbing out, "
    "or use multi-mass or wave-rod"
)
#: What replaces a wire whose rod cannot be reduced.
CHAIN = "multi-mass"
#: Springs at rest by the installed spring they represent.
Rest = Mapping[InstalledSpring, SpringAtRest]
#: Models by word, installed spring (its options included) and, for models that need it, the spring
#: at rest.
BuiltModels = dict[tuple[str, InstalledSpring, SpringAtRest | None], SpringModel]


@dataclass(frozen=True, eq=False)
class Gear:
    """What moves the springs of a train: its mechanism, the parameters behind it (for kinematics),
    the gas force over the cam angle, and the cam angle (rad) of top dead centre of gas exchange where that is known.
    """

    mechanism: AssembledMechanism
    parameters: TrainParameters
    gas: Array | None = None
    top_dead_centre: float | None = None


@dataclass(frozen=True, eq=False)
class Member:
    """One variant of a problem: which springs by which model, in which train (none: prescribed
    motion). ``note`` is printed next to the results. ``by_default``: the model was not named;
    ``instead``: why it is a chain of masses then, where it would be the reduced rod.
    """

    label: str
    model: SpringModelSpec
    springs: tuple[InstalledSpring, ...]
    valve_lift: LiftLaw
    spring_set: str = ""
    gear: Gear | None = None
    rubbing: RadialRubbing | None = None
    name: str = ""
    note: str = ""
    by_default: bool = False
    instead: str = ""

    @property
    def kind(self) -> str:
        """Name of the system this member makes."""
        return PRESCRIBED if self.gear is None else TRAIN

    @property
    def _no_motion(self) -> str:
        """Why the model does not run in time here, empty where it does."""
        apart = self.gear is None or self.model.driver
        return self.model.no_motion or ("" if apart else self.model.alone)

    @property
    def driven(self) -> bool:
        """Whether the springs follow a train that runs with another model of them."""
        return self.gear is not None and bool(self.model.driver)

    @property
    def refusal(self) -> str:
        """Why the model cannot run here, empty when it can."""
        return self._no_motion or next(
            (reason for spring in self.springs if (reason := self.model.why_not(spring))), ""
        )

    def system(
        self, rest: Rest | None = None, built: BuiltModels | None = None
    ) -> PrescribedSpring | TrainSystem | DrivenSprings:
        """The member assembled; ``rest`` holds the springs at rest where the model needs them
        (``model.needs_rest``), ``built`` the models that exist already (new ones are added).

        Raises :class:`InputError` where the model cannot represent a spring.
        """
        if reason := self._no_motion:
            raise InputError(reason)
        models: BuiltModels = {} if built is None else built
        springs: tuple[SpringModel, ...] = tuple(
            _reaching(models, self, spring, (rest or {}).get(spring)) for spring in self.springs
        )
        if self.rubbing is not None and len(springs) == 2:
            if self.model.driver:
                raise InputError(RUBBING)
            springs = (NestedSprings(springs[0], springs[1], self.rubbing, name=self.model.word),)
        if self.gear is None:
            return PrescribedSpring(springs, self.valve_lift, self.name)
        if self.driven:
            train = replace(self, model=spring_model(self.model.driver)).system(rest, models)
            assert isinstance(train, TrainSystem)
            return DrivenSprings(train, springs, self.model.driver)
        return TrainSystem(
            self.gear.mechanism, springs, self.gear.gas, self.name, self.gear.parameters.crank
        )


@dataclass(frozen=True, eq=False)
class Problem:
    """All parts of a case, built once. ``engine_speeds`` in rad/s of the crank; ``cycles`` cam
    turns of prescribed motion, the last is reported; ``output_step`` (cam rad) between its samples;
    ``force_bandwidth`` (Hz): cut-off of the peaks of the springs' forces;
    ``cycles_to_settle`` bounds the search for a train's periodic state; ``moves``: whether there is
    a lift law; ``built``: the spring models built so far, shared by members and states at rest.

    >>> import valvetrain as vt
    >>> problem = vt.system.build.build("job-t", spring_models=["massless", "multi-mass"])
    >>> [member.label for member in problem.members]
    ['massless', 'multi-mass']
    """

    record: CaseRecord
    members: tuple[Member, ...]
    valve_lift: LiftLaw
    lift_event: LiftEvent | None
    engine_speeds: tuple[float, ...]
    cycles: int | None
    output_step: float
    force_bandwidth: float
    cycles_to_settle: int | None = None
    moves: bool = True
    built: BuiltModels = field(default_factory=dict, repr=False)

    @property
    def kind(self) -> str:
        """Name of the systems of this problem."""
        return self.members[0].kind

    @property
    def springs(self) -> tuple[InstalledSpring, ...]:
        """Every installed spring of the members, each once."""
        return tuple(dict.fromkeys(spring for member in self.members for spring in member.springs))

    def must_run(self) -> None:
        """Raise :class:`InputError` when no member can run in time, with the reason of the first."""
        if self.members and all(member.refusal for member in self.members):
            raise InputError(self.members[0].refusal, "models")

    def settled(self) -> Problem:
        """The problem as it runs: members whose default model has no tables are chains of masses,
        which say why.
        """
        found = tuple(_settled(member, self.built) for member in self.members)
        return self if found == self.members else replace(self, members=found)

    def model_of(
        self, word: str, spring: InstalledSpring, rest: SpringAtRest | None = None
    ) -> SpringModel:
        """The model of an installed spring, the one of a member where it runs. Raises
        :class:`InputError` where it cannot represent it.
        """
        return _once(self.built, spring_model(word), spring, rest)


def _settled(member: Member, built: BuiltModels) -> Member:
    if not member.by_default or member.refusal:
        return member
    for spring in member.springs:
        try:
            model = _reaching(built, member, spring, None)
            if isinstance(model, TabulatedSpring):
                model.make_tables()
        except (InputError, ArithmeticError, ValueError) as error:
            if not spring.wire or member.model.word == CHAIN:
                return member
            label = CHAIN if member.label == member.model.word else member.label
            reason = str(error).partition(";")[0]
            return replace(member, label=label, model=spring_model(CHAIN), instead=reason)
    return member


def _reaching(
    built: BuiltModels, member: Member, spring: InstalledSpring, rest: SpringAtRest | None
) -> SpringModel:
    """The model of an installed spring; one of tables over lift as far as the member lifts it."""
    model = _once(built, member.model, spring, rest)
    if not isinstance(model, TabulatedSpring):
        return model
    if member.gear is not None and member.gear.mechanism.kinematics is not None:
        lift = member.gear.mechanism.kinematics.maximum_lift
    else:
        lift = np.max(member.valve_lift.lift(np.linspace(0.0, 2 * np.pi, 721)))
    found = model.reaching(float(lift))
    built[member.model.word, spring, rest if member.model.needs_rest else None] = found
    return found


def _once(
    built: BuiltModels, spec: SpringModelSpec, spring: InstalledSpring, rest: SpringAtRest | None
) -> SpringModel:
    key = (spec.word, spring, rest if spec.needs_rest else None)
    if key not in built:
        built[key] = spec.build(spring, key[2])
    return built[key]
