"""Contacts of steel parts of typical size, for the contacts of a train that a case gives the name
``steel`` instead of a law.

Elastic parts by Hertz, for bodies of equal material, 1/E* = 2 (1 - nu^2) / E:

- line contact of length L (cam over its width, valve tip): F = K d^(10/9), K = E* L^(8/9) /
  1.36^(10/9) (Palmgren 1959);
- ball in a cup (both ends of a pushrod): F = K d^1.5, K = 4/3 E* sqrt(R), 1/R = 1/r_ball - 1/r_cup
  (Hertz; Johnson 1985, ch. 4);
- seat: the valve head bends like a simply supported plate under a load at its middle, F = K d,
  K = 16 pi (1 + nu) D / ((3 + nu) a^2), D = E t^3 / (12 (1 - nu^2)) (Timoshenko and
  Woinowsky-Krieger 1959, art. 19).

All lose energy by Hunt and Crossley's law with the restitution of steel on steel at the reference
velocity of contact tables.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from valvetrain import registry
from valvetrain.parameters.schema_contact import RESTITUTION, STEEL, ContactParameters
from valvetrain.parameters.schema_types import guarded, problem
from valvetrain.parameters.train_parts import CamParameters

#: Length (m) of the line along which a rocker, finger or bucket touches the tip of a stem of 8 mm.
TIP_LENGTH = 7e-3
#: Ball of a pushrod's end, 5/16 in across, and its cup, which is 5 % larger (m).
BALL_RADIUS, CUP_RADIUS = 0.15625 * 25.4e-3, 1.05 * 0.15625 * 25.4e-3
#: Radius at the seat and thickness of a valve head (m).
HEAD_RADIUS, HEAD_THICKNESS = 20e-3, 5e-3
ORIGIN = "default steel values"


def steel_contact(place: str, cam: CamParameters) -> ContactParameters:
    """The contact at ``place`` (cam, tappet, rocker, valve_tip or seat) between steel parts; the
    cam gives width and elastic data.

    Raises a located problem for a contact of which no typical size is known.
    """
    young, poisson = cam.youngs_modulus, cam.poisson_ratio
    reduced = young / (2 * (1 - poisson**2))
    if place in ("cam", "valve_tip"):
        length = cam.width if place == "cam" else TIP_LENGTH
        stiffness, exponent = reduced * length ** (8 / 9) / 1.36 ** (10 / 9), 10 / 9
    elif place in ("tappet", "rocker"):
        stiffness, exponent = (
            4 / 3 * reduced * math.sqrt(1 / (1 / BALL_RADIUS - 1 / CUP_RADIUS)),
            1.5,
        )
    elif place == "seat":
        bending = young * HEAD_THICKNESS**3 / (12 * (1 - poisson**2))
        stiffness, exponent = (
            16 * math.pi * (1 + poisson) * bending / ((3 + poisson) * HEAD_RADIUS**2),
            1.0,
        )
    else:
        raise problem(
            f"no typical contact of steel parts is known at '{place}'; give its law and values",
            (place,),
        )
    values = {"contact_stiffness": stiffness, "exponent": exponent, "restitution": RESTITUTION}
    return ContactParameters("hunt-crossley", values, origin=ORIGIN)


def with_steel(
    contacts: Mapping[str, ContactParameters], kind: str, cam: CamParameters
) -> dict[str, ContactParameters]:
    """``contacts`` by place with values for the word ``steel``; under '' it applies to the contacts
    of the train ``kind`` not named.
    """
    every = {place: contact for place, contact in contacts.items() if place}
    if "" in contacts:
        places: tuple[str, ...] = guarded(registry.find, "mechanisms", kind, path=()).places
        every |= {place: contacts[""] for place in places if place not in every}
    return {place: _valued(place, contact, cam) for place, contact in every.items()}


def _valued(place: str, contact: ContactParameters, cam: CamParameters) -> ContactParameters:
    if contact.law != STEEL:
        return contact
    made = steel_contact(place, cam)
    return replace(
        made,
        friction_coefficient=contact.friction_coefficient,
        friction_velocity=contact.friction_velocity,
    )


def default_contacts(contacts: Mapping[str, ContactParameters]) -> dict[str, float | str]:
    """``places`` (``cam, valve_tip``) and ``restitution`` of the contacts that use default steel values, for
    their case gives none; empty without any.
    """
    places = [place for place, contact in contacts.items() if contact.origin == ORIGIN]
    return {"places": ", ".join(places), "restitution": RESTITUTION} if places else {}
