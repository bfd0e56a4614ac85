"""Stress along one fibre of the wire surface, in axes that turn with the deformed wire."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.springs.solid.deck import MILLIMETRE
from valvetrain.springs.solid.fields import NodalField
from valvetrain.springs.solid.mesh import SolidMesh

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FibreStress:
    """Stress (Pa) along a fibre: ``shear`` between wire direction and circumference of the section,
    ``axial`` along the wire.

    ``coil`` (points,) coil numbers; ``equivalent`` after von Mises.
    """

    coil: Array
    shear: Array
    axial: Array
    equivalent: Array

    def mean_shear(self, first: float, last: float) -> float:
        """Mean of the shear (Pa) between two coil numbers; whole turns average out what varies once
        around.
        """
        if not self.coil[0] <= first < last <= self.coil[-1]:
            raise InputError(
                f"coils {first:g} to {last:g} are not within {self.coil[0]:g} to {self.coil[-1]:g}; choose a stretch inside"
            )
        fine = np.linspace(first, last, 2001)
        return float(np.trapezoid(np.interp(fine, self.coil, self.shear), fine) / (last - first))


def fibre_stress(
    mesh: SolidMesh, displacement: NodalField, stress: NodalField, x: float = -1.0, y: float = 0.0
) -> FibreStress:
    """Stress on the fibre nearest to section place (x, y) of the unit disc; (-1, 0) is the inner
    fibre, (1, 0) the outer.
    """
    from scipy.interpolate import CubicSpline

    nodes = mesh.fibre(x, y)
    coil = mesh.coil[nodes]
    moved = mesh.coordinates + np.nan_to_num(displacement.dense(len(mesh.coordinates))) / MILLIMETRE
    middle = _middle(mesh, moved, coil)
    # Direction of the wire, not of its fibre: the inner one climbs steeper, and would count a share
    # of the axial stress as shear.
    tangent = CubicSpline(coil, middle)(coil, 1)
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    across = moved[nodes] - middle
    across -= tangent * np.sum(across * tangent, axis=-1, keepdims=True)
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    around = np.cross(tangent, across)
    tensor = _tensor(stress.dense(len(mesh.coordinates))[nodes]) * 1e6
    shear = np.einsum("ni,nij,nj->n", tangent, tensor, around)
    axial = np.einsum("ni,nij,nj->n", tangent, tensor, tangent)
    deviator = tensor - np.eye(3) * np.trace(tensor, axis1=1, axis2=2)[:, None, None] / 3
    return FibreStress(
        coil, shear, axial, np.sqrt(1.5 * np.einsum("nij,nij->n", deviator, deviator))
    )


def wire_torque(spring: SpringDefinition, mesh: SolidMesh, coil: Array, reactions: Array) -> Array:
    """Torsional moment (N m) of the wire at ``coil`` from the printed nodal ``reactions`` (node, x,
    y, z in N) of the retainer.

    Equilibrium of the wire above the cut, in the free shape: for small compressions.
    """
    place = mesh.coordinates[reactions[:, 0].astype(int) - 1]
    centre = spring.centreline(coil)
    arms = place[None] - centre[:, None]
    moment = np.cross(arms, reactions[None, :, 1:4]).sum(axis=1)
    tangent = spring.centreline(coil + 1e-6) - spring.centreline(coil - 1e-6)
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    found: Array = np.sum(tangent * moment, axis=-1)
    return found


def _middle(mesh: SolidMesh, moved: Array, coil: Array) -> Array:
    """Middle of the section at every coil number: mean of four fibres a quarter turn of the section
    apart.
    """
    from scipy.interpolate import CubicSpline

    fibres = [mesh.fibre(*place) for place in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))]
    found: Array = np.mean(
        [CubicSpline(mesh.coil[nodes], moved[nodes])(coil) for nodes in fibres], axis=0
    )
    return found


def _tensor(components: Array) -> Array:
    """Tensors (n, 3, 3) from xx, yy, zz, xy, yz, zx."""
    xx, yy, zz, xy, yz, zx = components.T
    return np.stack(
        [np.stack([xx, xy, zx], -1), np.stack([xy, yy, yz], -1), np.stack([zx, yz, zz], -1)], -2
    )
