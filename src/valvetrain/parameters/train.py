"""A whole valvetrain, the [train] table of a case file: frozen, SI, no model inside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import Field, StrictBool, StrictInt, model_validator

from valvetrain.errors import FrozenMapping, InputError
from valvetrain.parameters.installed_spring import InstalledSpring, Rubbing
from valvetrain.parameters.schema_contact import ContactParameters, ContactsField
from valvetrain.parameters.schema_types import (
    Lash,
    Name,
    Prose,
    Table,
    guarded,
    problem,
    quantities,
    table,
)
from valvetrain.parameters.spring_blocks import SpringSets
from valvetrain.parameters.steel_contacts import with_steel
from valvetrain.parameters.train_names import answer, choice_of
from valvetrain.parameters.train_parts import (
    CamParameters,
    CrankParameters,
    Damping,
    FollowerParameters,
    GasLoad,
    LeverParameters,
    PushrodParameters,
    SupportParameters,
    ValveParameters,
)
from valvetrain.registry import names as registered_names

Gravity = Annotated[tuple[float, ...], quantities("acceleration")]


@table("the variant")
class TrainVariant(Table):
    """One of the runs that a case requests, [[train.variants]]: what differs from the train itself."""

    label: Name
    spring_set: Name = Field(default="", description="without it the train's own")
    spring_model: str = Field(default="", description="without it the train's own")
    lash: Lash | None = Field(default=None, description="without it the train's own")
    valve_damping: Damping | None = Field(default=None, description="added to the valve's own")
    without_preload: StrictBool = Field(
        default=False, description="springs at rest with the valve closed"
    )
    replica: Name | None = Field(
        default=None,
        description="name of what a source does and physics does not; the run is made where the name is given as a spring set",
    )
    note: Prose = Field(default="", description="printed next to the results")

    def apply(self, train: TrainParameters) -> TrainParameters:
        """The train with this variant's changes."""
        changes: dict[str, Any] = {}
        if self.spring_set:
            changes["spring_set"] = self.spring_set
        if self.spring_model:
            changes["spring_model"] = self.spring_model
        if self.lash is not None:
            changes["lash"] = self.lash
        if self.valve_damping is not None:
            changes["valve"] = replace(
                train.valve, damping=train.valve.damping + self.valve_damping
            )
        changed = train.replace(**changes)
        if self.without_preload:
            chosen = changed.spring_set or next(iter(changed.springs))
            bare = tuple(spring.without_preload() for spring in changed.spring_parts())
            changed = changed.replace(springs={**changed.springs, chosen: bare})
        return changed


