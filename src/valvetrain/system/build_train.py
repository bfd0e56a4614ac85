"""From a case to an assembled train: lift law, mechanism, springs, gas."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.cam.build import build_lift_law
from valvetrain.errors import InputError
from valvetrain.mechanism.build import build_mechanism
from valvetrain.mechanism.contour import NODES, table_from_samples
from valvetrain.parameters.case import Case
from valvetrain.parameters.train import GasLoad, InstalledSpring, TrainParameters
from valvetrain.system.spring_choice import build_springs
from valvetrain.system.train_system import TrainSystem

Array = NDArray[np.float64]


def build_train(
    case: Case, *, spring_model: str | None = None, spring_set: str | None = None, train: TrainParameters | None = None, **options: Any
) -> TrainSystem:
    """The train of a case with one spring model. ``train`` replaces the case's own parameters; ``options`` go to the springs.

    Raises :class:`InputError` when the case holds no train or no lift law, for a spring that binds, and for everything the parts refuse.
    """
    parameters = train or case.train
    if parameters is None:
        raise InputError(f"case '{case.name}' holds no valvetrain; add a [train] table or choose another case")
    if case.lift_law is None:
        raise InputError(f"case '{case.name}' holds no lift law; add a [lift_law] table")
    mechanism = build_mechanism(parameters, build_lift_law(case.lift_law), case.lift_law.lift_of)
    check_room(parameters.spring_parts(spring_set), mechanism.kinematics.maximum_lift)
    springs = build_springs(parameters, spring_model, spring_set, **options)
    gas = None if parameters.gas is None else gas_table(parameters.gas)
    return TrainSystem(mechanism, springs, gas, case.name)


def check_room(parts: Sequence[Any], maximum_lift: float) -> None:
    """Raise :class:`InputError` for a spring that the rigid valve lift (m) would press beyond solid; cards tell it where they can."""
    for part in parts:
        solid = part.definition.solid_height if isinstance(part, InstalledSpring) else part.solid_height
        if solid is None or part.installed_height is None:
            continue
        open_height = part.installed_height - maximum_lift
        if open_height <= solid:
            raise InputError(
                f"spring '{part.name}' binds: {part.installed_height * 1e3:.4g} mm installed less {maximum_lift * 1e3:.4g} mm of lift "
                f"leave {open_height * 1e3:.4g} mm, but it is solid at {solid * 1e3:.4g} mm; install it higher, lift less or take out coils"
            )


def gas_table(gas: GasLoad) -> Array:
    """(nodes, 3) periodic table of the gas force (N) over the cam angle."""
    return table_from_samples(np.asarray(gas.cam_angles), np.asarray(gas.forces), NODES)
