"""Where a rod under compression buckles: the tangent loses a sign, or the rate of the straight spring is lost.

A wound wire is never quite straight, so its path bends away before the critical point and no eigenvalue need pass zero: of a pitchfork
that an imperfection opens only the fall of the rate is left. Both are looked for; the place is bisected and so owes nothing to steps.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import splu

from valvetrain.cosserat.rates import axial_rate
from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import RodStatics, compress

#: A spring has buckled where its tangent rate is below this share of its rate as wound. Beyond an opened pitchfork a spring keeps a
#: tenth of its rate; two thirds of that fall are done at the critical point of the perfect column (decision 0049).
RATE_SHARE = 0.5
#: Width (m) of the bracket at which the bisection ends.
PLACE_TOLERANCE = 1e-8


@dataclass(frozen=True, slots=True)
class Stability:
    """Of one equilibrium: ``rate`` (N/m, tangent, retainer held sideways) and ``negative``, how many ways it gives way without a push."""

    rate: float
    negative: int

    def holds(self, free_rate: float) -> bool:
        """Whether the spring stands: no negative eigenvalue, and its rate above a share of that as wound (``free_rate``, N/m)."""
        return self.negative == 0 and self.rate > RATE_SHARE * free_rate


def stability(statics: RodStatics, state: RodState) -> Stability:
    """Tangent rate, and number of negative eigenvalues of the tangent, of an equilibrium with both ends fixed."""
    inner = statics.tangent(state)[statics.free][:, statics.free].tocsc()
    # Without exchange of rows the signs of the pivots are those of the eigenvalues (Sylvester's law of inertia).
    factors = splu(inner, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    return Stability(axial_rate(statics, state), int(np.count_nonzero(factors.U.diagonal() < 0.0)))


def last_before(statics: RodStatics, start: RodState, compression: float, holds: Callable[[RodState], bool]) -> RodState:
    """Last equilibrium from ``start`` to a ``compression`` (m) of which something ``holds`` that does not there, by bisection."""
    upper = compression
    while upper - start.compression > PLACE_TOLERANCE:
        middle = compress(statics, [0.5 * (start.compression + upper)], start)[-1]
        if middle.converged and holds(middle.state):
            start = middle.state
        else:
            upper = 0.5 * (start.compression + upper)
    return start