@table("the train")
class TrainParameters(Table):
    """One valvetrain. ``kind``: a name in the registry.

    ``contacts``: law per place: ``cam``, ``valve_tip``, ``seat``, and for pushrods ``tappet`` and
    ``rocker``. ``springs``: sets of springs by name, each a tuple of one or two
    :class:`InstalledSpring` (outer first). ``variants``: the runs a case requests (none: one run of the train as given).
    """

    kind: str
    cam: CamParameters
    follower: FollowerParameters = FollowerParameters()
    valve: ValveParameters = Field(kw_only=True)
    contacts: ContactsField = Field(kw_only=True)
    springs: SpringSets = FrozenMapping()
    spring_set: Name = Field(default="", description="set in use; without it the first")
    spring_model: str = Field(
        default="",
        description="name of the spring model; without it modal-uniform for cards, reduced-rod for wires",
    )
    rubbing: Rubbing = Rubbing()
    lever: LeverParameters | None = None
    pushrod: PushrodParameters | None = None
    support: SupportParameters | None = None
    crank: CrankParameters | None = None
    gas: GasLoad | None = None
    lash: Lash = Field(default=0.0, description="play at the valve")
    gravity: Gravity = Field(default=(0.0, -9.80665), description="vector in the plane of motion")
    model: Literal["planar", "lumped", "single-mass"] = Field(
        default="planar", description="planar bodies, ratios or one mass"
    )
    variants: tuple[TrainVariant, ...] = ()
    cycles: StrictInt | None = Field(
        default=None,
        description="maximum of cam revolutions: 60, in sweeps 30, with finite elements 4 to 10, by their damping",
    )

    @model_validator(mode="before")
    @classmethod
    def _name_kinds(cls, raw: Any) -> Any:
        """Refuse a train without its kind by naming the kinds there are."""
        if isinstance(raw, dict) and "kind" not in raw:
            choice = choice_of(tuple(registered_names("mechanisms")))
            raise problem(f"'kind' is missing; add it: {choice}", ("kind",))
        if isinstance(raw, dict) and isinstance(raw.get("springs"), dict):
            pairs = [one for one in raw["springs"].values() if isinstance(one, list) and one[1:]]
            if raw.get("rubbing") and not pairs:
                raise problem(
                    "rubbing acts between two nested springs, and no set has two; remove it",
                    ("rubbing",),
                )
        return raw

    def __post_init__(self) -> None:
        known = registered_names("mechanisms")
        if self.kind not in known:
            reason = answer(self.kind, tuple(known))
            raise problem(f"train kind '{self.kind[:40]}' is unknown; {reason}", ("kind",))
        if len(self.gravity) != 2:
            raise problem(
                "gravity is a vector in the plane of motion, two accelerations", ("gravity",)
            )
        if self.cycles is not None and not 1 <= self.cycles <= 10_000:
            raise problem(
                f"cycles of the train must be a whole number from 1 to 10000; it is {self.cycles}"
            )
        sets = self.springs
        contacts = guarded(with_steel, self.contacts, self.kind, self.cam, path=("contacts",))
        object.__setattr__(self, "contacts", FrozenMapping(contacts))
        if any(
            "time_step" in one.options_of("finite-element")
            for group in sets.values()
            for one in group
        ):
            raise problem(
                "a train chooses the time step of its springs; leave out time_step of finite-element"
            )
        if self.spring_set and self.spring_set not in sets:
            raise problem(
                f"spring set '{self.spring_set}' is unknown; the case holds {', '.join(sets) or 'none'}"
            )
        for place, variant in enumerate(self.variants):
            if variant.spring_set and variant.spring_set not in sets:
                raise problem(
                    f"spring set '{variant.spring_set}' is unknown; the case holds {', '.join(sets)}",
                    ("variants", place, "spring_set"),
                )

    def replace(self, **changes: Any) -> TrainParameters:
        """A copy with the named fields changed."""
        return replace(self, **changes)

    def model_of(self, spring_set: str = "") -> str:
        """Name of the spring model of a set: the given one, else modes where one of its springs is a
        card, the reduced rod where all are wires, a chain of masses of springs that rub and where :meth:`why_no_rod` says why.
        """
        if self.spring_model:
            return self.spring_model
        springs = self._of(spring_set)
        cards = [spring.wire is None for spring in springs]
        if all(cards) if self._rub(springs) else any(cards):
            return "modal-uniform"
        return "multi-mass" if self.why_no_rod(spring_set) or not springs else "reduced-rod"

    def _rub(self, springs: Sequence[InstalledSpring]) -> bool:
        return len(springs) == 2 and self.rubbing.coefficient > 0 and self.rubbing.normal_force > 0

    def why_no_rod(self, spring_set: str = "") -> str:
        """Why the reduced rod is not the model of a set in which one is a wire; empty where it is,
        where a model is given and where all are cards.
        """
        springs = self._of(spring_set)
        if self.spring_model or all(spring.wire is None for spring in springs):
            return ""
        if self._rub(springs):
            return f"springs '{springs[0].name}' and '{springs[1].name}' rub on one another"
        for spring in springs:
            if spring.wire is None:
                return f"spring '{spring.name}' is known by its card only"
            if spring.contact.law != "linear":
                return f"spring '{spring.name}' has a contact law of its own"
            if spring.options_of("finite-element").get("lifting_ends"):
                return f"the ends of spring '{spring.name}' lift"
        return ""

    def _of(self, spring_set: str) -> tuple[InstalledSpring, ...]:
        chosen = spring_set or self.spring_set or next(iter(self.springs), "")
        return tuple(self.springs.get(chosen, ()))

    def requested(
        self, spring_sets: Sequence[str] = (), models: Sequence[str] = ()
    ) -> tuple[TrainVariant, ...]:
        """The runs of a request: the physical variants of the case, or ``spring_sets`` by ``models``; and the replicas
        whose name stands among the sets. Empty labels are those of whole sets.
        """
        replicas = [one for one in self.variants if one.replica and one.replica in spring_sets]
        names = {one.replica for one in replicas} - set(self.springs)
        sets = [name for name in spring_sets if name not in names]
        if sets or (models and not replicas):
            made = [
                TrainVariant("", name, word)
                for name in sets or (self.spring_set,)
                for word in models or ("",)
            ]
        else:
            made = [] if models else [one for one in self.variants if not one.replica]
        repeated = [
            replace(
                one,
                label=f"{one.label}, {word}" if word else one.label,
                spring_model=word or one.spring_model,
            )
            for one in replicas
            for word in models or ("",)
        ]
        return (*made, *repeated) or (TrainVariant(self.model_of(), self.spring_set),)

    @property
    def swept_sets(self) -> tuple[str, ...]:
        """Names of the spring sets that a sweep runs: the one in use, every one where none is named."""
        return (self.spring_set,) if self.spring_set else tuple(self.springs)

    def contact(self, place: str) -> ContactParameters:
        """The law at one place. Raises :class:`InputError` when the case gives none."""
        if place not in self.contacts:
            raise InputError(
                f"the train has no contact law for '{place}'; it has {', '.join(self.contacts)}"
            )
        found: ContactParameters = self.contacts[place]
        return found

    def spring_parts(self, name: str | None = None) -> tuple[InstalledSpring, ...]:
        """The springs of one spring set (the one in use by default), outer first."""
        chosen = name or self.spring_set or next(iter(self.springs), "")
        if chosen not in self.springs:
            raise InputError(
                f"spring set '{chosen}' is unknown; the case holds {', '.join(self.springs) or 'none'}"
            )
        return tuple(self.springs[chosen])


#: Name of the table below [train] -> what reads it; [[train.variants]] is a list.
PARTS: dict[str, type[Table]] = {
    "cam": CamParameters, "follower": FollowerParameters, "lever": LeverParameters, "pushrod": PushrodParameters,
    "support": SupportParameters, "valve": ValveParameters, "gas": GasLoad, "crank": CrankParameters, "variants": TrainVariant,
}  # fmt: skip
