"""Natural frequencies and modes of a spring about a compressed state, and of a train."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from valvetrain.arrays import Array, Flags
from valvetrain.errors import InputError
from valvetrain.solution.display import Saveable, frame, table, value_text
from valvetrain.solution.status import COMPLETED, Status

if TYPE_CHECKING:
    import pandas


def check_shapes(result: object, noun: str, shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Raise :class:`InputError` where an array of a result has another shape than that in
    ``shapes``.
    """
    for name, shape in shapes.items():
        found = np.shape(getattr(result, name))
        if found != shape:
            raise InputError(f"{name} of {noun} must have shape {shape}; it has {found}")


@dataclass(frozen=True, eq=False)
class ModalResult(Saveable):
    """All modes found about the state at ``compression`` (m).

    ``natural_frequency`` (mode) Hz, ascending; ``shape`` (mode, wire_point, 3), largest component
    1, z along the spring; ``coil_number`` (wire_point); ``axial_transmission`` (mode):
    force-transmission residue, the share of an axial push at one end that a mode transmits to the
    other; ``axial_modes``: indices of the axial modes, ascending in frequency. ``attached_mass``
    (kg) moves along the axis with the retainer, 0 for a free end; None: both ends are fixed.

    >>> import numpy as np
    >>> result = ModalResult(8e-3, np.array([430.0, 610.0]), np.zeros((2, 5, 3)), np.linspace(0, 6, 5), np.array([0.9, 0.0]), (0,))
    >>> result.axial_frequencies.tolist()
    [430.0]
    """

    compression: float
    natural_frequency: Array
    shape: Array
    coil_number: Array
    axial_transmission: Array
    axial_modes: tuple[int, ...]
    status: Status = COMPLETED
    attached_mass: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "axial_modes", tuple(int(index) for index in self.axial_modes))
        modes, points = len(self.natural_frequency), len(self.coil_number)
        shapes = {"shape": (modes, points, 3), "axial_transmission": (modes,)}
        check_shapes(self, "a modal result", shapes)
        if any(not 0 <= index < modes for index in self.axial_modes):
            raise InputError(
                f"axial_modes of a modal result must be between 0 and {modes - 1}; they are {self.axial_modes}"
            )

    @property
    def axial_frequencies(self) -> Array:
        """Natural frequencies (Hz) of the axial modes, ascending."""
        return np.asarray(self.natural_frequency)[list(self.axial_modes)]

    def __repr__(self) -> str:
        first = ", ".join(f"{one:.5g}" for one in self.axial_frequencies[:6])
        more = ", ..." if len(self.axial_modes) > 6 else ""
        lines = [
            f"ModalResult at {value_text(self.compression, 'm')} compression, {len(self.shape)} modes, {self.status.sentence()}"
        ]
        return "\n  ".join(
            [*lines, f"{len(self.axial_modes)} axial: {first}{more} Hz"] if first else lines
        )

    def to_pandas(self) -> pandas.DataFrame:
        """One row per mode: natural frequency (Hz), axial transmission, whether it is axial."""
        numbers = np.arange(1, len(self.natural_frequency) + 1)
        columns = {
            "mode": numbers, "natural_frequency": self.natural_frequency, "axial_transmission": self.axial_transmission,
            "axial": np.isin(numbers - 1, self.axial_modes),
        }  # fmt: skip
        return frame(columns, "mode", {"natural_frequency": "Hz", "axial_transmission": "1"})


#: Share of a mode's kinetic energy along the axis from which it can be surge, and below which it is
#: lateral.
AXIAL, LATERAL = 1 / 2, 1 / 3


