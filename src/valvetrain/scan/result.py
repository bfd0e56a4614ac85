"""Results of a scan: curves over the coil number with their scatter, section, ends, and
the spring definition.
"""

from __future__ import annotations

from dataclasses import dataclass

from valvetrain.arrays import Array
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.scan.fit import FittedSpring
from valvetrain.solution.display import Reported


@dataclass(frozen=True, eq=False)
class ScanCurves:
    """Curves of a scanned spring over the ``coil`` number from the lower tip; SI, arrays (k,), each
    with its standard deviation.

    ``height``: of the wire axis above the lower seat plane; ``pitch``: its rise per turn.
    """

    coil: Array
    mean_diameter: Array
    mean_diameter_spread: Array
    height: Array
    height_spread: Array
    pitch: Array
    pitch_spread: Array
    centre_line: Array


@dataclass(frozen=True, eq=False)
class WireSection:
    """Section of the wire in the plane normal to it, SI.

    ``diameter``: of the equivalent round wire, with standard deviation; ``long_axis``,
    ``short_axis``: of the ellipse, equal for
    a round wire; ``inclination`` (rad) of the long axis from the radius; ``turns``: coil, mean
    diameter, its standard deviation and
    points of each turn (k, 4).
    """

    diameter: tuple[float, float]
    long_axis: tuple[float, float]
    short_axis: tuple[float, float]
    inclination: float
    turns: Array

    @property
    def ovate(self) -> bool:
        """Whether an ellipse fits better than a circle by more than chance."""
        return self.long_axis != self.short_axis


@dataclass(frozen=True, slots=True)
class Coverage:
    """How much of a spring a scan shows: ``around``, share of the way around the wire with points on it; ``sector`` (rad),
    the widest about the axis without points; ``hidden_tips``, the ends (lower, upper) whose tip is at its edge or in it.
    """

    around: float
    sector: float
    hidden_tips: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class ScannedSpring(Reported):
    """A spring out of a scan, made by :func:`spring_from_scan`; SI.

    ``definition``: the spring for a case; ``curves`` and ``section``: what was
    measured; ``total_coils`` and
    ``free_length`` with standard deviations; ``axis_point`` and ``axis_direction``: in the file's
    frame, towards the upper end; ``noise``:
    standard deviation of a point from the surface; ``points_read``,
    ``points_fitted``, ``points_on_wire``; ``coverage``: how much of the spring they show; ``shown``: some points in the
    file's frame (n, 3); ``notes``: what was left out or assumed, a few words each; ``fitted``: the tube behind it, and
    whether it is shown upside ``down``.

    >>> [name for name in ScannedSpring.__dataclass_fields__ if name in ("definition", "noise")]
    ['definition', 'noise']
    """

    source: str
    form: str
    unit: str
    definition: SpringDefinition
    curves: ScanCurves
    section: WireSection
    total_coils: tuple[float, float]
    free_length: tuple[float, float]
    axis_point: Array
    axis_direction: Array
    noise: float
    points_read: int
    points_fitted: int
    points_on_wire: int
    coverage: Coverage
    shown: Array
    notes: tuple[str, ...]
    fitted: FittedSpring
    down: bool

    @property
    def hand(self) -> str:
        """Right or left."""
        return self.definition.hand

    def __repr__(self) -> str:
        wire, turns = 1e3 * self.section.diameter[0], self.total_coils[0]
        shape = f"{self.definition.hand} hand, {turns:.2f} turns of {wire:.2f} mm wire, free length {1e3 * self.free_length[0]:.2f} mm"
        return f"ScannedSpring '{self.definition.name}': {shape}; noise {1e6 * self.noise:.0f} um"
