"""``valvetrain modes``: natural frequencies about a compressed state."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import (
    MAX_COUNTED,
    CaseArgument,
    ElementsOption,
    JsonOption,
    LimitOption,
    QuietOption,
    SetOption,
    SpringOption,
    SpringSetOption,
    read_amounts,
    read_count,
    read_length,
    read_models,
    read_names,
)
from valvetrain.cli.static import KeepOption
from valvetrain.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from rich.console import Console

    from valvetrain.cli.outcome import Outcome
    from valvetrain.parameters.case import Case
    from valvetrain.solution.modes import TrainModes
    from valvetrain.solution.study import Study


#: Cam orders at which a surge of 300 to 700 Hz meets the lift between 3000 and 12000 rpm.
SURGE_ORDERS = range(6, 13)
#: Overlap below which a mode became another one rather than moved.
NAME_ONLY = 0.5
#: Explanation of the column of that name.
TRANSMISSION = (
    "axial transmission: share of an axial push at one end that the mode passes on to the other"
)


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("modes")(modes)


def modes(
    case: CaseArgument,
    count: Annotated[
        int, typer.Option("--count", metavar="N", help="Number of modes, lowest first.")
    ] = 24,
    compression: Annotated[
        str | None,
        typer.Option(
            "--compression",
            metavar="LENGTH",
            help="Compression to compute them at: '7 mm' (default: installed).",
        ),
    ] = None,
    attached_mass: Annotated[
        str | None,
        typer.Option(
            "--attached-mass",
            metavar="MASS",
            help="Mass that moves with the retainer: '50 g' (default: both ends fixed).",
            show_default=False,
        ),
    ] = None,
    free_end: Annotated[
        bool,
        typer.Option(
            "--free-end", help="The retainer end is free to move along the axis, without a mass."
        ),
    ] = False,
    spring: SpringOption = None,
    spring_set: SpringSetOption = None,
    settings: SetOption = None,
    elements_per_coil: ElementsOption = None,
    limit: LimitOption = None,
    keep: KeepOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Natural frequencies of springs, both ends fixed or one with a mass; of a train also with its
    springs, as one.
    """
    from valvetrain.cli.options import choose_case, folder_of
    from valvetrain.cli.outcome import deliver, say_cost
    from valvetrain.runs.cost import FEWER_AT_REST, read_limits
    from valvetrain.runs.request_cost import static_cost
    from valvetrain.runs.statics import CURVE_OF_MODES

    chosen = choose_case(case, settings, elements_per_coil)
    read_count(count, 1, MAX_COUNTED, "--count")
    if free_end and attached_mass is not None:
        raise InputError(
            "a free end has no mass attached; give --free-end or --attached-mass", "--free-end"
        )
    masses = (
        (0.0,)
        if free_end
        else read_amounts(
            None if attached_mass is None else [attached_mass], "mass", "--attached-mass"
        )
    )
    if len(masses) > 1 or any(mass < 0 for mass in masses):
        raise InputError(
            f"'{attached_mass}' is no mass; give one of zero or more, such as '50 g'",
            "--attached-mass",
        )
    state = read_length(compression, "--compression")
    models, sets = read_models(spring), read_names(spring_set)
    say_cost(
        static_cost(chosen, models, spring_sets=sets, steps=CURVE_OF_MODES, modes=count),
        read_limits(limit),
        FEWER_AT_REST,
    )
    home = folder_of(case) if keep else None
    deliver(compute_modes(chosen, models, sets, count, state, masses[0] if masses else None, home))


def compute_modes(
    case: Case,
    spring_models: tuple[str, ...],
    spring_sets: tuple[str, ...],
    count: int,
    compression: float | None = None,
    attached_mass: float | None = None,
    keep: Path | None = None,
) -> Outcome:
    """The ``count`` lowest modes of every spring about ``compression`` (m from the free state;
    None: as installed), ``attached_mass`` (kg) on the retainer, 0 for a free end (None: both ends
    fixed); ``keep``: folder of the case; the answer is saved there.
    """
    from valvetrain.cli.outcome import Outcome
    from valvetrain.cli.progress import announce_compilation, progress_bar
    from valvetrain.cli.static import saved_outcome
    from valvetrain.report.json import study_json
    from valvetrain.report.verdict import verdict_of
    from valvetrain.runs.statics import static_study
    from valvetrain.runs.train_runs import train_modes

    announce_compilation("statics")
    with progress_bar("modes") as report:
        study = static_study(
            case,
            spring_models,
            spring_sets=spring_sets,
            command="modes",
            compression=compression,
            modes=count,
            attached_mass=attached_mass,
            progress=report,
        )
        trains = (
            train_modes(case, spring_models, spring_set=spring_sets)
            if case.train is not None and compression is None
            else ()
        )
    data = study_json(study) | (
        {"train_modes": [_object(one, count) for one in trains]} if trains else {}
    )

    def show(console: Console) -> None:
        _show(console, study)
        for one in trains:
            _show_train(console, one, count)

    said = " ".join(filter(None, (verdict_of(study), followed_sentence(trains))))
    outcome = Outcome(data, show, study.failures, said)
    return outcome if keep is None else saved_outcome(outcome, study, case, keep, {"count": count})


