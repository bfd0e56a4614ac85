"""What the registry holds of a train kind: its contacts, the tables it needs, and the function that puts its parts together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from valvetrain.cam.contract import LiftLaw
from valvetrain.contact.law import ContactLaw
from valvetrain.errors import InputError
from valvetrain.mechanism.parts import AssembledMechanism
from valvetrain.parameters.train import TrainParameters

#: ``(train, lift law, contact law by place, what the lift is of)`` -> the planar mechanism.
MechanismBuilder = Callable[[TrainParameters, LiftLaw, dict[str, ContactLaw], str], AssembledMechanism]


@dataclass(frozen=True, slots=True)
class MechanismSpec:
    """One kind of train.

    ``places``: its contacts from cam to seat, each a key of [train.contacts] (``tappet`` is one only where the follower has a mass of
    its own). ``build(train, law, laws, lift_of)`` returns the planar mechanism. ``needs``: what must stand below [train], such as
    ``lever`` or ``follower.mass``.
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
                raise InputError(f"a {self.word} train needs a {table}; add its table", f"train.{table}")
            if key and not (value := getattr(part, key)) > 0:
                unit = " kg" if key == "mass" else ""
                raise InputError(f"the {table} of a {self.word} train needs a positive {key}; it is {value:g}{unit}", f"train.{need}")
