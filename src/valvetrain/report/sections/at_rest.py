"""Springs at rest by every model: static curve with installed, open and bind marked, natural
frequencies and modes.
"""

from __future__ import annotations

import numpy as np

from valvetrain.solution.static import SpringAtRest
from valvetrain.solution.study import Study

#: Cam orders that are named with a mode, and share of its frequency that a figure shows about it.
MODE_ORDERS, ABOUT = (6, 12), 0.25
#: Names of the largest lift: of a spring alone, and of a train.
LIFTS = ("maximum_lift", "rigid_maximum_valve_lift")


def marked_compressions(study: Study, rest: SpringAtRest) -> dict[str, float]:
    """Compressions (m) of the installed state, at the largest lift and with all coils closed, those
    that are known.
    """
    found = {"installed": rest.precompression} if rest.precompression else {}
    if rest.curve is not None and rest.curve.buckling is not None:
        found["buckles"] = rest.curve.buckling.compression
    lifts = [
        float(np.max(run.channel("valve_lift")))
        for run in study.solutions
        if run.has("valve_lift") and len(run.time)
    ]
    own = study.still.get(f"{rest.spring}, {rest.model}")
    known = (
        [(key.name, value) for key, value in study.quantities.items()]
        if own is None
        else list(own.items())
    )
    lifts += [value for name, value in known if name in LIFTS]
    if lifts:
        found["full lift"] = rest.precompression + max(lifts)
    names = (f"{rest.spring}_coil_bind_lift", "coil_bind_lift")
    solid = next(
        (value for word in names for name, value in known if name == word and np.isfinite(value)),
        None,
    )
    return found if solid is None else found | {"solid": rest.precompression + solid}