def followed_sentence(trains: Sequence[TrainModes]) -> str:
    """What orders and amplitudes mean, and the lowest mode that is another one at full lift than on the
    seat; empty without a train.
    """
    if not trains:
        return ""
    text = "Orders are those of the cam, amplitudes 0 to peak"
    closed = {one.label: one for one in trains if not one.closed_mode}
    for one in trains:
        changed = [place for place, share in enumerate(one.overlap) if share < NAME_ONLY]
        if changed and one.label in closed:
            place = changed[0]
            before = one.closed_mode[place]
            first, last = (
                f"{float(table.natural_frequency[at]):.0f} Hz"
                for table, at in ((closed[one.label], before), (one, place))
            )
            text += (
                f"; closed mode {before + 1} ({first}) is called {place + 1} ({last}) at full lift, "
                f"the nearest by shape, overlap {100 * one.overlap[place]:.0f} %"
            )
            break
    return f"{text}."


def _object(modes: TrainModes, count: int) -> dict[str, Any]:
    """JSON of the modes of a train: SI, bodies and parts by name."""
    each = [
        {
            "mode": place + 1,
            "natural_frequency": {"value": float(frequency), "unit": "Hz"},
            "shape": dict(zip(modes.bodies, modes.shape[place].tolist(), strict=True)),
            "energy_share": dict(zip(modes.parts, modes.energy_share[place].tolist(), strict=True)),
            **_followed(modes, place),
        }
        for place, frequency in enumerate(modes.natural_frequency[:count])
    ]
    content = {
        "cam_angle": {"value": modes.cam_angle, "unit": "rad"},
        "valve_lift": {"value": modes.valve_lift, "unit": "m"},
    }
    return (
        {"label": modes.label, "state": modes.state, "closed": modes.closed, "open": modes.open}
        | content
        | {"modes": each}
    )


def _followed(modes: TrainModes, place: int) -> dict[str, Any]:
    """The mode of the closed valve (from 1) that continues in this one, and their overlap."""
    if not modes.closed_mode:
        return {}
    overlap = {"value": modes.overlap[place], "unit": "1"}
    return {"closed_mode": modes.closed_mode[place] + 1, "overlap": overlap}


def _show_train(console: Console, modes: TrainModes, count: int) -> None:
    from valvetrain.cli.outcome import plain_table
    from valvetrain.parameters.summary import number
    from valvetrain.runs.train_runs import STATES

    followed = bool(modes.closed_mode)
    names = [
        (
            str(place + 1),
            number(float(one), 5),
            *(
                (
                    _closed_text(modes.closed_mode[place], count),
                    f"{100 * modes.overlap[place]:.0f} %",
                )
                if followed
                else ()
            ),
            modes.moving(place),
        )
        for place, one in enumerate(modes.natural_frequency[:count])
    ]
    heads = ("mode", "frequency (Hz)", *(("closed mode", "overlap") if followed else ()))
    title = f"Whole train, {modes.label}, {STATES.get(modes.state, modes.state)}"
    console.print()
    console.print(
        plain_table(
            (*heads, "moving (kinetic energy)"), names, title, right=tuple(range(len(heads)))
        )
    )
    if modes.open:
        console.print(f"open there, without stiffness: {', '.join(modes.open)}")


def _closed_text(place: int, count: int) -> str:
    """The number (from 1) of a mode of the closed valve; of one that is not printed that it is above."""
    return str(place + 1) if place < count else f"above {count}"


def _show(console: Console, study: Study) -> None:
    from valvetrain.cli.outcome import plain_table
    from valvetrain.parameters.summary import number

    console.print(study.record.title or study.record.name)
    for one in study.rest:
        console.print()
        if one.modes is None:
            console.print(f"{one.spring} by {one.model}: no inner motion, so no modes")
            continue
        names = {
            place: f"axial mode {index}"
            for index, place in enumerate(one.modes.axial_modes, start=1)
        }
        shares = [f"{share:+.3f}".replace("-", "−") for share in one.modes.axial_transmission]
        several = any(share != shares[0] for share in shares)  # all alike where every mode is axial
        rows = [
            (
                str(place + 1),
                number(float(frequency), 5),
                *((shares[place],) if several else ()),
                names.get(place, ""),
            )
            for place, frequency in enumerate(one.modes.natural_frequency)
        ]
        mass = one.modes.attached_mass
        end = (
            ""
            if mass is None
            else f", {number(mass * 1e3)} g on the retainer"
            if mass
            else ", retainer's end free"
        )
        title = f"{one.spring} by {one.model}, at {number(one.modes.compression * 1e3)} mm compression{end}"
        console.print(
            plain_table(
                ("mode", "frequency (Hz)", *(("axial transmission",) if several else ()), ""),
                rows,
                title,
                right=(0, 1, 2) if several else (0, 1),
            )
        )
        if several:
            console.print(TRANSMISSION, soft_wrap=True)
        if len(one.modes.axial_modes) and mass is None:
            surge = float(one.modes.axial_frequencies[0])  # Hz
            met = ", ".join(f"{order} at {120 * surge / order:.0f}" for order in SURGE_ORDERS)
            console.print(
                f"the first axial mode meets cam order {met} rpm of the crank", soft_wrap=True
            )
