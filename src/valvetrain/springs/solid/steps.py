"""Load steps of the deck: static compression, natural frequencies, transient under a prescribed
lift.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from valvetrain.springs.solid.deck import MILLIMETRE

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Printout:
    """What every increment prints: end forces always; ``axis`` motion of the wire axis; ``pairs``
    number of contact pairs.

    ``energy``: totals of elastic and kinetic energy (a transient needs them from the first step
    on); ``fields``: displacement
    and stress at the nodes; ``nodal_reactions``: the reaction of every retainer node.
    """

    axis: bool = False
    pairs: int = 0
    fields: bool = False
    energy: bool = False
    nodal_reactions: bool = False

    def text(self) -> str:
        """The output requests of one step."""
        lines = [f"*NODE PRINT, NSET={name}, TOTALS=ONLY\nRF" for name in ("SEAT", "RETAINER")]
        if self.axis:
            lines.append("*NODE PRINT, NSET=AXIS\nU")
        lines += [
            f"*CONTACT PRINT, SLAVE=ABOVE{i}, MASTER=BELOW{i}\nCF" for i in range(1, self.pairs + 1)
        ]
        if self.energy:
            lines.append("*EL PRINT, ELSET=WIRE, TOTALS=ONLY\nELSE, ELKE")
        if self.nodal_reactions:
            lines.append("*NODE PRINT, NSET=RETAINER\nRF")
        if self.fields:
            lines.append("*NODE FILE\nU\n*EL FILE\nS")
        return "\n".join(lines)


def static_step(
    compression: float,
    printout: Printout,
    *,
    first: float,
    largest: float,
    smallest: float = 1e-5,
    period: float = 1.0,
    limit: int = 500,
) -> str:
    """Compression (m) reached in one step; ``first``, ``largest``, ``smallest`` increment as shares
    of the step.

    First equal to largest equal to smallest asks for fixed increments. ``period`` is the step's
    length in solver time (s).
    """
    one, most, least = (f"{share * period:.10g}" for share in (first, largest, smallest))
    fixed = first == largest == smallest
    times = (
        f"*STATIC, DIRECT\n{one}, {period:.10g}"
        if fixed
        else f"*STATIC\n{one}, {period:.10g}, {least}, {most}"
    )
    return (
        f"*STEP, NLGEOM, INC={limit}\n{times}\n*BOUNDARY\nSEAT, 1, 3\nRETAINER, 1, 2\n"
        f"RETAINER, 3, 3, {-compression * MILLIMETRE:.10g}\n{printout.text()}\n*END STEP\n"
    )


def frequency_step(modes: int, printout: Printout, *, preloaded: bool) -> str:
    """Lowest ``modes`` natural frequencies, about the state the last static step left when
    ``preloaded``.
    """
    perturbation = ", PERTURBATION" if preloaded else ""
    clamps = "" if preloaded else "*BOUNDARY\nSEAT, 1, 3\nRETAINER, 1, 3\n"
    return f"*STEP{perturbation}\n*FREQUENCY\n{modes}\n{clamps}{printout.text()}\n*END STEP\n"


def amplitude_text(name: str, time: Array, value: Array) -> str:
    """Table of values over step time, to be placed before the first step."""
    rows = "\n".join(f"{t:.9e}, {v:.9e}" for t, v in zip(time, value, strict=True))
    return f"*AMPLITUDE, NAME={name}\n{rows}\n"


def dynamic_step(
    duration: float, time_step: float, printout: Printout, *, amplitude: str, alpha: float = -0.05
) -> str:
    """Implicit transient (Hilber-Hughes-Taylor, ``alpha``) with the retainer's displacement (mm) in
    table ``amplitude``.
    """
    times = f"{time_step:.9e}, {duration:.9e}, {time_step / 1e3:.9e}, {time_step:.9e}"
    return (
        f"*STEP, NLGEOM, INC=100000\n*DYNAMIC, ALPHA={alpha:.4g}\n{times}\n"
        f"*BOUNDARY\nSEAT, 1, 3\nRETAINER, 1, 2\n*BOUNDARY, AMPLITUDE={amplitude}\nRETAINER, 3, 3, 1.\n{printout.text()}\n*END STEP\n"
    )