@dataclass(frozen=True, eq=False)
class SpringModes:
    """Natural modes of one spring as installed, both ends fixed, touching coils held together.

    ``natural_frequency`` (mode,) Hz, ascending; ``axial_share`` (mode,): share of the kinetic energy
    along the axis; ``surge``: whether the mode is one of the surge series, which carries force from
    end to end.

    >>> import numpy as np
    >>> modes = SpringModes(np.array([430.0, 610.0]), np.array([0.9, 0.1]), np.array([True, False]))
    >>> modes.kinds
    ('surge', 'lateral')
    """

    natural_frequency: Array
    axial_share: Array
    surge: Flags

    def __post_init__(self) -> None:
        count = (len(self.natural_frequency),)
        check_shapes(self, "the modes of a spring", {"axial_share": count, "surge": count})

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kind of each mode: ``surge`` (of that series, as far up as half of the energy or more is
        along the axis), ``lateral`` (less than a third along the axis) or ``coupled``.
        """
        weak = np.flatnonzero(self.surge & (self.axial_share < AXIAL))
        end = int(weak[0]) if len(weak) else len(self.surge)
        return tuple(
            "surge" if surge and place < end else "lateral" if share < LATERAL else "coupled"
            for place, (surge, share) in enumerate(zip(self.surge, self.axial_share, strict=True))
        )

    @property
    def surge_frequencies(self) -> Array:
        """Frequencies (Hz) of the modes of kind ``surge``, ascending."""
        chosen = [kind == "surge" for kind in self.kinds]
        return np.asarray(self.natural_frequency)[chosen]

    def __repr__(self) -> str:
        rows = zip(self.natural_frequency, self.kinds, self.axial_share, strict=True)
        lines = [f"{value:.5g} Hz, {kind}, {share:.0%} axial" for value, kind, share in rows]
        return "\n  ".join((f"SpringModes: {len(lines)} modes", *lines))

    def _repr_html_(self) -> str:
        rows = zip(self.natural_frequency, self.kinds, self.axial_share, strict=True)
        cells = [(value_text(value, "Hz"), kind, f"{share:.0%}") for value, kind, share in rows]
        return table(f"{len(cells)} modes", ("natural frequency", "kind", "axial share"), cells)

    def to_pandas(self) -> pandas.DataFrame:
        """One row per mode: natural frequency (Hz), kind, axial share."""
        columns = {
            "mode": np.arange(1, len(self.natural_frequency) + 1),
            "natural_frequency": self.natural_frequency,
            "kind": np.array(self.kinds),
            "axial_share": self.axial_share,
        }
        return frame(columns, "mode", {"natural_frequency": "Hz", "axial_share": "1"})


@dataclass(frozen=True, eq=False)
class TrainModes(Saveable):
    """Undamped modes of a train with its springs about equilibrium at ``cam_angle`` (rad) and
    ``valve_lift`` (m).

    ``natural_frequency`` (mode,) Hz, ascending; 0 of a body that an open contact leaves free.
    ``parts``: bodies of the train, then its springs. ``shape`` (mode, body): displacement (m) or
    rotation (rad) of every body, the largest travel 1 where a rotation counts by its radius of
    gyration; zero in a mode in which only a spring moves. ``energy_share`` (mode, part): share of
    each part in the kinetic energy. ``closed``, ``open``: contacts under load, and those without,
    which have no stiffness. ``closed_mode``, at full lift: the mode (from 0) of the closed valve that each continues
    from, followed by its shape; ``overlap``: squared cosine between the shapes where it is least on the way. A low one
    is a mode that changes as contacts open.

    >>> import valvetrain as vt
    >>> found = vt.runs.train_modes("tdi-pushrod", "massless", spring_sets="stock")[0]
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
    closed_mode: tuple[int, ...] = ()
    overlap: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        modes = len(self.natural_frequency)
        shapes = {"shape": (modes, len(self.bodies)), "energy_share": (modes, len(self.parts))}
        check_shapes(self, "the modes of a train", shapes)

    def lowest(self, count: int) -> TrainModes:
        """The same with the ``count`` lowest modes alone."""
        first = {
            name: getattr(self, name)[:count]
            for name in ("natural_frequency", "shape", "energy_share", "closed_mode", "overlap")
        }
        return replace(self, **first)

    def moving(self, mode: int, least: float = 0.15) -> str:
        """Parts with a share of ``least`` or more in the kinetic energy of a mode (from 0): ``valve
        62 %, spring 30 %``.
        """
        shares = self.energy_share[mode]
        order = np.argsort(-shares, kind="stable").tolist()
        largest = [part for part in order if shares[part] >= least] or [int(np.argmax(shares))]
        return ", ".join(f"{self.parts[part]} {100 * shares[part]:.0f} %" for part in largest)

    def __repr__(self) -> str:
        first = ", ".join(f"{one:.5g}" for one in self.natural_frequency[:6])
        more = ", ..." if len(self.natural_frequency) > 6 else ""
        return f"TrainModes of {self.label}, {self.state}, {value_text(self.valve_lift, 'm')} of lift\n  {first}{more} Hz"

    def to_pandas(self) -> pandas.DataFrame:
        """One row per mode: natural frequency (Hz), and the share of every part in the kinetic
        energy.
        """
        columns = {
            "mode": np.arange(1, len(self.natural_frequency) + 1),
            "natural_frequency": self.natural_frequency,
        }
        columns |= dict(zip(self.parts, self.energy_share.T, strict=True))
        return frame(columns, "mode", {"natural_frequency": "Hz"} | dict.fromkeys(self.parts, "1"))
