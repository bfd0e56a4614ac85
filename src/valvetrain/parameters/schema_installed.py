"""One block per installed spring, the same in a spring case ([spring]) and in a train
([[train.springs.SET]]).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, ValidatorFunctionWrapHandler, WrapValidator

from valvetrain import registry
from valvetrain.parameters.installed_spring import (
    CoilContact,
    DampingParameters,
    Guide,
    InstalledSpring,
)
from valvetrain.parameters.own_parts import carrying
from valvetrain.parameters.schema_spring import SpringCardModel, SpringModel
from valvetrain.parameters.schema_types import (
    Length,
    PositiveLength,
    StrictModel,
    Time,
    guarded,
    placed,
    problem,
    quantity,
    validate_as,
)
from valvetrain.parameters.spring_options import options_problem, options_table

_CONTACT = CoilContact()
#: Shorter compressions (m) come from rounding: the spring is installed at its free length.
ROUNDING = 1e-9
EndContact = Literal["lifting", "bonded"]
LineStiffness = Annotated[float, quantity("line stiffness", low=0.0)]


class CoilContactModel(StrictModel):
    """The ``contact`` of coils with each other and with the seats."""

    stiffness: LineStiffness = Field(
        default=_CONTACT.stiffness,
        description="stiffness per length of wire; 0: coils pass through each other",
    )
    damping_time: Time = Field(default=_CONTACT.damping_time, description="damping over stiffness")
    law: str = Field(
        default=_CONTACT.law, description="law of the force, with keys of its own where it has some"
    )

    def build(self) -> CoilContact:
        """The contact; what the table of a law has beyond this one are the values of that law."""
        common = {name: getattr(self, name) for name in CoilContactModel.model_fields}
        common["law"] = carrying(self.law)
        own = {name: value for name, value in self if name not in common}
        built: CoilContact = guarded(lambda: CoilContact(**common, values=own))
        return built


def _by_law(raw: Any, read: ValidatorFunctionWrapHandler) -> Any:
    """A ``contact`` by the table of the law that it names."""
    law = raw.get("law", _CONTACT.law) if isinstance(raw, dict) else _CONTACT.law
    if law == _CONTACT.law or not isinstance(law, str):
        return read(raw)
    return validate_as(guarded(registry.find, "coil_contacts", law, path=("law",)).table, raw)


CoilContactField = Annotated[CoilContactModel, WrapValidator(_by_law)]


def _read_options(raw: Any) -> dict[str, StrictModel]:
    if not isinstance(raw, dict):
        raise problem("a table of spring-model words is needed here, such as options.multi-mass")
    return {
        word: validate_as(guarded(options_table, word, path=(word,)), values, (word,))
        for word, values in raw.items()
    }


Options = Annotated[dict[str, StrictModel], PlainValidator(_read_options)]


class Installation(StrictModel):
    """How any spring is installed, damped and computed."""

    damping: DampingParameters = DampingParameters()
    contact: CoilContactField = CoilContactModel()
    end_contact: EndContact | None = Field(
        default=None,
        description="whether the ends lift off seat and retainer, or are bonded and pull; by default they lift, between clamps they are bonded",
    )
    options: Options = Field(default_factory=dict)

    def assembled(self, **known: Any) -> InstalledSpring:
        """The installed spring with ``known`` fields of its own."""
        options = {
            word: table.model_dump(exclude_unset=True) for word, table in self.options.items()
        }
        if self.end_contact == "lifting":
            options["finite-element"] = {"lifting_ends": True, **options.get("finite-element", {})}
        if (wrong := options_problem(options, "card" in known)) is not None:
            raise problem(wrong[2], ("options", *wrong[:2]))
        contact, tied = placed("contact", self.contact.build), self.end_contact == "bonded"
        made: InstalledSpring = guarded(
            lambda: InstalledSpring(
                damping=self.damping, contact=contact, options=options, tied=tied, **known
            )
        )
        return made


class WireBlock(Installation, SpringModel):
    """A spring by its wire, as installed."""

    precompression: Length | None = Field(
        default=None,
        description="shortening from the free length with the valve closed; without it none",
    )
    installed_height: PositiveLength | None = None
    seats: Literal["planes", "clamps"] = Field(
        default="planes", description="flat seats, or nothing but the fixed inactive ends"
    )
    retainer_rotation: Literal["fixed", "free"] = Field(
        default="fixed", description="whether the retainer may turn about the axis at rest"
    )
    guide: Guide | None = Field(
        default=None, description="bore or rod that keeps the spring straight"
    )

    def installed(self, name: str, group: str = "") -> InstalledSpring:
        """The installed spring; refuses one that would be stretched or solid. ``group`` is not used."""
        wire = self.build(name)
        if self.precompression is not None and self.installed_height is not None:
            raise problem(
                "precompression and installed_height are both given and may contradict; give one",
                ("installed_height",),
            )
        given = "installed_height" if self.installed_height is not None else "precompression"
        compression = (
            self.precompression or 0.0
            if self.installed_height is None
            else wire.free_length - self.installed_height
        )
        if abs(compression) < ROUNDING:
            compression = 0.0
        if compression < 0:
            remedy = f"its free length is {wire.free_length * 1e3:.4g} mm; lower installed_height or raise precompression"
            raise problem(f"the spring would be stretched, not compressed: {remedy}", (given,))
        room = wire.solid_compression
        if compression >= room:
            raise problem(
                f"the spring is solid before this compression; it has {room * 1e3:.4g} mm of travel left: compress it less",
                (given,),
            )
        if self.end_contact == "lifting" and self.seats == "clamps":
            raise problem(
                "ends between clamps cannot lift; give seats = 'planes', or bonded ends",
                ("end_contact",),
            )
        if self.guide is not None:
            placed("guide", self.guide.check_fit, wire)
        return self.assembled(
            wire=wire,
            precompression=compression,
            seats=self.seats,
            guide=self.guide,
            retainer_rotation=self.retainer_rotation,
        )


class CardBlock(Installation, SpringCardModel):
    """A spring by its catalogue card."""

    def installed(self, name: str, group: str = "") -> InstalledSpring:
        """The installed spring of the card, called ``name`` where it has no name of its own; ``group``:
        the spring set that a warning names.
        """
        called = self.name if not name or "name" in self.model_fields_set else name
        card = self.build(f"'{called}'" + (f" of set '{group}'" if group else ""))
        return self.assembled(card=replace(card, name=called))
