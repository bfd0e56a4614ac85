"""Stability of an equilibrium of the rod, and the last one on a path of which something holds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse.linalg import splu

from valvetrain.cosserat.state import RodState
from valvetrain.cosserat.static import RodStatics, compress

#: Width (m) of the bracket at which a bisection ends.
PLACE_TOLERANCE = 1e-8


def negative_modes(statics: RodStatics, state: RodState) -> int:
    """In how many independent ways an equilibrium with both ends fixed gives way without a push:
    negative eigenvalues of its tangent.

    Without exchange of rows the signs of the pivots are those of the eigenvalues (Sylvester's law
    of inertia).
    """
    inner = statics.tangent(state)[statics.free][:, statics.free].tocsc()
    factors = splu(
        inner, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    return int(np.count_nonzero(factors.U.diagonal() < 0.0))


def last_before(
    statics: RodStatics, start: RodState, compression: float, holds: Callable[[RodState], bool]
) -> RodState:
    """Last equilibrium from ``start`` to a ``compression`` (m) of which something ``holds`` that
    does not there, by bisection.
    """
    upper = compression
    while upper - start.compression > PLACE_TOLERANCE:
        middle = compress(statics, [0.5 * (start.compression + upper)], start)[-1]
        if middle.converged and holds(middle.state):
            start = middle.state
        else:
            upper = 0.5 * (start.compression + upper)
    return start
