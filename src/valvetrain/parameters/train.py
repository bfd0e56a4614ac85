"""A whole valvetrain in numbers: frozen, SI, no model inside. Plane of motion x-y, cam centre at
the origin.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from valvetrain.errors import InputError
from valvetrain.parameters.installed_spring import InstalledSpring, Rubbing
from valvetrain.parameters.lift_law import FrozenMapping
from valvetrain.parameters.train_names import answer
from valvetrain.registry import names as registered_names
from valvetrain.units import keep_si, si_each, warn_unusual

TrainModel = Literal["planar", "lumped", "single-mass"]
FollowerShape = Literal["flat", "domed", "roller", "knife"]
#: Least and largest value (SI) of what is common in engines, ships' among them, and its unit.
_MASS, _LENGTH, _ARC = (1e-5, 20.0, "g"), (1e-4, 1.0, "mm"), (1e-4, 20.0, "mm")


@dataclass(frozen=True, slots=True)
class ContactParameters:
    """A contact law by its name and numbers (SI); ``values`` are keyword arguments of laws in
    `valvetrain.contact`.

    ``friction_coefficient`` (0: none) of regularised Coulomb friction, which creeps below
    ``friction_velocity`` (m/s). ``stiffness_exponent`` n of the N/m**n and ``damping_unit`` (``N
    s/m`` or ``s/m``) in which the values are given, so that another law can be named over them;
    None and empty: the units of the law named. ``origin``: where values come from that the case
    does not give.
    """

    law: str = "linear"
    values: Mapping[str, Any] = field(default_factory=FrozenMapping)
    friction_coefficient: float = 0.0
    friction_velocity: float = 0.01
    stiffness_exponent: float | None = None
    damping_unit: str = ""
    origin: str = ""

    def __post_init__(self) -> None:
        _not_negative(self, "contact", "friction_coefficient")
        _positive(self, "contact", "friction_velocity")
        object.__setattr__(self, "values", FrozenMapping(self.values))

    def replace(self, **changes: Any) -> ContactParameters:
        """A copy with another ``law`` or with ``values`` changed."""
        law = changes.pop("law", self.law)
        values = changes.pop("values", self.values)
        return replace(self, law=law, values={**values, **changes})


@dataclass(frozen=True, slots=True)
class CamParameters:
    """``base_radius`` and face ``width`` (m); ``rotation`` +1 counter-clockwise, -1 clockwise;
    elastic data for Hertz pressure (Pa).
    """

    base_radius: float
    width: float = 0.012
    rotation: int = 1
    youngs_modulus: float = 206e9
    poisson_ratio: float = 0.3

    def __post_init__(self) -> None:
        keep_si(self, "the cam", base_radius="length", width="length", youngs_modulus="pressure")
        _positive(self, "cam", "base_radius", "width", "youngs_modulus")
        warn_unusual(self, "the cam", base_radius=_LENGTH, width=_LENGTH)
        if self.rotation not in (1, -1):
            raise InputError(f"rotation of the cam must be 1 or -1; it is {self.rotation}")


@dataclass(frozen=True, slots=True)
class FollowerParameters:
    """What touches the cam: ``shape`` with its arc ``radius`` (m; 0 for flat and knife).

    ``mass`` (kg) of a sliding follower (tappet). ``offset`` (m): distance of its axis from the cam
    centre. ``tilt`` (rad): lean of a flat face, ``face_diameter`` (m; None: unknown) its size.
    ``friction`` (N) and ``damping`` (N s/m) act in its guide.
    """

    shape: FollowerShape = "flat"
    radius: float = 0.0
    mass: float = 0.0
    offset: float = 0.0
    tilt: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    face_diameter: float | None = None

    def __post_init__(self) -> None:
        keep_si(
            self, "the follower", radius="length", mass="moving_mass", offset="length", tilt="angle", damping="damping", friction="force",
            face_diameter="length",
        )  # fmt: skip
        if self.shape not in ("flat", "domed", "roller", "knife"):
            raise InputError(
                f"follower shape '{self.shape}' is unknown; use flat, domed, roller or knife"
            )
        if self.shape in ("domed", "roller") and not self.radius > 0:
            raise InputError(
                f"a {self.shape} follower needs a positive radius; it is {self.radius:g} m"
            )
        if self.shape in ("flat", "knife") and self.radius != 0:
            raise InputError(f"a {self.shape} follower has no radius; remove it or use a domed one")
        if not abs(self.tilt) < math.radians(30):
            raise InputError("the tilt of a flat follower must stay below 30 degrees")
        _not_negative(self, "follower", "mass", "damping", "friction")
        warn_unusual(self, "the follower", radius=_ARC, mass=_MASS)


@dataclass(frozen=True, slots=True)
class LeverParameters:
    """A finger follower or rocker turning about ``pivot`` (x, y in m from the cam centre).

    ``drive_arm`` (m): pivot to the centre of the cam pad's arc, or to the pushrod ball.
    ``drive_angle`` (rad): its polar direction when the valve is closed; None lets the base circle
    decide (cam-driven levers), ``drive_side`` +1 or -1 then picks one of the two solutions.
    ``valve_arm``, ``valve_angle``: pivot to the centre of the tip's arc. ``inertia`` (kg m2) about
    the pivot; ``mass`` (kg) that moves with the support. ``stiffness`` (N/m) at the valve tip, None
    for rigid; ``damping`` (N s/m) likewise. ``holding_torque`` (N m) of a hairpin spring presses
    the lever towards the cam or pushrod, so that it does not float in the lash. ``tip_radius`` (m)
    of the arc that touches the stem; only friction there needs it.
    """

    pivot: tuple[float, float]
    drive_arm: float
    valve_arm: float
    inertia: float
    valve_angle: float = 0.0
    drive_angle: float | None = None
    drive_side: int = 1
    mass: float = 0.0
    stiffness: float | None = None
    damping: float = 0.0
    holding_torque: float = 0.0
    tip_radius: float = 0.0

    def __post_init__(self) -> None:
        keep_si(
            self, "the lever", drive_arm="length", valve_arm="length", inertia="moment of inertia", valve_angle="angle", drive_angle="angle",
            mass="moving_mass", stiffness="stiffness", damping="damping", holding_torque="moment", tip_radius="length",
        )  # fmt: skip
        object.__setattr__(self, "pivot", si_each(self.pivot, "length", "pivot of the lever"))
        _positive(self, "lever", "drive_arm", "valve_arm", "inertia")
        _not_negative(self, "lever", "mass", "damping", "holding_torque", "tip_radius")
        if self.stiffness is not None:
            _positive(self, "lever", "stiffness")
        warn_unusual(self, "the lever", drive_arm=_LENGTH, valve_arm=_LENGTH, mass=_MASS)


@dataclass(frozen=True, slots=True)
class PushrodParameters:
    """``mass`` (kg); ``stiffness`` (N/m) of the bar, None for rigid; ``lower_end`` (x, y in m): its
    ball in the tappet at zero lift. ``length`` (m), None where not given, moves nothing: the motion
    has that between both balls; ``youngs_modulus`` (Pa) and ``density`` (kg/m3) judge mass and stiffness.
    """

    mass: float
    lower_end: tuple[float, float]
    stiffness: float | None = None
    damping: float = 0.0
    length: float | None = None
    youngs_modulus: float = 206e9
    density: float = 7850.0

    def __post_init__(self) -> None:
        keep_si(
            self, "the pushrod", mass="moving_mass", stiffness="stiffness", damping="damping", length="length", youngs_modulus="pressure",
            density="density",
        )  # fmt: skip
        lower = si_each(self.lower_end, "length", "lower_end of the pushrod")
        object.__setattr__(self, "lower_end", lower)
        _positive(self, "pushrod", "mass")
        _not_negative(self, "pushrod", "damping")
        _positive(self, "pushrod", "youngs_modulus", "density")
        for name in ("stiffness", "length"):
            if getattr(self, name) is not None:
                _positive(self, "pushrod", name)
        warn_unusual(self, "the pushrod", mass=_MASS)


@dataclass(frozen=True, slots=True)
class SupportParameters:
    """Elastic pivot or rocker shaft: ``stiffness`` (N/m) and ``damping`` (N s/m) along
    ``direction`` (polar angle, rad), moving ``mass`` (kg).
    """

    stiffness: float
    mass: float
    damping: float = 0.0
    direction: float = math.pi / 2

    def __post_init__(self) -> None:
        keep_si(
            self,
            "the support",
            stiffness="stiffness",
            mass="moving_mass",
            damping="damping",
            direction="angle",
        )
        _positive(self, "support", "stiffness", "mass")
        _not_negative(self, "support", "damping")


@dataclass(frozen=True, slots=True)
class ValveParameters:
    """``mass`` (kg) of valve, retainer and keepers; ``opening_direction`` polar angle (rad) of the
    opening motion.

    ``stem_stiffness`` (N/m), None for rigid, joins the head (``head_fraction`` of the mass) to the
    tip; ``damping`` (N s/m) and ``friction`` (N) act in the guide. ``permitted_seating_velocity``
    (m/s), None for the published one, is the limit for judging results; it changes no motion.
    """

    mass: float
    opening_direction: float = -math.pi / 2
    head_fraction: float = 0.5
    stem_stiffness: float | None = None
    stem_damping: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    permitted_seating_velocity: float | None = None

    def __post_init__(self) -> None:
        keep_si(
            self, "the valve", mass="moving_mass", opening_direction="angle", head_fraction="ratio", stem_stiffness="stiffness",
            stem_damping="damping", damping="damping", friction="force", permitted_seating_velocity="velocity",
        )  # fmt: skip
        _positive(self, "valve", "mass")
        _not_negative(self, "valve", "stem_damping", "damping", "friction")
        if not 0 < self.head_fraction < 1:
            raise InputError(
                f"head_fraction of the valve must be between 0 and 1; it is {self.head_fraction:g}"
            )
        if self.stem_stiffness is not None:
            _positive(self, "valve", "stem_stiffness")
        if self.permitted_seating_velocity is not None:
            _positive(self, "valve", "permitted_seating_velocity")
        warn_unusual(self, "the valve", mass=_MASS)


@dataclass(frozen=True, slots=True)
class GasLoad:
    """Force (N, opening positive) on the valve over the cam angle (rad), joined by monotone curves
    and periodic in one cam revolution.
    """

    cam_angles: tuple[float, ...]
    forces: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.cam_angles) != len(self.forces) or len(self.forces) < 3:
            raise InputError("a gas load needs at least three cam angles and as many forces")
        if any(b <= a for a, b in zip(self.cam_angles, self.cam_angles[1:], strict=False)):
            raise InputError(
                "the cam angles of a gas load must increase; sort them and remove repeats"
            )
        if self.cam_angles[-1] - self.cam_angles[0] >= 2 * math.pi:
            raise InputError(
                "a gas load spans less than one cam revolution; drop the repeated last point"
            )


@dataclass(frozen=True, slots=True)
class CrankParameters:
    """Crank slider on the 2:1 drive: ``radius`` (m, half the stroke), ``rod_length`` (m),
    ``top_dead_centre`` cam angle (rad) of gas exchange; None: by ``lobe_centre``, the crank angle
    (rad) from there to the middle of the nose, negative for an exhaust lobe.

    ``clearance`` (m): piston crown to the closed valve along the cylinder at top dead centre;
    ``valve_inclination`` (rad) of the valve axis to the cylinder axis.
    """

    radius: float
    rod_length: float
    clearance: float
    top_dead_centre: float | None = None
    valve_inclination: float = 0.0
    offset: float = 0.0
    lobe_centre: float | None = None

    def __post_init__(self) -> None:
        keep_si(
            self, "the crank", radius="length", rod_length="length", clearance="length", top_dead_centre="angle", valve_inclination="angle",
            offset="length", lobe_centre="angle",
        )  # fmt: skip
        _positive(self, "crank", "radius", "rod_length", "clearance")
        if self.top_dead_centre is None and self.lobe_centre is None:
            raise InputError(
                "the crank needs lobe_centre, crank degrees from top dead centre to the nose such as '106 deg' (before it, an exhaust lobe: "
                "'-110 deg'), or top_dead_centre in cam degrees; give one"
            )
        if self.rod_length <= self.radius + abs(self.offset):
            raise InputError(
                "the connecting rod must be longer than crank radius plus offset, or the crank cannot turn"
            )


@dataclass(frozen=True, slots=True)
class TrainVariant:
    """One of the runs that a case requests: what differs from the train itself.

    ``spring_set`` and ``spring_model``: words, empty for the train's own. ``lash`` (m),
    ``valve_damping`` (N s/m, a damper on the valve), ``without_preload``: springs at rest with the
    valve closed, as one source computed them. ``replica``: the name of what a source does and physics does not; such a
    run is made where the name is given as a spring set. ``note`` is printed next to the results.
    """

    label: str
    spring_set: str = ""
    spring_model: str = ""
    lash: float | None = None
    valve_damping: float | None = None
    without_preload: bool = False
    replica: str | None = None
    note: str = ""

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


@dataclass(frozen=True)
class TrainParameters:
    """One valvetrain. ``kind``: a name in the registry. ``model``: planar rigid bodies with the
    true cam profile, lumped masses with constant ratios, or a single mass.

    ``contacts``: law per place: ``cam``, ``valve_tip``, ``seat``, and for pushrods ``tappet`` and
    ``rocker``. ``springs``: sets of springs by name, each a tuple of one or two
    :class:`InstalledSpring` (outer first); ``spring_set`` is the one in use and ``spring_model``
    the name of its model, empty for :meth:`model_of` the set. ``rubbing``: friction between nested springs. ``variants``: the runs
    a case requests (none: one run of the train as given). ``gravity``: vector (m/s2). ``cycles``: most cam
    turns run until the motion repeats; None for the default number.
    """

    kind: str
    cam: CamParameters
    follower: FollowerParameters
    valve: ValveParameters
    contacts: Mapping[str, ContactParameters]
    springs: Mapping[str, tuple[InstalledSpring, ...]] = field(default_factory=FrozenMapping)
    spring_set: str = ""
    spring_model: str = ""
    rubbing: Rubbing = Rubbing()
    lever: LeverParameters | None = None
    pushrod: PushrodParameters | None = None
    support: SupportParameters | None = None
    crank: CrankParameters | None = None
    gas: GasLoad | None = None
    lash: float = 0.0
    gravity: tuple[float, float] = (0.0, -9.80665)
    model: TrainModel = "planar"
    variants: tuple[TrainVariant, ...] = ()
    cycles: int | None = None

    def __post_init__(self) -> None:
        for name in ("contacts", "springs"):
            object.__setattr__(self, name, FrozenMapping(getattr(self, name)))
        check_kind(self.kind)
        if self.model not in ("planar", "lumped", "single-mass"):
            raise InputError(
                f"train model '{self.model}' is unknown; use planar, lumped or single-mass"
            )
        if self.cycles is not None and not 1 <= self.cycles <= 10_000:
            raise InputError(
                f"cycles of the train must be a whole number from 1 to 10000; it is {self.cycles}"
            )
        parts = [one for group in self.springs.values() for one in group]
        if any("time_step" in one.options_of("finite-element") for one in parts):
            raise InputError(
                "a train chooses the time step of its springs; leave out time_step of finite-element"
            )
        if self.lash < 0:
            raise InputError(f"the lash must be zero or positive; it is {self.lash * 1e3:g} mm")
        if self.spring_set and self.spring_set not in self.springs:
            raise InputError(
                f"spring set '{self.spring_set}' is unknown; the case holds {', '.join(self.springs) or 'none'}"
            )

    def replace(self, **changes: Any) -> TrainParameters:
        """A copy with the named fields changed."""
        return replace(self, **changes)

    def model_of(self, spring_set: str = "") -> str:
        """Name of the spring model of a set: the given one, else modes where all its springs are
        cards, the reduced rod where all are wires, a chain of masses :meth:`why_chain` says why.
        """
        if self.spring_model:
            return self.spring_model
        springs = self._of(spring_set)
        if springs and all(spring.wire is None for spring in springs):
            return "modal-uniform"
        return "multi-mass" if self.why_chain(spring_set) or not springs else "reduced-rod"

    def why_chain(self, spring_set: str = "") -> str:
        """Why the reduced rod is not the model of a set in which one is a wire; empty where it is,
        where a model is given and where all are cards.
        """
        springs = self._of(spring_set)
        if self.spring_model or all(spring.wire is None for spring in springs):
            return ""
        rubbing = self.rubbing
        if len(springs) == 2 and rubbing.coefficient > 0 and rubbing.normal_force > 0:
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


def check_kind(kind: str) -> None:
    """Raise :class:`InputError` unless ``kind`` is a registered train kind; what the kind needs is
    checked where it is built.
    """
    known = registered_names("mechanisms")
    if kind not in known:
        raise InputError(f"train kind '{kind[:40]}' is unknown; {answer(kind, tuple(known))}")


def _positive(item: Any, noun: str, *names: str) -> None:
    for name in names:
        value = getattr(item, name)
        if not (math.isfinite(value) and value > 0):
            raise InputError(f"{name} of the {noun} must be positive; it is {value:g}")


def _not_negative(item: Any, noun: str, *names: str) -> None:
    for name in names:
        value = getattr(item, name)
        if not (math.isfinite(value) and value >= 0):
            raise InputError(f"{name} of the {noun} must not be negative; it is {value:g}")
