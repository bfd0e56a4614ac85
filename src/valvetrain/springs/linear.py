"""A spring between a fixed seat and its retainer as matrices about one state: inner motion first,
the retainer last.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from valvetrain.arrays import Array
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.springs import chain_statics
from valvetrain.springs.contract import SpringModel, SpringWithModes
from valvetrain.springs.equivalent import EquivalentSpring
from valvetrain.springs.modal_uniform import ModalUniform
from valvetrain.springs.multi_mass import MultiMassSpring

#: Modes of the uniform spring that represents models without matrices of their own.
MODES = 8


@dataclass(frozen=True, eq=False)
class SpringMatrices:
    """``masses`` (n + 1,) kg and ``stiffness`` (n + 1, n + 1) N/m of n inner unknowns and the
    retainer's displacement, which is last.
    """

    masses: Array
    stiffness: Array


def spring_matrices(
    model: SpringModel, installed: InstalledSpring | None, retainer_displacement: float
) -> SpringMatrices:
    """A spring about rest at ``retainer_displacement`` (m): a chain by its own masses with touching
    coils held together, one with modes of its own by its coordinates, a model without
    inner motion by its tangent, any other by the modes of the uniform spring of equal rate and mass."""
    if isinstance(model, MultiMassSpring):
        return _chain(model, retainer_displacement)
    if isinstance(model, ModalUniform):
        return _modal(model)
    if isinstance(model, SpringWithModes):
        masses = np.append(np.ones(model.unknowns), model.retainer_mass())
        return SpringMatrices(masses, model.stiffness(retainer_displacement))
    if model.unknowns and installed is not None:
        return _modal(ModalUniform(EquivalentSpring.from_installed(installed), MODES))
    tangent = model.tangent(model.initial_state(retainer_displacement), retainer_displacement)
    return SpringMatrices(np.array([model.retainer_mass()]), np.array([[tangent]]))


def _chain(model: MultiMassSpring, retainer_displacement: float) -> SpringMatrices:
    nodes = chain_statics.solve_static(model.layout, model.precompression + retainer_displacement)
    touching = chain_statics.contact_responses(model.layout, nodes).tangent
    stiffness = chain_statics.stiffness_matrix(model.layout, touching)[1:, 1:]
    return SpringMatrices(np.append(model.layout.masses, model.retainer_mass()), stiffness)


def _modal(model: ModalUniform) -> SpringMatrices:
    """Kinetic energy sum k_n / w_n^2 p'^2 / 2, elastic k x^2 / 2 + sum k_n (p - c_n x)^2 / 2."""
    each, shares, rate = model.modal_stiffness, model.shares, model.spring.rate
    stiffness = np.zeros((model.modes + 1, model.modes + 1))
    stiffness[:-1, :-1] = np.diag(each)
    stiffness[:-1, -1] = stiffness[-1, :-1] = -each * shares
    stiffness[-1, -1] = rate + each @ shares**2
    return SpringMatrices(
        np.append(each / model.circular_frequencies**2, model.retainer_mass()), stiffness
    )
