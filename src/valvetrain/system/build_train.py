"""From a case to an assembled train: lift law, mechanism, springs, gas."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.cam.build import build_lift_law
from valvetrain.errors import InputError
from valvetrain.mechanism.build import build_mechanism
from valvetrain.mechanism.contour import NODES, table_from_samples
from valvetrain.parameters.case import Case
from valvetrain.parameters.train import GasLoad, TrainParameters
from valvetrain.system.spring_choice import build_springs
from valvetrain.system.train_system import TrainSystem

Array = NDArray[np.float64]


def build_train(
    case: Case, *, spring_model: str | None = None, spring_set: str | None = None, train: TrainParameters | None = None, **options: Any
) -> TrainSystem:
    """The train of a case with one spring model. ``train`` replaces the case's own parameters; ``options`` go to the springs.

    Raises :class:`InputError` when the case holds no train or no lift law, and for everything the parts refuse.
    """
    parameters = train or case.train
    if parameters is None:
        raise InputError(f"case '{case.name}' holds no valvetrain; add a [train] table or choose another case")
    if case.lift_law is None:
        raise InputError(f"case '{case.name}' holds no lift law; add a [lift_law] table")
    mechanism = build_mechanism(parameters, build_lift_law(case.lift_law), case.lift_law.lift_of)
    springs = build_springs(parameters, spring_model, spring_set, **options)
    gas = None if parameters.gas is None else gas_table(parameters.gas)
    return TrainSystem(mechanism, springs, gas, case.name)


def gas_table(gas: GasLoad) -> Array:
    """(nodes, 3) periodic table of the gas force (N) over the cam angle."""
    return table_from_samples(np.asarray(gas.cam_angles), np.asarray(gas.forces), NODES)
