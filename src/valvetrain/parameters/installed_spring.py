"""A spring as it stands in the engine: its wire or its card, how it is installed, how it is damped, and the options of its models."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from valvetrain.errors import InputError
from valvetrain.parameters.card import SpringCard
from valvetrain.parameters.damping import DampingParameters
from valvetrain.parameters.guide import Guide
from valvetrain.parameters.lift_law import FrozenMapping
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.spring_options import options_problem
from valvetrain.units import keep_si

#: Line stiffness (N/m per m) beyond which linear algebra on it never ends.
STIFFEST = 1e40
#: Ways a retainer stands about the axis.
ROTATIONS = ("fixed", "free")


@dataclass(frozen=True, slots=True)
class CoilContact:
    """Contact of coil on coil and of coil on seat, the same for every model: ``stiffness`` (N/m per m of wire; 0: coils pass through
    each other) and ``damping_time`` (s), damping over stiffness."""

    stiffness: float = 2e10
    damping_time: float = 1e-6

    def __post_init__(self) -> None:
        keep_si(self, "the coil contact", stiffness="line stiffness", damping_time="time")
        for name in ("stiffness", "damping_time"):
            value = getattr(self, name)
            if not value >= 0:
                raise InputError(f"{name} of the coil contact must be zero or a positive number; it is {value:g}")
        if self.stiffness > STIFFEST:
            raise InputError(f"stiffness of the coil contact is {self.stiffness:g} N/m per m, beyond any steel; give one near 2e10")


@dataclass(frozen=True)
class InstalledSpring:
    """One spring between seat and retainer: exactly one of ``wire`` and ``card``.

    ``precompression`` (m): shortening from the free length with the valve closed (a wire's; a card's is preload / rate).
    ``seats``: ``planes`` where end coils may touch flat seats beyond their inactive turns, ``clamps`` where nothing but the inactive
    ends is touched. ``options``: spring-model word -> keyword arguments of that model's options. ``tied``: a source's own spring whose
    ends never leave seat and retainer, so that it also pulls. ``guide``: bore or rod that keeps a wire straight; springs that only move
    along their axis need none and do not feel it. ``retainer_rotation``: whether the retainer may turn about the axis at rest, which a
    wire alone feels. Raises :class:`InputError` for a spring that would be stretched or solid
    as installed.
    """

    wire: SpringDefinition | None = None
    card: SpringCard | None = None
    precompression: float = 0.0
    seats: Literal["planes", "clamps"] = "planes"
    damping: DampingParameters = field(default_factory=DampingParameters)
    contact: CoilContact = CoilContact()
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=FrozenMapping)
    tied: bool = False
    guide: Guide | None = None
    retainer_rotation: Literal["fixed", "free"] = "fixed"

    def __post_init__(self) -> None:
        keep_si(self, "an installed spring", precompression="compression")
        object.__setattr__(self, "options", FrozenMapping({word: FrozenMapping(values) for word, values in self.options.items()}))
        if (self.wire is None) == (self.card is None):
            raise InputError("an installed spring is known by its wire or by its card; give one of them")
        if self.seats not in ("planes", "clamps"):
            raise InputError(f"seats '{self.seats}' of spring '{self.name}' is unknown; use planes or clamps")
        if (wrong := options_problem(self.options, self.card is not None)) is not None:
            raise InputError(wrong[2])
        if self.card is not None and not (self.card.rate > 0 and self.card.preload >= 0):
            raise InputError(
                f"the card of spring '{self.name}' gives a rate of {self.card.rate:g} N/m and a preload of {self.card.preload:g} N; "
                "the rate must be positive and the preload zero or more"
            )
        if self.card is not None:
            object.__setattr__(self, "precompression", self.card.preload / self.card.rate)
        if self.wire is not None:
            self.wire.refuse_solid(self.precompression)
        if self.retainer_rotation not in ROTATIONS:
            raise InputError(f"retainer_rotation '{self.retainer_rotation}' of spring '{self.name}' is unknown; use fixed or free")
        if self.guide is not None:
            if self.wire is None:
                raise InputError(
                    f"spring '{self.name}' is known by its card, so it cannot lean on a guide; remove the guide or give its wire"
                )
            self.guide.check_fit(self.wire)

    @property
    def name(self) -> str:
        """Name of the spring."""
        part = self.wire or self.card
        assert part is not None
        return part.name

    @property
    def pulls(self) -> bool:
        """Whether the ends are held, so that the spring also pulls: between clamps, or ``tied``; others press or are loose."""
        return self.tied or (self.wire is not None and self.seats == "clamps")

    @property
    def installed_height(self) -> float | None:
        """Height (m) between the seats with the valve closed; None where a card does not tell it."""
        return self.wire.free_length - self.precompression if self.wire is not None else self.card.installed_height if self.card else None

    @property
    def solid_height(self) -> float | None:
        """Height (m) with all coils closed; None where a card does not tell it."""
        return self.wire.solid_height if self.wire is not None else self.card.solid_height if self.card else None

    @property
    def room(self) -> float | None:
        """Lift (m) from the installed state to coil bind; None where it is not known."""
        if self.installed_height is None or self.solid_height is None:
            return None
        return self.installed_height - self.solid_height

    def options_of(self, model: str) -> Mapping[str, Any]:
        """Keyword arguments of one model's options."""
        found: Mapping[str, Any] = self.options.get(model, {})
        return found

    def with_options(self, model: str, **values: Any) -> InstalledSpring:
        """A copy with options of one model changed."""
        return replace(self, options={**self.options, model: {**self.options_of(model), **values}})

    def without_preload(self) -> InstalledSpring:
        """The same spring at rest with the valve closed, by the formula F = k x of a source that leaves the preload out: it is ``tied``."""
        if self.card is not None:
            return replace(self, card=replace(self.card, preload=0.0), tied=True)
        return replace(self, precompression=0.0, tied=True)


@dataclass(frozen=True, slots=True)
class Rubbing:
    """Friction between nested springs: ``coefficient`` and the radial ``normal_force`` (N) with which they press on each other."""

    coefficient: float = 0.0
    normal_force: float = 0.0


def binding_lift(springs: tuple[InstalledSpring, ...], maximum_lift: float) -> str:
    """Sentence on the first spring that a lift (m) would press solid; empty when all have room."""
    for spring in springs:
        if spring.room is not None and maximum_lift >= spring.room:
            assert spring.installed_height is not None and spring.solid_height is not None
            return (
                f"spring '{spring.name}' reaches coil bind: {spring.installed_height * 1e3:.4g} mm installed less "
                f"{maximum_lift * 1e3:.4g} mm of lift leave {(spring.installed_height - maximum_lift) * 1e3:.4g} mm, but it is solid at "
                f"{spring.solid_height * 1e3:.4g} mm; install it higher, lift less or take out coils"
            )
    return ""
