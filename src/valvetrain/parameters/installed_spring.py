"""A spring as installed in the engine: its wire or its card, how it is installed, how it is damped,
and the options of its models.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import InitVar, fields, replace
from typing import Annotated, Any, Literal, get_args

import numpy as np
from pydantic import AfterValidator, Field, StrictBool, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import ArgsKwargs

from valvetrain import registry
from valvetrain.errors import FrozenMapping, InputError
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.own_parts import carrying
from valvetrain.parameters.schema_types import (
    FOLLOWS,
    DampingRate,
    Frequency,
    Length,
    PositiveLength,
    Ratio,
    StrictModel,
    Table,
    Time,
    guarded,
    problem,
    quantity,
    refuse_unknown,
    table,
    validate_as,
)
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.spring_options import options_problem

Share = Annotated[float, quantity("ratio", low=0.0, high=1.0)]
PositiveLineStiffness = Annotated[float, quantity("line stiffness", low=0.0, open_low=True)]
NormalForce = Annotated[float, quantity("force", low=0.0)]


#: Share of a given ratio that is stiffness-proportional when the case does not say: the
#: least-damped point is then at ``ratio_frequency``.
DEFAULT_STIFFNESS_SHARE = 0.5
#: Relative slack within which a ratio and explicit coefficients must agree.
AGREEMENT = 0.005


@table("the damping")
class DampingParameters(Table):
    """Rayleigh damping, force = (``mass_damping`` M + ``stiffness_damping`` K) velocity.

    Give the coefficients (1/s and s), or ``ratio`` (of critical) at ``ratio_frequency`` (Hz) with
    ``stiffness_share``, the part of the ratio that is stiffness-proportional: with w = 2 pi
    ratio_frequency, mass_damping = 2 ratio w (1 - share) and stiffness_damping = 2 ratio share / w.
    A ratio with one coefficient leaves the rest to the other. After construction both coefficients
    are numbers. Raises :class:`InputError` when two ways of saying it disagree.
    """

    mass_damping: DampingRate = Field(
        default=FOLLOWS, description="damping over mass; without it and a ratio none"
    )
    stiffness_damping: Time = Field(
        default=FOLLOWS, description="damping over stiffness; without it and a ratio none"
    )
    ratio: Ratio | None = Field(
        default=None, description="share of critical damping at ratio_frequency"
    )
    ratio_frequency: Frequency | None = Field(
        default=None, description="frequency at which ratio holds"
    )
    stiffness_share: Ratio | None = Field(
        default=None,
        description=f"share of ratio from stiffness; without it {DEFAULT_STIFFNESS_SHARE:g}",
    )

    def __post_init__(self) -> None:
        if (self.ratio is None) != (self.ratio_frequency is None):
            raise problem(
                "a damping ratio holds at one frequency; give ratio and ratio_frequency together"
            )
        mass, stiffness = self.mass_damping, self.stiffness_damping
        if self.ratio is not None:
            mass, stiffness = self._of_ratio(self.ratio)
        elif self.stiffness_share is not None:
            raise problem(
                "stiffness_share splits a damping ratio; give ratio and ratio_frequency with it, or drop it"
            )
        object.__setattr__(self, "mass_damping", float(mass or 0.0))
        object.__setattr__(self, "stiffness_damping", float(stiffness or 0.0))

    def _of_ratio(self, ratio: float) -> tuple[float, float]:
        """Coefficients (1/s and s) that make the ratio."""
        frequency = self.ratio_frequency or 0.0
        if ratio >= 1:
            raise problem(
                f"damping ratio {ratio:g} at {frequency:g} Hz is no light damping of a spring; "
                "give a ratio below 1 (such as 0.016) at a positive frequency"
            )
        share, circular = self.stiffness_share, 2 * math.pi * frequency
        if share is not None and not 0 <= share <= 1:
            raise problem(
                f"stiffness_share must be between 0 (all mass-proportional) and 1; it is {share:g}"
            )
        mass: float | None = self.mass_damping
        stiffness: float | None = self.stiffness_damping
        if share is None and mass is not None and stiffness is None:
            stiffness = (2 * ratio - mass / circular) / circular
        elif share is None and stiffness is not None and mass is None:
            mass = (2 * ratio - stiffness * circular) * circular
        share = DEFAULT_STIFFNESS_SHARE if share is None else share
        mass = 2 * ratio * circular * (1 - share) if mass is None else mass
        stiffness = 2 * ratio / circular * share if stiffness is None else stiffness
        if mass < -1e-9 * circular or stiffness < -1e-9 / circular:
            raise problem(
                f"the coefficient given damps more than the ratio {ratio:g} allows; lower it or raise the ratio"
            )
        total = mass / (2 * circular) + stiffness * circular / 2
        split_off = (
            self.stiffness_share is not None
            and abs(stiffness * circular / 2 - share * ratio) > AGREEMENT * ratio
        )
        if abs(total - ratio) > AGREEMENT * ratio or split_off:
            raise problem(
                f"mass_damping {mass:g} 1/s and stiffness_damping {stiffness:g} s make a ratio of {total:.4g} "
                f"at {frequency:g} Hz, but ratio says {ratio:g} (share {share:g}); give the damping one way"
            )
        return max(mass, 0.0), max(stiffness, 0.0)

    def ratio_at(self, frequency_hertz: float) -> float:
        """Damping ratio (of critical) of a mode at ``frequency_hertz`` (Hz, positive)."""
        circular = 2 * math.pi * frequency_hertz
        return self.mass_damping / (2 * circular) + self.stiffness_damping * circular / 2

    def replace(self, **changes: Any) -> DampingParameters:
        """A copy with the named fields changed; changing the ratio or its split recomputes the
        coefficients, and the other way round.
        """
        by_ratio = {"ratio", "ratio_frequency", "stiffness_share"} & set(changes)
        by_coefficient = {"mass_damping", "stiffness_damping"} & set(changes)
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        if by_ratio and not by_coefficient:
            values |= {"mass_damping": None, "stiffness_damping": None}
        elif by_coefficient and not by_ratio:
            values |= {"ratio": None, "ratio_frequency": None, "stiffness_share": None}
        return DampingParameters(**(values | changes))


#: Stiffness of a wall (N/m per m of wire): that of coil on coil.
GUIDE_STIFFNESS = 2e10


@table("the guide")
class Guide(Table):
    """Walls on the axis of the seats along the whole spring, on which the wire slides without friction.

    >>> Guide(bore=30e-3).stiffness
    20000000000.0
    """

    bore: PositiveLength | None = Field(
        default=None, description="inner diameter of a bore around the spring; without it none"
    )
    rod: PositiveLength | None = Field(
        default=None, description="outer diameter of a rod inside the spring; without it none"
    )
    stiffness: PositiveLineStiffness = Field(
        default=GUIDE_STIFFNESS, description="stiffness of the contact per length of wire"
    )

    def __post_init__(self) -> None:
        if self.bore is None and self.rod is None:
            raise problem(
                "a guide needs the diameter of its bore, of its rod, or both; give one, or leave the guide out"
            )

    def check_fit(self, spring: SpringDefinition) -> None:
        """Raise :class:`InputError` where the free spring does not fit in the bore or over the rod."""
        coil = np.linspace(0.0, spring.total_coils, 1025)
        mean, wire = spring.mean_diameter.value(coil), spring.wire_diameter.value(coil)
        outer, inner = float(np.max(mean + wire)), float(np.min(mean - wire))
        if self.bore is not None and self.bore <= outer:
            raise InputError(
                f"spring '{spring.name}' does not fit in a bore of {self.bore * 1e3:.4g} mm: its outer diameter is {outer * 1e3:.4g} mm; "
                "widen the bore"
            )
        if self.rod is not None and self.rod >= inner:
            raise InputError(
                f"spring '{spring.name}' does not go over a rod of {self.rod * 1e3:.4g} mm: its inner diameter is {inner * 1e3:.4g} mm; "
                "make the rod thinner"
            )

    def summary(self) -> str:
        """What it is, for people."""
        parts = [
            f"{word} of {value * 1e3:.5g} mm"
            for word, value in (("bore", self.bore), ("rod", self.rod))
            if value is not None
        ]
        return " and ".join(parts)


#: Line stiffness (N/m per m) beyond which linear algebra on it never ends.
STIFFEST = 1e40
#: The law of contact between coils that ships.
LINEAR = "linear"
LineStiffness = Annotated[float, quantity("line stiffness", low=0.0, high=STIFFEST)]


def _table_of(law: Any) -> type[StrictModel]:
    """The table of the keys that a law alone has."""
    if law == LINEAR or not isinstance(law, str):
        return StrictModel
    found: type[StrictModel] = guarded(registry.find, "coil_contacts", law, path=("law",)).table
    return found


@table("the coil contact")
class CoilContact(Table):
    """Contact of coil on coil and of coil on seat, the same for every model: ``stiffness`` (N/m per
    m of wire), ``damping_time`` (s), the name of its ``law`` and the ``values`` of that law alone
    (:mod:`valvetrain.coil_contact`), which in a file stand among the other keys.
    """

    stiffness: LineStiffness = Field(
        default=2e10,
        description="stiffness per length of wire; 0: coils pass through each other",
    )
    damping_time: Time = Field(default=1e-6, description="damping over stiffness")
    law: str = Field(
        default=LINEAR, description="law of the force, with keys of its own where it has some"
    )
    values: Annotated[Mapping[str, Any], AfterValidator(FrozenMapping)] = FrozenMapping()

    @model_validator(mode="before")
    @classmethod
    def _values_of_law(cls, raw: Any) -> Any:
        """The table of a file, with the keys of its law as values."""
        if isinstance(raw, (cls, ArgsKwargs)):
            return raw
        refuse_unknown(raw, cls.fields_of(raw if isinstance(raw, dict) else {}))
        if not isinstance(law := raw.get("law", LINEAR), str):
            return raw
        of_law = {key: one for key, one in raw.items() if key not in cls.model_fields}
        values = dict(validate_as(_table_of(law), of_law))
        common = {key: one for key, one in raw.items() if key not in of_law}
        return common | {"law": carrying(law), "values": values}

    @classmethod
    def fields_of(cls, given: Mapping[str, Any]) -> dict[str, FieldInfo]:
        """The fields of the table with those of the law that it names."""
        own = {key: one for key, one in cls.model_fields.items() if key != "values"}
        return {**own, **_table_of(given.get("law", LINEAR)).model_fields}


EndContact = Literal["lifting", "bonded"]
#: Ways a retainer is oriented about the axis.
Rotation = Literal["fixed", "free"]
ROTATIONS = get_args(Rotation)
#: Shorter compressions (m) come from rounding: the spring is installed at its free length.
ROUNDING = 1e-9


@table("an installed spring")
class InstalledSpring(Table):
    """One spring between seat and retainer: exactly one of ``wire`` and ``card``.

    ``precompression`` (m): shortening from the free length with the valve closed (a wire's, for which ``installed_height`` may
    be given; a card's is preload / rate). ``seats``: ``planes`` where end coils may touch flat seats beyond
    their inactive turns, ``clamps`` where nothing but the inactive ends is touched. ``options``:
    spring-model word -> keyword arguments of that model's options. ``tied``: its ends are bonded
    to seat and retainer (``end_contact``), so that it also pulls; others lift where they would pull. ``guide``: bore or rod that
    keeps a wire straight; springs that only move along their axis need none and do not feel it.
    ``retainer_rotation``: whether the retainer may turn about the axis at rest, which a wire alone
    feels. Raises :class:`InputError` for a spring that would be stretched or solid as installed.
    """

    wire: SpringDefinition | None = None
    card: SpringCard | None = None
    precompression: Length = Field(
        default=FOLLOWS,
        description="shortening from the free length with the valve closed; without it none",
    )
    seats: Literal["planes", "clamps"] = Field(
        default="planes", description="flat seats, or nothing but the fixed inactive ends"
    )
    damping: DampingParameters = DampingParameters()
    contact: CoilContact = CoilContact()
    options: Mapping[str, Any] = FrozenMapping()
    tied: StrictBool = False
    guide: Guide | None = Field(
        default=None, description="bore or rod that keeps the spring straight"
    )
    retainer_rotation: Rotation = Field(
        default="fixed", description="whether the retainer may turn about the axis at rest"
    )
    installed: InitVar[PositiveLength | None] = Field(default=None, alias="installed_height")
    ends: InitVar[EndContact | None] = Field(
        default=None,
        alias="end_contact",
        description="whether the ends lift off seat and retainer, or are bonded and pull; by default they lift, between clamps they are bonded",
    )

    def __post_init__(self, installed: float | None, ends: EndContact | None) -> None:
        if (self.wire is None) == (self.card is None):
            raise problem(
                "an installed spring is known by its wire or by its card; give one of them"
            )
        compression = self._compression(installed)
        if ends == "lifting" and self.seats == "clamps":
            raise problem(
                "ends between clamps cannot lift; give seats = 'planes', or bonded ends",
                ("end_contact",),
            )
        if self.guide is not None:
            if self.wire is None:
                raise problem(
                    f"spring '{self.name}' is known by its card, so it cannot lean on a guide; remove the guide or give its wire"
                )
            guarded(self.guide.check_fit, self.wire, path=("guide",))
        options = {word: FrozenMapping(values) for word, values in self.options.items()}
        if ends == "lifting":
            word = "finite-element"
            options[word] = FrozenMapping({"lifting_ends": True, **options.get(word, {})})
        if (wrong := options_problem(options, self.card is not None)) is not None:
            raise problem(wrong[2], ("options", *wrong[:2]))
        values = {"precompression": compression, "options": FrozenMapping(options)}
        for name, value in {**values, "tied": self.tied or ends == "bonded"}.items():
            object.__setattr__(self, name, value)

    def _compression(self, installed: float | None) -> float:
        """Shortening (m) as installed; refuses a wire that would be stretched or solid."""
        if self.card is not None:
            if self.card.preload < 0 or self.card.rate <= 0:
                raise problem(
                    f"the card of spring '{self.name}' gives a rate of {self.card.rate:g} N/m and a preload of {self.card.preload:g} N; "
                    "the rate must be positive and the preload zero or more"
                )
            return self.card.preload / self.card.rate
        assert self.wire is not None
        key, compression = "precompression", self.precompression or 0.0
        if installed is not None:
            key, compression = "installed_height", self.wire.free_length - installed
            if self.precompression is not None:
                raise problem(
                    "precompression and installed_height are both given and may contradict; give one",
                    (key,),
                )
        if abs(compression) < ROUNDING:
            return 0.0
        if compression < 0:
            remedy = f"its free length is {self.wire.free_length * 1e3:.4g} mm; lower installed_height or raise precompression"
            raise problem(f"the spring would be stretched, not compressed: {remedy}", (key,))
        if compression >= (room := self.wire.solid_compression):
            raise problem(
                f"the spring is solid before this compression; it has {room * 1e3:.4g} mm of travel left: compress it less",
                (key,),
            )
        return compression

    @property
    def name(self) -> str:
        """Name of the spring."""
        part = self.wire or self.card
        assert part is not None
        return part.name

    @property
    def pulls(self) -> bool:
        """Whether the ends are held, so that the spring also pulls: between clamps, or ``tied``;
        others press or lift.
        """
        return self.tied or (self.wire is not None and self.seats == "clamps")

    @property
    def installed_height(self) -> float | None:
        """Height (m) between the seats with the valve closed; None where a card does not give it."""
        return (
            self.wire.free_length - self.precompression
            if self.wire is not None
            else self.card.installed_height
            if self.card
            else None
        )

    @property
    def solid_height(self) -> float | None:
        """Height (m) with all coils closed; None where a card does not give it."""
        return (
            self.wire.solid_height
            if self.wire is not None
            else self.card.solid_height
            if self.card
            else None
        )

    @property
    def end_contact(self) -> str:
        """Whether the ends lift off seat and retainer where they would pull, as the file says it."""
        return "bonded" if self.tied else "lifting"

    @property
    def room(self) -> float | None:
        """Lift (m) from the installed state to coil bind; None where it is not known."""
        if self.installed_height is None or self.solid_height is None:
            return None
        return self.installed_height - self.solid_height

    def clearances(self, valve_lift: float) -> dict[str, float]:
        """What is left to coil bind at a ``valve_lift`` (m) by the names of its quantities: as far as it is known by the solid
        height, else least and most by wire and turns of the card; empty where neither is known.
        """
        if self.room is not None:
            return {"coil_bind_clearance": self.room - valve_lift}
        heights = self.card and self.card.wound_heights
        if not heights or self.installed_height is None:
            return {}
        most, least = (self.installed_height - valve_lift - one for one in heights)
        return {"wound_least_clearance": least, "wound_most_clearance": most}

    def options_of(self, model: str) -> Mapping[str, Any]:
        """Keyword arguments of one model's options."""
        found: Mapping[str, Any] = self.options.get(model, {})
        return found

    def with_options(self, model: str, **values: Any) -> InstalledSpring:
        """A copy with options of one model changed."""
        return replace(self, options={**self.options, model: {**self.options_of(model), **values}})

    def without_preload(self) -> InstalledSpring:
        """The same spring at rest with the valve closed, by the formula F = k x of a source that
        leaves the preload out: it is ``tied``.
        """
        if self.card is not None:
            return replace(self, card=self.card.replace(preload=0.0), tied=True)
        return replace(self, precompression=0.0, tied=True)


@table("the rubbing")
class Rubbing(Table):
    """Friction between nested springs, the [rubbing] or [train.rubbing] table."""

    coefficient: Ratio = Field(
        default=FOLLOWS, description="coefficient of friction between the springs; without it none"
    )
    normal_force: NormalForce = Field(
        default=FOLLOWS,
        description="force with which the springs press on each other; without it none",
    )

    def __post_init__(self) -> None:
        for name, other in (("coefficient", "normal_force"), ("normal_force", "coefficient")):
            if (getattr(self, name) or 0.0) > 0 and getattr(self, other) is None:
                raise problem(
                    f"{name} without {other} rubs nothing; give both, or remove the table", (name,)
                )
        for name in ("coefficient", "normal_force"):
            if getattr(self, name) is None:
                object.__setattr__(self, name, 0.0)


def binding_lift(springs: tuple[InstalledSpring, ...], maximum_lift: float, group: str = "") -> str:
    """Sentence on the first spring (of the set ``group``) that a lift (m) would press solid; empty when
    all fit.
    """
    of_set = f" of set '{group}'" if group else ""
    for spring in springs:
        if spring.room is not None and maximum_lift >= spring.room:
            assert spring.installed_height is not None and spring.solid_height is not None
            return (
                f"spring '{spring.name}'{of_set} reaches coil bind: {spring.installed_height * 1e3:.4g} mm installed less "
                f"{maximum_lift * 1e3:.4g} mm of lift leave {(spring.installed_height - maximum_lift) * 1e3:.4g} mm, but it is solid at "
                f"{spring.solid_height * 1e3:.4g} mm; install it higher, lift less or take out coils"
            )
    return ""
