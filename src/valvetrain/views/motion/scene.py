"""Builds the moving picture of a study: parts, frames, forces and marks of every run that can be
drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from valvetrain.arrays import Array
from valvetrain.errors import InputError
from valvetrain.findings.words import speed_text
from valvetrain.parameters.loading import parse_case
from valvetrain.quantities.cycle import Cycle, is_closed, reported_cycle
from valvetrain.solution.provenance import CaseRecord
from valvetrain.solution.result import Solution
from valvetrain.solution.status import reason
from valvetrain.solution.study import Study
from valvetrain.system.build import build
from valvetrain.system.problem import Member, Problem
from valvetrain.views.motion.parts import Moving, Places, Series, SpringDrawing, Variant, marks_of
from valvetrain.views.motion.springs import draw_spring, one_range
from valvetrain.views.motion.train import TrainDrawing, draw_train

#: Even steps (cam degrees) tried in turn until they take no more than :data:`EVEN_SHARE` of the
#: frames;
#: beyond the last, as many as that share allows.
STEPS = (0.25, 0.5, 1.0, 2.0)
EVEN_SHARE = 0.8


def choose_frames(
    cam_angle: Array, most: int, keep: Sequence[int] = (), spans: Sequence[tuple[float, float]] = ()
) -> Places:
    """Samples to draw, ascending: all where ``most`` allows.

    Parameters
    ----------
    cam_angle : (sample,) rad, ascending from 0 to less than one turn
    most : largest number of frames; required frames may exceed it
    keep : samples that are always drawn, such as those of peaks
    spans : first and last cam angle (rad) of clashes, most important first; every sample inside one is
        drawn until ``most`` is reached

    Returns
    -------
    Places (frame,) of the samples

    Examples
    --------
    >>> import numpy as np
    >>> turn = np.radians(np.arange(0, 360, 0.5))
    >>> chosen = choose_frames(turn, 300, keep=[347], spans=[(np.radians(100), np.radians(101))])
    >>> 347 in chosen, {200, 201, 202} <= set(chosen.tolist()), len(chosen) <= 300
    (True, True, True)
    """
    count = len(cam_angle)
    if count <= most:
        return np.arange(count)
    chosen = {0, count - 1, *(int(place) for place in keep)}
    chosen |= set(_even(cam_angle, max(1, int(EVEN_SHARE * most))).tolist())
    for first, last in spans:
        inside = np.flatnonzero((cam_angle >= first - 1e-9) & (cam_angle <= last + 1e-9)).tolist()
        room = most - len(chosen)
        if room <= 0:
            break
        new = [place for place in inside if place not in chosen]
        chosen |= set(new if len(new) <= room else new[:: -(-len(new) // room)])
    return np.array(sorted(chosen), dtype=np.int64)


def _even(cam_angle: Array, most: int) -> Places:
    """Samples next to even steps of the cam, no more than ``most``."""
    degrees = np.degrees(cam_angle)
    for step in STEPS:
        angles = np.arange(0.0, 360.0, step)
        if len(angles) <= most:
            break
    else:
        angles = np.linspace(0.0, 360.0, most, endpoint=False)
    right = np.clip(np.searchsorted(degrees, angles), 1, len(degrees) - 1)
    nearer = np.where(angles - degrees[right - 1] <= degrees[right] - angles, right - 1, right)
    return np.unique(nearer)


_TURN = 2 * np.pi
#: Runs in one picture, frames of one run, bytes of what moves in one run and in a whole picture,
#: before they are written as text.
MAX_VARIANTS, MAX_FRAMES, MAX_RUN_BYTES, MAX_BYTES = 4, 1000, 500_000, 1_000_000
MIN_FRAMES = 120
#: Clashes around which frames are closer in time, most important first.
MAX_SPANS = 60
#: Forces next to the picture: words, channel, colour; the first that a run has of each line, three
#: at most.
_FORCES = (
    ("spring on retainer", "retainer_force"),
    ("spring on seat", "seat_force"),
    ("cam contact", "cam_contact_force"),
)
#: Readable on light and on dark paper.
_FORCE_COLOURS = ("#3f7fd6", "#d9772b", "#9b6bc4")


def moving_picture(
    study: Study, frames: int = MAX_FRAMES, worst: Solution | None = None
) -> Moving | None:
    """The moving picture of a study, from its solutions and the parts of its case.

    Parameters
    ----------
    study : what ``simulate`` or ``compare`` gave; runs without channels are left out
    frames : largest number of frames of a run
    worst : run that is drawn whatever others know of their coils, and first; None for no such run

    Returns
    -------
    The picture, or None where no run has a motion or the case cannot be built again

    Raises
    ------
    InputError : spring models of a run that the case does not know

    Examples
    --------
    >>> import valvetrain as vt
    >>> picture = moving_picture(vt.simulate("job-t", "2000 rpm", models=["multi-mass"]))
    >>> [variant.label for variant in picture.variants], len(picture.variants[0].springs)
    (['multi-mass'], 1)
    """
    runs = [run for run in study.solutions if run.has("valve_lift") and len(run.time) > 2]
    if study.over_speed or not runs or not study.record.text:
        return None
    drawn = ("_shear_stress", "coil_gap", "axial_displacement")
    # where there are too many: the worst, those with most coils known, then the fastest
    ranked = sorted(
        runs,
        key=lambda run: (
            run is worst,
            sum(any(str(name).endswith(end) for name in run.arrays.variables) for end in drawn),
            run.engine_speed,
        ),
        reverse=True,
    )
    chosen = [run for run in runs if any(run is one for one in ranked[:MAX_VARIANTS])]
    try:
        _problem(study.record, (), ())
    except InputError:  # words of a case that holds no parts
        return None
    share = min(MAX_RUN_BYTES, MAX_BYTES // len(chosen))
    variants, failed = [], []
    for run in chosen:
        try:
            found = _variant(study, run, share, frames)
            variants += [found] if found is not None else []
        except Exception as error:  # one run must not cost the others
            failed.append((run, error))
    if not variants:
        if failed:
            raise failed[0][1]
        return None
    if worst is not None:
        variants.sort(
            key=lambda one: (
                one.engine_speed != worst.engine_speed,
                -sum(len(spring.colourings) for spring in one.springs),
                one.label != worst.label,
            )
        )
    notes = [
        f"{run.label} at {speed_text(run.engine_speed)} could not be drawn: {reason(error)}"
        for run, error in failed
    ]
    if len(chosen) < len(runs):
        notes.append(f"{len(chosen)} of {len(runs)} runs are drawn; to see another, run it alone")
    title = (
        "Train and spring over the cam revolution"
        if any(one.bodies for one in variants)
        else "Spring over the cam revolution"
    )
    return Moving(title, one_range(tuple(variants)), tuple(notes))


@lru_cache(maxsize=4)
def _problem(record: CaseRecord, models: tuple[str, ...], sets: tuple[str, ...]) -> Problem:
    return build(parse_case(record.text, record.name), spring_models=models, spring_set=sets)


def member_of(record: CaseRecord, run: Solution) -> Member | None:
    """The variant of the case behind a run: springs, lift law and parts of its train; None where
    the case has none.

    Raises :class:`InputError` where the case cannot be built.
    """
    for models, sets in (((), ()), ((run.model,), (run.spring_set,) if run.spring_set else ())):
        members = _problem(record, models, sets).members
        found = next(
            (one for one in members if one.label == run.label and one.spring_set == run.spring_set),
            None,
        )
        found = found or next(
            (
                one
                for one in members
                if one.model.word == run.model and one.spring_set == run.spring_set
            ),
            None,
        )
        if found is not None:
            return found
    return None


def _variant(study: Study, run: Solution, size: int, most: int) -> Variant | None:
    member = member_of(study.record, run)
    if member is None:
        return None
    cycle = reported_cycle(run)
    if len(cycle.cam_angle) < 3:
        return None
    marks = marks_of(run, cycle)
    sample = choose_frames(
        cycle.cam_angle,
        min(most, max(MIN_FRAMES, size // _bytes_per_frame(run, member))),
        _peaks(run, cycle),
        _spans(run),
    )
    train = None if member.gear is None else draw_train(member, cycle, sample)
    springs, notes = _springs(study, member, run, cycle, sample, train)
    if not springs and train is None:
        return None
    known = [(label, name) for label, name in _FORCES if run.has(name)]
    return Variant(
        run.label,
        f"{run.label}, {speed_text(run.engine_speed)}",
        run.engine_speed,
        sample,
        cycle.cam_angle[sample],
        cycle.channel("valve_lift")[sample],
        springs,
        train.bodies if train else (),
        tuple(
            Series(label, colour, cycle.cam_angle, cycle.channel(name))
            for (label, name), colour in zip(known, _FORCE_COLOURS, strict=False)
        ),
        marks,
        (*notes, *(train.notes if train else ())),
        is_closed(run),
    )


def _springs(
    study: Study,
    member: Member,
    run: Solution,
    cycle: Cycle,
    sample: Places,
    train: TrainDrawing | None,
) -> tuple[tuple[SpringDrawing, ...], tuple[str, ...]]:
    travel = train.travel if train is not None else cycle.channel("valve_lift")[sample]
    springs: list[SpringDrawing] = []
    notes: tuple[str, ...] = ()
    shared = len(run.springs) < len(member.springs)
    for name, installed in zip(
        ("outer", "inner") if shared else run.springs, member.springs, strict=False
    ):
        rest = study.at_rest(run.model, name) or next(
            (one for one in study.rest if one.spring in (name, installed.name)), None
        )
        drawn, remarks = draw_spring(installed, name, cycle, sample, travel, rest, shared)
        notes += tuple(sentence for sentence in remarks if sentence not in notes)
        if drawn is not None:
            springs.append(drawn)
    if train is not None:
        heights = [float(spring.retainer[0] + travel[0]) for spring in springs]
        springs = [
            replace(spring, seat=train.seat_of(height), direction=train.axis)
            for spring, height in zip(springs, heights, strict=True)
        ]
    return tuple(springs), notes


def _peaks(run: Solution, cycle: Cycle) -> list[int]:
    """Samples of the largest and least of every force, and those before them, and of the largest
    lift.
    """
    found: list[int] = []
    for name in (
        *(name for _, name in _FORCES),
        "seat_force_highest",
        "retainer_force_highest",
        "valve_lift",
    ):
        if run.has(name):
            values: Array = cycle.channel(name)
            found += [int(np.argmax(values)), int(np.argmin(values))]
    for event in run.events:
        at = float(event.details.get("peak_cam_angle", event.cam_angle)) % _TURN
        if len(found) < MAX_SPANS:
            found.append(int(np.argmin(np.abs(cycle.cam_angle - at))))
    return found


def _spans(run: Solution) -> Sequence[tuple[float, float]]:
    """Cam angles (rad) from the begin to the end of every clash, and of the moment around its peak,
    the hardest first.
    """
    speed, found = run.engine_speed / 2, []
    for event in sorted(
        (one for one in run.events if one.kind == "clash"), key=lambda one: -one.size
    )[:MAX_SPANS]:
        peak = float(event.details.get("peak_cam_angle", event.cam_angle)) % _TURN
        found.append((peak - np.radians(1.0), peak + np.radians(1.0)))
        first = event.cam_angle % _TURN
        found.append((first, first + event.duration * speed))
    return found


def _bytes_per_frame(run: Solution, member: Member) -> int:
    """Bytes that a frame takes at most: two per node for its place, one for each colouring; twelve
    per rigid body.
    """
    colours = sum(
        any(str(name).endswith(word) for name in run.arrays.variables)
        for word in ("_shear_stress", "coil_gap", "coil_gap", "axial_velocity")
    )
    found = 8 if member.gear is None else 150
    for name, spring in zip(run.springs, member.springs, strict=False):
        channel = run.channel_of(name, "axial_displacement")
        turns = spring.wire.total_coils if spring.wire is not None else 5.0
        nodes = run.channel(channel).shape[1] if run.has(channel) else 8 * turns
        bare = 0 if run.has(run.channel_of(name, "axial_position")) else 16
        surface = 8 * run.has(run.channel_of(name, "surface_equivalent_stress"))
        found += int(min(nodes, 16 * turns + 1) + bare) * (2 + colours + surface)
    return found
