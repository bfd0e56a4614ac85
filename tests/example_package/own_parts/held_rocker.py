"""A pushrod train whose rocker a torsion spring turns away from the cam's side, between pivot and head."""

from __future__ import annotations

from dataclasses import replace

from valvetrain.mechanism.build import MechanismSpec
from valvetrain.mechanism.gap_kinds import LINEAR
from valvetrain.mechanism.parts import AssembledMechanism, ElasticLink, Interaction
from valvetrain.mechanism.pushrod import SPEC as PUSHROD

STIFFNESS = 20.0
"""Of the torsion spring (N m/rad), which is free with the valve closed."""


def build_held_rocker(*parts) -> AssembledMechanism:  # type: ignore[no-untyped-def]
    """The mechanism of a pushrod train with one more interaction: the spring joins the rocker to the
    ground, so it is no part that rigid theory takes for rigid; its gap is an angle.
    """
    plain = PUSHROD.build(*parts)
    spring = Interaction(
        "rocker spring", LINEAR, ("lever",), (0.0, 1.0), ElasticLink(STIFFNESS), unit="rad"
    )
    return replace(plain, interactions=(*plain.interactions, spring))


SPEC = MechanismSpec("held-rocker", PUSHROD.places, build_held_rocker, PUSHROD.needs)
