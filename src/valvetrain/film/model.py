"""A film of a spring laid over the model: displacements of the same coil sections from a run at the
speed of the film.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.film.cycles import TURN, is_closed, mean_of, segments
from valvetrain.film.result import CoilMotion
from valvetrain.film.surge import SurgeFit, alias_of, fit_surge
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.loading import AnyCase, case_of
from valvetrain.quantities.cycle import reported_cycle
from valvetrain.runs.api import simulate
from valvetrain.solution.display import Shown
from valvetrain.solution.result import Solution
from valvetrain.springs.equivalent import EquivalentSpring, installed_gaps
from valvetrain.units import as_names

#: Steps (turns) in which the place of the first coil along the wire is looked for.
STEP = 0.02
#: How far (cam deg) the zero of a film may be off that comes from a lift alone.
SHIFTED = 8.0
#: Multiples of the first surge frequency that are compared with half the frame rate.
MULTIPLES = 5


@dataclass(frozen=True, eq=False)
class FilmedModel(Shown):
    """A run compared with a film; SI, displacements positive towards the seat from rest in the dwell.

    ``motion``: of the film; ``turns`` (coils,): coil numbers from the lower tip of the wire; ``quantities``: the names that
    these
    curves have in a run, such as outer_coil_2_60_displacement; ``shift`` (rad) by which the run's
    cam angle was moved to the film's;
    ``cam_angle`` (angles,) rad; ``displacement`` (angles, coils) m;
    ``peaks`` (coils,) m; ``apart`` (coils,) m, root mean square of the film's mean less the model;
    ``surge``: decay of the model as the
    same film would show it; ``surge_frequency`` (Hz) of the case's spring between fixed ends. Made
    by :func:`film_over_model`.

    >>> [name for name in FilmedModel.__dataclass_fields__ if name in ("turns", "peaks", "apart")]
    ['turns', 'peaks', 'apart']
    """

    motion: CoilMotion
    case: str
    model: str
    spring: str
    turns: Array
    quantities: tuple[str, ...]
    shift: float
    cam_angle: Array
    displacement: Array
    peaks: Array
    apart: Array
    surge: SurgeFit | None
    surge_frequency: float
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        peak = 1e3 * float(np.max(self.peaks, initial=0.0))
        return f"FilmedModel of {self.case} by {self.model}: {len(self.turns)} coils, largest peak {peak:.3f} mm"


def film_over_model(
    motion: CoilMotion,
    case: AnyCase,
    models: Sequence[str] | str = (),
    spring: str = "",
    first_turn: float | None = None,
) -> FilmedModel:
    """The case run at the cam speed of a film, and its coil sections compared with the film's.

    Parameters
    ----------
    motion : from :func:`coil_motion`, of a turning cam
    case : Case, name of a library case, or path of a case file
    models : name of the spring model; where empty the default of a spring alone, of a train
        finite elements or, of cards, the chain
    spring : name of the filmed spring; the first (outer) one where empty
    first_turn : coil number (turns from the lower tip) of the film's first coil; found by least
        squares of the motion where not given

    Returns
    -------
    FilmedModel

    Raises
    ------
    InputError : a free decay, a case that cannot be run, a model without displacements of the wire,
        an unknown spring

    Examples
    --------
    >>> film_over_model(None, "vaz-ohc")
    Traceback (most recent call last):
    valvetrain.errors.InputError: a film laid over a run needs the motion over the cam angle; give
    that of a turning cam
    """
    if motion is None or motion.phase is None or motion.dwell is None:
        raise InputError(
            "a film laid over a run needs the motion over the cam angle; give that of a turning cam"
        )
    chosen = case_of(case)
    run = _run(chosen, 2 * motion.phase.cam_speed, as_names(models))
    name = spring or run.springs[0]
    if name not in run.springs:
        raise InputError(
            f"spring '{name[:40]}' is unknown; the case has {', '.join(run.springs)}",
            "spring",
        )
    train = chosen.train
    parts = chosen.springs if train is None else train.spring_parts(run.spring_set or None)
    part = parts[run.springs.index(name)]
    angle, coil, moved = _moved(run, name, part)
    moved = moved[is_closed(angle, motion.dwell)].mean(axis=0) - moved
    grid = motion.cycles[0].cam_angle
    measured = np.stack([mean_of(cycles.values) for cycles in motion.cycles], axis=1)
    frame_rate, numbers = motion.seen.frame_rate, np.arange(motion.coils, dtype=float)

    def sections(at: Array, first: float, shift: float) -> Array:
        """Displacement of the filmed coils at cam angles (rad)."""
        columns = _at(moved, coil, first + numbers).T
        return np.stack([np.interp(at, angle + shift, part, period=TURN) for part in columns], axis=1)  # fmt: skip

    def misfit(first: float, shift: float) -> float:
        return float(np.nansum((measured - sections(grid, first, shift)) ** 2))

    # Least squares of the motion: neighbours on one side of the spring are one turn apart, and a zero
    # that follows from a lift alone may be off.
    first, shift, notes = first_turn or 0.0, 0.0, []
    firsts = np.arange(coil[0] - 1.0, coil[-1] - motion.coils + 2.0 + 1e-9, STEP).tolist()
    free_zero, reach = motion.phase.zero_by != "told", np.radians(SHIFTED)
    for _ in range(1 + free_zero):
        if first_turn is None:
            first = min(firsts, key=lambda turn: misfit(turn, shift))
        if free_zero:
            shift = float(minimize_scalar(lambda off: misfit(first, off), bounds=(-reach, reach), method="bounded").x)  # fmt: skip  # noqa: B023
    if first_turn is None:
        notes.append(
            f"coil 1 is turn {first:.2f} of the wire, where the run moves most as the film does; give the turn where it is known"
        )
    if free_zero:
        notes.append(
            f"the run was moved by {np.degrees(shift):+.2f} cam deg to move with the film, whose zero follows from the lift alone"
        )
    frequency = EquivalentSpring.from_installed(part).surge_frequency
    lines = frequency * np.arange(1, MULTIPLES + 1)
    high = [f"{line:.4g} Hz at {alias_of(line, frame_rate):.4g} Hz" for line in lines if line > 0.5 * frame_rate]  # fmt: skip
    if high:
        notes.append(
            f"surge lines of the case's spring above half the frame rate ({0.5 * frame_rate:g} Hz) are mirrored below it: {', '.join(high)}, as "
            "far as it is a uniform bar; a damping ratio found there is of the mirrored frequency"
        )
    prefix = f"{name}_" if len(run.springs) > 1 else ""
    names = [f"{prefix}coil_{turn:.2f}_displacement".replace(".", "_") for turn in first + numbers]
    displacement = sections(grid, first, shift)
    # The decay of the run at the frames of the film, so that frame rate and window do the same to both.
    frames = motion.phase.cam_angle
    closed = segments(frames, motion.seen.number, motion.dwell)
    return FilmedModel(
        motion,
        chosen.name,
        run.model,
        name,
        first + numbers,
        tuple(names),
        shift,
        grid,
        displacement,
        _at(moved, coil, first + numbers).max(axis=0),
        np.sqrt(np.nanmean((measured - displacement) ** 2, axis=0)),
        fit_surge(sections(frames, first, shift), closed, frame_rate),
        frequency,
        tuple(notes),
    )


def _run(case: Case, engine_speed: float, models: tuple[str, ...]) -> Solution:
    sets = tuple[str, ...]()
    if not models and case.train is not None:
        # the variants of a train may begin with springs that have no coils
        variants = case.train.springs.items()
        wires = [name for name, springs in variants if all(part.wire is not None for part in springs)]  # fmt: skip
        models, sets = ("finite-element",) if wires else ("multi-mass",), tuple(wires[:1])
    run = simulate(case, [engine_speed], models=models, spring_sets=sets).solutions[0]
    if not run.status.completed:
        raise InputError(
            f"case '{case.name}' did not run at the speed of the film: {run.status.message}",
            "case",
        )
    return run


def _moved(run: Solution, spring: str, part: InstalledSpring) -> tuple[Array, Array, Array]:
    """Cam angle (samples,), coil numbers (points,) and displacement (samples, points) of the
    reported cycle, seat to retainer positive.
    """
    channel = run.channel_of(spring, "axial_displacement")
    coil = run.arrays.along(channel) if run.has(channel) else None
    if coil is None:
        raise InputError(
            f"the model {run.model} has no displacement of coils; choose one such as multi-mass or finite-element",
            "models",
        )
    if np.max(coil) <= 1 + 1e-9:  # models of a uniform bar count the share of the compliance passed
        if part.wire is None:
            raise InputError(
                f"spring '{spring}' is a card without turns, so its coils are not known; give its wire",
                "case",
            )
        gaps = installed_gaps(part.wire, part.precompression)
        coil = np.interp(coil, gaps.flow, gaps.turns)
    cycle = reported_cycle(run)
    order = np.argsort(coil)
    return cycle.cam_angle, np.asarray(coil)[order], cycle.channel(channel)[:, order]


def _at(moved: Array, coil: Array, turns: Array) -> Array:
    """Displacements at coil numbers; beyond the free wire it rests on the seat or on the retainer
    and moves with it.
    """
    place = np.interp(turns, coil, np.arange(len(coil)))
    low = np.minimum(place.astype(int), len(coil) - 2)
    share = place - low
    return np.asarray(moved[:, low] * (1 - share) + moved[:, low + 1] * share)
