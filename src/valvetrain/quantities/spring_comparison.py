"""One spring at rest by several models: what each computed about the installed state, and how far they stand apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from valvetrain.solution.modal import ModalResult
from valvetrain.solution.static import SpringAtRest, StaticCurve

Array = NDArray[np.float64]

#: Modes are the same where shapes agree; a relative distance of the frequencies of this size weighs as much as a wholly other shape.
FREQUENCY_SCALE = 0.1
#: Modes whose shapes agree less are no pair.
LEAST_AGREEMENT = 0.25
#: Share of the way to the installed state at which forces are compared, besides the installed state and the end of the curve.
FORCE_PLACES = (0.25, 0.5, 0.75)


@dataclass(frozen=True, slots=True)
class Difference:
    """One quantity by every model that has it (SI, by model name); ``place`` is a compression (m) or a mode of the first model, from 1.

    ``shape_agreement`` (modal assurance, 0 to 1) by model, for modes.
    """

    quantity: str
    unit: str
    place: float
    values: Mapping[str, float]
    axial: int = 0
    shape_agreement: Mapping[str, float] = field(default_factory=dict)

    def relative(self, model: str, reference: str) -> float | None:
        """Share by which ``model`` stands above ``reference``; None where either is missing or the reference is zero."""
        one, other = self.values.get(model), self.values.get(reference)
        return None if one is None or not other else one / other - 1


def differences(members: Sequence[SpringAtRest], installed: float) -> tuple[Difference, ...]:
    """Forces and stiffness at compressions that the first member computed, then every mode of the first member beside the others'.

    ``installed``: precompression (m). The first member is the reference; members without curve or modes stand out of what needs them.
    """
    if not members:
        return ()
    return (*_static_differences(members, installed), *_modal_differences(members))


def _static_differences(members: Sequence[SpringAtRest], installed: float) -> list[Difference]:
    curves = {item.model: item.curve for item in members if item.curve is not None}
    if members[0].curve is None or len(members[0].curve.compression) < 4:
        return []
    at = members[0].curve.compression
    end = installed if 0 < installed <= at[-1] * (1 + 1e-9) else float(at[-1])
    chosen = [int(np.argmin(np.abs(at - share * end))) for share in FORCE_PLACES]
    places = sorted({*chosen, int(np.argmin(np.abs(at - end))), len(at) - 1} - {0})
    force = {model: curve_at(curve, at) for model, curve in curves.items()}
    rows = [Difference("force", "N", float(at[i]), {name: float(v[i]) for name, v in force.items() if np.isfinite(v[i])}) for i in places]
    # The same difference quotient for all, so that the steps of the curves do not enter.
    first, second = chosen[1], int(np.argmin(np.abs(at - end)))
    if at[second] > at[first]:
        secant = {name: float((v[second] - v[first]) / (at[second] - at[first])) for name, v in force.items()}
        rows.append(Difference("mean stiffness", "N/m", float(at[second]), {name: v for name, v in secant.items() if np.isfinite(v)}))
    return rows


def curve_at(curve: StaticCurve, compression: Array) -> Array:
    """Force (N) at compressions (m), nan beyond the curve."""
    inside = compression <= curve.compression[-1] * (1 + 1e-6) + 1e-12
    return np.where(inside, np.interp(compression, curve.compression, curve.force), np.nan)


def _modal_differences(members: Sequence[SpringAtRest]) -> list[Difference]:
    first, modes = members[0], members[0].modes
    if modes is None:
        return []
    others = {item.model: item.modes for item in members[1:] if item.modes is not None}
    partners = {model: match_modes(modes, theirs) for model, theirs in others.items()}
    rows = []
    for mode, natural_frequency in enumerate(modes.natural_frequency):
        values, agreement = {first.model: float(natural_frequency)}, {}
        for model, theirs in others.items():
            partner, share = partners[model].get(mode, (None, 0.0))
            if partner is not None:
                values[model], agreement[model] = float(theirs.natural_frequency[partner]), share
        axial = modes.axial_modes.index(mode) + 1 if mode in modes.axial_modes else 0
        rows.append(Difference("natural frequency", "Hz", mode + 1.0, values, axial, agreement))
    return rows


def match_modes(reference: ModalResult, other: ModalResult) -> dict[int, tuple[int, float]]:
    """Mode of ``reference`` -> (mode of ``other`` that is the same motion, modal assurance of their shapes along the wire).

    The pairing makes the sum of shape agreement less relative frequency distance largest; each mode is used once, and modes whose
    shapes do not agree (:data:`LEAST_AGREEMENT`) stay alone.
    """
    from scipy.optimize import linear_sum_assignment

    if not len(reference.natural_frequency) or not len(other.natural_frequency):
        return {}
    coil = reference.coil_number
    shape = np.stack([[np.interp(coil, other.coil_number, one[:, k]) for k in range(3)] for one in np.asarray(other.shape)])
    mine = np.moveaxis(np.asarray(reference.shape), 2, 1).reshape(len(reference.shape), -1)
    theirs = shape.reshape(len(shape), -1)
    size = np.sum(mine**2, axis=1)[:, None] * np.sum(theirs**2, axis=1)
    agreement = (mine @ theirs.T) ** 2 / np.where(size > 0, size, 1.0)
    distance = np.abs(np.log(np.asarray(other.natural_frequency)[None, :] / np.asarray(reference.natural_frequency)[:, None]))
    rows, columns = linear_sum_assignment(distance / FREQUENCY_SCALE - agreement)
    pairs = [(int(i), int(j), float(agreement[i, j])) for i, j in zip(rows, columns, strict=True)]
    return {i: (j, share) for i, j, share in pairs if share >= LEAST_AGREEMENT}
