"""From train parameters to a mechanism, for every registered kind and every model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from valvetrain.cam.contract import LiftLaw
from valvetrain.contact.friction import CoulombFriction
from valvetrain.contact.law import ContactLaw
from valvetrain.contact.library import build_contact_law
from valvetrain.errors import InputError
from valvetrain.mechanism.lumped import build_lumped, build_single_mass
from valvetrain.mechanism.parts import AssembledMechanism, Interaction
from valvetrain.mechanism.sliding import SLIDING_KINDS
from valvetrain.parameters.train import TrainParameters
from valvetrain.registry import find

#: ``(train, lift law, contact law by place, what the lift is of)`` -> the planar mechanism.
MechanismBuilder = Callable[
    [TrainParameters, LiftLaw, dict[str, ContactLaw], str], AssembledMechanism
]


@dataclass(frozen=True, slots=True)
class MechanismSpec:
    """One kind of train.

    ``places``: its contacts from cam to seat, each a key of [train.contacts] (``tappet`` is one
    only where the follower has a mass of its own). ``build(train, law, laws, lift_of)`` returns the
    planar mechanism. ``needs``: tables required below [train], such as ``lever`` or
    ``follower.mass``.
    """

    word: str
    places: tuple[str, ...]
    build: MechanismBuilder
    needs: tuple[str, ...] = ()

    def check(self, train: TrainParameters) -> None:
        """Raise :class:`InputError` for a train that lacks what this kind needs."""
        for need in self.needs:
            table, _, key = need.partition(".")
            part = getattr(train, table)
            if part is None:
                raise InputError(
                    f"a {self.word} train needs a {table}; add its table", f"train.{table}"
                )
            if key and not (value := getattr(part, key)) > 0:
                unit = " kg" if key == "mass" else ""
                raise InputError(
                    f"the {table} of a {self.word} train needs a positive {key}; it is {value:g}{unit}",
                    f"train.{need}",
                )


def build_mechanism(
    train: TrainParameters, law: LiftLaw, lift_of: str = "tappet"
) -> AssembledMechanism:
    """Mechanism of a train under a lift law (``lift_of`` 'tappet' or 'valve'), in the model the
    train requests.

    Raises :class:`InputError` for missing parts, geometry that cannot work, lash larger than the
    lift, missing contact laws, or friction where nothing slides.
    """
    spec: MechanismSpec = find("mechanisms", train.kind, "train.kind")
    spec.check(train)
    places = [place for place in spec.places if place != "tappet" or train.follower.mass > 0]
    if missing := [place for place in places if place not in train.contacts]:
        tables, has = (
            ", ".join(f"[train.contacts.{place}]" for place in missing),
            ", ".join(train.contacts) or "none",
        )
        remedy = f"add {tables}, or contacts.others = 'steel'"
        raise InputError(
            f"a {train.kind} train needs a contact law for {_listed(missing)}, and has {has}; {remedy}",
            "train.contacts",
        )
    laws = {}
    for place in places:
        one = train.contact(place)
        units = {"stiffness_exponent": one.stiffness_exponent, "damping_unit": one.damping_unit}
        laws[place] = build_contact_law(one.law, **{**one.values, **units})
    planar = spec.build(train, law, laws, lift_of)
    if planar.cam is None:
        raise InputError(f"the mechanism of a {train.kind} train has no contact that follows a cam")
    rough = {
        place: friction
        for place in places
        if (friction := train.contact(place).friction_coefficient) > 0
    }
    if rough and train.model != "planar":
        raise InputError(
            f"friction in the contact '{next(iter(rough))}' needs model = 'planar': the {train.model} model keeps the gaps' normals "
            "only and knows no tangent to slide along; remove friction_coefficient or change the model"
        )
    if train.model == "lumped":
        return build_lumped(planar)
    if train.model == "single-mass":
        return build_single_mass(planar)
    return _with_friction(planar, train, rough) if rough else planar


def _listed(places: Sequence[str]) -> str:
    quoted = [f"'{place}'" for place in places]
    return f"{', '.join(quoted[:-1])} and {quoted[-1]}" if len(quoted) > 1 else quoted[0]


def _with_friction(
    planar: AssembledMechanism, train: TrainParameters, coefficients: Mapping[str, float]
) -> AssembledMechanism:
    """The mechanism with friction in the contacts named. Raises :class:`InputError` where nothing
    slides.
    """
    changed = {item.name: item for item in planar.interactions}
    for place, coefficient in coefficients.items():
        item = changed[place.replace("_", " ")]
        if item.kind not in SLIDING_KINDS or (place == "cam" and train.follower.shape == "roller"):
            reason = _why_not(place)
            raise InputError(
                f"the contact '{place}' of a {train.kind} train takes no friction: {reason}; remove friction_coefficient{_instead(changed, place)}"
            )
        changed[item.name] = replace(
            item, friction=CoulombFriction(coefficient, train.contact(place).friction_velocity)
        )
    return replace(planar, interactions=tuple(changed.values()))


def _instead(interactions: Mapping[str, Interaction], place: str) -> str:
    """Where a train slides whose cam does not."""
    tip = interactions.get("valve tip")
    slides = place == "cam" and tip is not None and tip.kind in SLIDING_KINDS
    return ", or give train.contacts.valve_tip.friction_coefficient" if slides else ""


def _why_not(place: str) -> str:
    if place == "cam":
        return "its follower is a roller, which rolls"
    if place in ("tappet", "rocker"):
        return "its partners meet in a ball, whose turning is not modelled"
    return "its partners move along one line, so nothing slides"
