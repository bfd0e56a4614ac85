"""Natural frequencies and shapes of a whole train about one state of rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError
from valvetrain.solution.display import frame, table, words

if TYPE_CHECKING:
    import pandas

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TrainModes:
    """Undamped modes of a train with its springs about rest at ``cam_angle`` (rad) and ``valve_lift`` (m).

    ``natural_frequency`` (mode,) Hz, ascending; 0 of a body that an open contact leaves free. ``parts``: bodies of the train, then its
    springs. ``shape`` (mode, body): displacement (m) or turn (rad) of every body, the largest travel 1 where a turn counts by its radius
    of gyration; zero of a mode that only a spring moves in. ``energy_share`` (mode, part): share of each part in the kinetic energy.
    ``closed``, ``open``: contacts that press there, and those that do not and count for nothing.

    >>> import valvetrain as vt
    >>> found = vt.train_modes("tdi-pushrod", spring_models=["massless"], spring_sets=["stock"])[0]
    >>> isinstance(found, TrainModes), bool(found.natural_frequency[-1] > 1000)
    (True, True)
    """

    label: str
    state: str
    cam_angle: float
    valve_lift: float
    natural_frequency: Array
    bodies: tuple[str, ...]
    parts: tuple[str, ...]
    shape: Array
    energy_share: Array
    closed: tuple[str, ...] = ()
    open: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        modes = len(self.natural_frequency)
        for name, shape in {"shape": (modes, len(self.bodies)), "energy_share": (modes, len(self.parts))}.items():
            if np.shape(getattr(self, name)) != shape:
                raise InputError(f"{name} of the modes of a train must have shape {shape}; it has {np.shape(getattr(self, name))}")

    def moving(self, mode: int, least: float = 0.15) -> str:
        """Parts that carry ``least`` of the kinetic energy of a mode (from 0) or more, most first: ``valve 62 %, spring 30 %``."""
        shares = self.energy_share[mode]
        order = [place for place in np.argsort(-shares, kind="stable").tolist() if shares[place] >= least] or [int(np.argmax(shares))]
        return ", ".join(f"{self.parts[place]} {shares[place]:.0%}".replace("%", " %") for place in order)

    def __repr__(self) -> str:
        first = ", ".join(f"{one:.5g}" for one in self.natural_frequency[:6])
        more = ", ..." if len(self.natural_frequency) > 6 else ""
        return f"TrainModes of {self.label}, {self.state}, {words(self.valve_lift, 'm')} of lift\n  {first}{more} Hz"

    def _repr_html_(self) -> str:
        rows = [(str(place + 1), words(one, "Hz"), self.moving(place)) for place, one in enumerate(self.natural_frequency)]
        return table(repr(self), ("mode", "natural frequency", "moving"), rows)

    def to_pandas(self) -> pandas.DataFrame:
        """One row per mode: natural frequency (Hz), and the share of every part in the kinetic energy."""
        columns = {"mode": np.arange(1, len(self.natural_frequency) + 1), "natural_frequency": self.natural_frequency}
        columns |= {part: self.energy_share[:, place] for place, part in enumerate(self.parts)}
        return frame(columns, "mode", {"natural_frequency": "Hz"} | dict.fromkeys(self.parts, "1"))
