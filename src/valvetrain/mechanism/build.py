"""From train parameters to a mechanism: one door for all kinds and models."""

from __future__ import annotations

from typing import Any

from valvetrain.contact.library import build_contact_law
from valvetrain.mechanism.direct import build_direct
from valvetrain.mechanism.lever import build_lever
from valvetrain.mechanism.lumped import build_lumped, build_single_mass
from valvetrain.mechanism.parts import AssembledMechanism
from valvetrain.mechanism.pushrod import build_pushrod
from valvetrain.parameters.train import TrainParameters

PLACES = {
    "direct": ("cam", "valve_tip", "seat"),
    "finger": ("cam", "valve_tip", "seat"),
    "rocker": ("cam", "valve_tip", "seat"),
    "pushrod": ("cam", "tappet", "rocker", "valve_tip", "seat"),
}


def build_mechanism(train: TrainParameters, law: Any, lift_of: str = "tappet") -> AssembledMechanism:
    """Mechanism of a train under a lift law (``lift_of`` 'tappet' or 'valve'), in the model the train asks for.

    Raises :class:`InputError` for geometry that cannot work, lash larger than the lift, or a missing contact law.
    """
    places = [place for place in PLACES[train.kind] if place != "tappet" or train.follower.mass > 0]
    laws = {place: build_contact_law(train.contact(place).law, **train.contact(place).values) for place in places}
    if train.kind == "direct":
        planar = build_direct(train, law, laws)
    elif train.kind == "pushrod":
        planar = build_pushrod(train, law, laws, lift_of)
    else:
        planar = build_lever(train, law, laws, lift_of)
    if train.model == "lumped":
        return build_lumped(planar)
    if train.model == "single-mass":
        return build_single_mass(planar)
    return planar
