"""A scanned spring compared with its design: the same analyses of both, side by side."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.loading import AnyCase, case_of
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.winding import EndCoil
from valvetrain.quantities.statics import design_quantities
from valvetrain.runs.requests import Modes
from valvetrain.runs.static_study import static_study
from valvetrain.scan.reconstruct import turned_over
from valvetrain.scan.result import ScannedSpring
from valvetrain.solution.display import Shown
from valvetrain.solution.study import Study

#: Natural frequencies that are searched, and axial ones that are compared.
MODES, AXIAL = 24, 3
#: Share by which the frequency of a mode may differ from the design's.
ALIKE = 0.15
#: How notes begin on what a scan alone assumes and a design gives.
ASSUMED = ("material", "ground turns")
#: Quantities of springs at rest that are compared, in this order.
AT_REST = (
    "preload", "installed_rate", "free_length", "installed_height", "coil_bind_lift", "solid_height", "active_coil_count",
    "estimated_surge_frequency",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class ComparedNumber:
    """One quantity at rest of the design and of the scanned spring, SI."""

    quantity: str
    design: float
    scanned: float

    @property
    def difference(self) -> float:
        """Scan less design as a share of the design; nan where the design has nothing."""
        return self.scanned / self.design - 1 if self.design else math.nan


@dataclass(frozen=True, eq=False)
class ScanComparison(Shown):
    """A scanned spring compared with its design.

    ``scan``: the same end up as the design; ``cases`` and ``rest``: design first, then scanned;
    ``numbers``: what both have.

    >>> ComparedNumber("preload", design=288.9, scanned=288.6).scanned
    288.6
    """

    scan: ScannedSpring
    cases: tuple[Case, Case]
    rest: tuple[Study, Study]
    numbers: tuple[ComparedNumber, ...]

    @property
    def failures(self) -> tuple[str, ...]:
        """A sentence per analysis that did not complete."""
        studies = zip(("design", "scan"), self.rest, strict=True)
        return tuple(
            f"{word}: {sentence}" for word, study in studies for sentence in study.failures
        )

    def number(self, quantity: str) -> ComparedNumber:
        """The one of ``quantity``. Raises :class:`InputError` where it is not compared."""
        for number in self.numbers:
            if number.quantity == quantity:
                return number
        raise InputError(f"no value of '{quantity[:60]}' is compared")

    def __repr__(self) -> str:
        return f"ScanComparison of '{self.scan.source}' with '{self.cases[0].name}': {len(self.numbers)} quantities of both"


def compare_scan(scan: ScannedSpring, design: AnyCase) -> ScanComparison:
    """The analyses at rest of a design with its own spring and with the scanned one: static curve and
    natural frequencies.

    The scanned spring takes material, damping, contacts, seats and options of the design's, and
    is at the same height between the
    seats; its inactive turns reach as far beyond the ground ones as the design's do. It is turned
    over where the design requires it.

    Parameters
    ----------
    scan : what :func:`spring_from_scan` found
    design : Case, name or path of a case with one spring known by its wire

    Returns
    -------
    ScanComparison

    Raises
    ------
    InputError : a design without a wire or with two springs, a scanned spring that is too short for
        the installed height

    Examples
    --------
    >>> import valvetrain as vt
    >>> import pathlib, tempfile
    >>> import numpy as np
    >>> draw = np.random.default_rng(1)
    >>> turn, around = draw.uniform(0, 6, 4000), draw.uniform(0, 6.2832, 4000)  # the spring of job-t: 4 mm, 24 mm, 7.5 mm per turn
    >>> radius = 12 + 2 * np.cos(around)
    >>> spring = np.column_stack([radius * np.cos(6.2832 * turn), radius * np.sin(6.2832 * turn), 7.5 * turn + 2 * np.sin(around)])
    >>> file = pathlib.Path(tempfile.mkdtemp(), "scan.xyz")
    >>> np.savetxt(file, spring + draw.normal(0, 0.03, spring.shape), fmt="%.4f")
    >>> coarse = {"spring.options.finite-element.elements_per_coil": 8}
    >>> compared = compare_scan(vt.scan.spring_from_scan(file, unit="mm"), vt.Case("job-t").set(coarse).parameters)
    >>> preload = compared.number("preload")
    >>> bool(abs(preload.scanned / preload.design - 1) < 0.02)
    True
    """
    case = replace(case_of(design), published=())
    installed = design_spring(case)
    assert installed.wire is not None
    drawn = installed.wire
    upright = min((scan, turned_over(scan)), key=lambda way: _apart(way.definition, drawn))
    title = f"{case.title or case.name}, as scanned"
    scanned = replace(case, springs=(as_installed(upright, installed),), title=title)
    cases = case, scanned
    rest = [static_study(Modes(case=part, count=MODES, implausible=True)) for part in cases]
    numbers = _at_rest(cases, rest)
    notes = [note for note in upright.notes if not note.startswith(ASSUMED)]
    notes.append(f"material, damping, contacts and inactive turns of the design '{case.name}'")
    upright = replace(upright, notes=tuple(notes))
    return ScanComparison(upright, cases, (rest[0], rest[1]), tuple(numbers))


def design_spring(case: Case) -> InstalledSpring:
    """The one spring of a design, known by its wire; raises :class:`InputError` for any other case."""
    case.require_spring()
    if len(case.springs) != 1:
        raise InputError(
            f"design '{case.name}' has {len(case.springs)} springs; give a case with the one that was scanned",
            "--design",
        )
    return case.springs[0]


def _apart(wire: SpringDefinition, design: SpringDefinition) -> float:
    """How far mean diameter and pitch are from those of the design."""
    share = np.linspace(0.05, 0.95, 200)
    width, pitch = (
        np.subtract(*(getattr(spring, law).value(share * spring.total_coils) for spring in (wire, design)))
        for law in ("mean_diameter", "pitch")
    )  # fmt: skip
    return float(np.mean(width**2 + pitch**2))


def as_installed(scan: ScannedSpring, design: InstalledSpring) -> InstalledSpring:
    """The scanned wire in the place of the design's. Raises :class:`InputError` where it is too
    short for the installed height.
    """
    wire, height = design.wire, design.installed_height
    assert wire is not None and height is not None
    compression = scan.free_length[0] - height
    if compression < -1e-6:
        raise InputError(
            f"the scanned spring is {1e3 * scan.free_length[0]:.2f} mm long, shorter than the {1e3 * height:.2f} mm between the seats of "
            "the design; check the unit of the scan or give another design",
            "--design",
        )
    made = scan.definition
    ends = {}
    for place in ("lower_end", "upper_end"):
        end, other = getattr(made, place), getattr(wire, place)
        beyond = other.inactive_coils - (other.ground_coils if "ground" in end.kind else 0.0)
        inactive = beyond + (end.ground_coils if "ground" in end.kind else 0.0)
        ends[place] = EndCoil(end.kind, float(np.clip(inactive, 0.0, 3.0)), end.ground_coils)
    made = made.replace(material=wire.material, name=wire.name, **ends)
    return replace(design, wire=made, precompression=max(compression, 0.0))


def _at_rest(cases: tuple[Case, Case], studies: list[Study]) -> list[ComparedNumber]:
    """Quantities at rest that both have, and their lowest axial modes."""
    design, scanned = (
        design_quantities(case.springs[0]) | dict(study.still.get("", {}))
        for case, study in zip(cases, studies, strict=True)
    )
    compared = [ComparedNumber(name, design[name], scanned[name]) for name in AT_REST if name in design and name in scanned]  # fmt: skip
    modes, other = (study.rest[0].modes for study in studies)
    if modes is None or other is None:
        return compared
    for place, frequency in enumerate(modes.axial_frequencies[:AXIAL].tolist(), 1):
        # Of the modes near a frequency the one that carries most of a push from end to end; which is
        # called axial is a threshold.
        near = np.flatnonzero(np.abs(other.natural_frequency / frequency - 1) < ALIKE)
        if len(near):
            same = near[np.argmax(np.abs(other.axial_transmission[near]))]
            value = float(other.natural_frequency[same])
            compared.append(ComparedNumber(f"mode_{place}_frequency", frequency, value))
    return compared
