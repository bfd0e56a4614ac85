"""``valvetrain cases``, ``check`` and ``new``: the library, what a case file says, and templates."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from valvetrain.cli.options import (
    ElementsOption,
    ImplausibleOption,
    JsonOption,
    QuietOption,
    SetOption,
    SpringOption,
    read_models,
)
from valvetrain.errors import InputError
from valvetrain.parameters.steel_contacts import default_contacts
from valvetrain.parameters.summary import number, value_text
from valvetrain.parameters.templates import KINDS, template_text
from valvetrain.report.text import speed_text

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.parameters.case import Case, CaseSummary
    from valvetrain.parameters.installed_spring import InstalledSpring
    from valvetrain.parameters.spring import SpringDefinition
    from valvetrain.system.problem import Problem


def register_cases(app: typer.Typer) -> None:
    """Add the command."""
    app.command("cases")(cases)


def cases(
    name: Annotated[
        str | None,
        typer.Argument(metavar="[NAME]", help="Print the file of this case.", show_default=False),
    ] = None,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """List the cases that ship with the package, or print one of their files."""
    from valvetrain.cli.outcome import Outcome, deliver, to_json
    from valvetrain.parameters.loading import LIBRARY, library_names, list_cases

    if name is None:
        found = list_cases()
        data = {
            "command": "cases",
            "cases": [
                {key: getattr(one, key) for key in ("name", "title", "holds", "sources")}
                for one in found
            ],
        }
        deliver(Outcome(data, lambda console: _show_cases(console, found)))
        return
    from valvetrain.errors import InputError
    from valvetrain.parameters.changes import nearest

    if name not in library_names():
        raise InputError(
            f"there is no case '{name[:60]}' in the library; {nearest(name, library_names())}"
        )
    text = (LIBRARY / f"{name}.toml").read_text(encoding="utf-8")
    if as_json or not quiet:
        sys.stdout.write(
            to_json({"command": "cases", "case": name, "text": text}) + "\n" if as_json else text
        )


def _show_cases(console: Console, found: tuple[CaseSummary, ...]) -> None:
    from valvetrain.citations import references
    from valvetrain.cli.outcome import plain_table

    def source(keys: tuple[str, ...]) -> str:
        known = (references().get(key.split(",")[0]) for key in keys)
        return "; ".join(
            _short(reference.field("author"), reference.field("year"))
            for reference in known
            if reference is not None
        )

    console.print(
        plain_table(
            ("name", "title", "source"),
            ((one.name, one.title, source(one.sources)) for one in found),
        )
    )
    console.print(
        "\n'valvetrain cases NAME' prints the file of a case, 'valvetrain run NAME' runs it."
    )


def _short(authors: str, year: str) -> str:
    families = [author.split(",")[0].strip("{} ") for author in authors.split(" and ")]
    return f"{families[0]}{' et al.' if len(families) > 1 else ''} ({year})"


def register_check(app: typer.Typer) -> None:
    """Add the command."""
    app.command("check")(check)


def check(
    case: Annotated[
        str,
        typer.Argument(
            metavar="FILE", help="Case file, or name of a library case.", show_default=False
        ),
    ],
    spring: SpringOption = None,
    settings: SetOption = None,
    elements_per_coil: ElementsOption = None,
    implausible: ImplausibleOption = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Check a case file: print its values as they were understood, or what is wrong with it, and
    where.
    """
    from valvetrain.cli.cases import case_facts, case_quantities
    from valvetrain.cli.options import choose_case
    from valvetrain.cli.outcome import Outcome, deliver
    from valvetrain.report.json import quantities_object

    chosen = choose_case(case, settings, elements_per_coil)
    problem = put_together(chosen, read_models(spring), implausible)
    quantities = case_quantities(chosen, problem)
    facts = case_facts(chosen)
    data = {
        "command": "check", "case": chosen.name, "title": chosen.title, "holds": _holds(chosen), "facts": dict(facts),
        "quantities": quantities_object(quantities),
    }  # fmt: skip
    deliver(Outcome(data, lambda console: _show_check(console, chosen, facts, quantities)))


def put_together(case: Case, models: tuple[str, ...], implausible: bool = False) -> Problem | None:
    """Build everything that ``run`` builds, the springs of every set too, since some errors appear
    only there. None for a lift law alone.

    ``implausible``: values pass that no valvetrain can have.
    """
    from valvetrain.runs.notes import refusals_before_run
    from valvetrain.system.build import build, lift_law_of

    if case.train is None and not case.springs:
        lift_law_of(case)
        return None
    problem = build(case, spring_models=models)
    problem.must_run()
    refused = refusals_before_run(problem, implausible)
    if refused and (models or len(refused) == len(problem.members)):
        raise InputError(next(iter(refused.values())), "--spring" if models else "")
    sets = tuple(case.train.springs) if case.train is not None else ()
    for member in build(case, spring_models=models, spring_sets=sets).members if sets else ():
        if not member.refusal and not member.model.needs_rest:
            member.system(built=problem.built)
    return problem


def _holds(case: Case) -> list[str]:
    named = (
        ("spring", case.springs),
        ("lift_law", case.lift_law),
        ("train", case.train),
        ("published", case.published),
    )
    return [name for name, held in named if held]


def _show_check(
    console: Console, case: Case, facts: list[tuple[str, str]], quantities: dict[str, float]
) -> None:
    from valvetrain.cli.outcome import plain_table, quantity_rows

    console.print(f"{case.name}: a valid case with {', '.join(_holds(case))}\n")
    console.print(plain_table(("", ""), facts))
    if quantities:
        console.print()
        console.print(plain_table(("", "", ""), quantity_rows(quantities), right=(1,)))


def register_new(app: typer.Typer) -> None:
    """Add the command."""
    app.command("new")(new)


def new(
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="Name of the case; NAME.toml is written.")
    ],
    kind: Annotated[
        str,
        typer.Option(
            "--kind",
            "--train",
            metavar="KIND",
            help=f"Kind of case: {', '.join(f'{word} ({meaning})' for word, meaning in KINDS.items())}.",
        ),
    ] = "spring",
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Write NAME.toml, a commented case with plausible values that runs as it stands."""
    from valvetrain.cli.outcome import Outcome, deliver

    path = write_template(name, kind)
    data = {"command": "new", "kind": kind, "files": [str(path)]}
    label = f"{path}: {KINDS[kind]}; put in your values, then run 'valvetrain run {path}'"
    deliver(Outcome(data, lambda console: console.print(label, soft_wrap=True)))


def write_template(name: str, kind: str) -> Path:
    """Write the template of ``kind`` (a key of :data:`KINDS`) to ``name`` with the ending
    ``.toml``; its path.

    Raises :class:`InputError` for an unknown kind, a name that no file may bear, or a file that is
    there.
    """
    from valvetrain.parameters.loading import library_names
    from valvetrain.solution.atomic import write_text

    text = template_text(kind)
    stem = name.removesuffix(".toml")
    if (
        not stem.strip()
        or stem.endswith(("/", ".."))
        or not stem.isprintable()
        or len(Path(stem).name) > 80
    ):
        raise InputError(
            f"'{name[:40]}' cannot be the name of a file; give such as my-spring", "NAME"
        )
    if stem in library_names():
        raise InputError(f"'{stem}' is a case of the library; choose another name", "NAME")
    path = Path(f"{stem}.toml")
    try:
        taken = path.exists() or path.is_symlink()
    except OSError as error:
        raise InputError(
            f"'{name[:40]}' cannot be the name of a file ({error.strerror}); give such as my-spring",
            "NAME",
        ) from None
    if taken:
        raise InputError(
            f"the file '{path}' is there already; choose another name or remove it", "NAME"
        )
    return write_text(path, text.replace("NAME.toml", str(path)))


def case_facts(case: Case) -> list[tuple[str, str]]:
    """(subject, text) of everything the case holds; values that follow from it are in its named
    quantities.
    """
    facts = [("title", case.title)] if case.title else []
    for spring in case.springs:
        facts += _spring_facts(spring)
    if case.lift_law is not None:
        facts.append(("lift law", f"{case.lift_law.kind}, lift of the {case.lift_law.lift_of}"))
    if case.train is not None:
        train = case.train
        facts.append(
            (
                "train",
                f"{train.kind}, {train.model} model, {train.spring_model} springs, lash {number(train.lash * 1e3)} mm",
            )
        )
        facts.append(
            (
                "contacts",
                ", ".join(
                    f"{place.replace('_', ' ')} {contact.law}"
                    for place, contact in train.contacts.items()
                ),
            )
        )
        if said := default_contacts(train.contacts):
            facts.append(("", said))
        facts += [
            (f"springs '{name}'", "; ".join(map(_spring_fact, springs)))
            for name, springs in train.springs.items()
        ]
    if case.operation.engine_speeds:
        facts.append(
            (
                "engine speeds",
                f"{', '.join(map(speed_text, case.operation.engine_speeds))} of the crank",
            )
        )
    if case.springs:
        facts.append(("cam revolutions", f"{case.operation.cycles}, the last one reported"))
    if case.points:
        facts.append(
            (
                "points on the wire",
                ", ".join(
                    f"{name.replace('_', ' ')} at coil {coil:g}"
                    for name, coil in case.points.items()
                ),
            )
        )
    if case.published:
        roles = Counter(value.role for value in case.published)
        facts.append(
            ("published values", ", ".join(f"{count} for {role}" for role, count in roles.items()))
        )
    statuses = Counter(note.status for note in case.notes.values() if note.status)
    if statuses:
        facts.append(
            (
                "status of values",
                ", ".join(f"{count} {status}" for status, count in statuses.items()),
            )
        )
    return facts


def _spring_fact(spring: InstalledSpring) -> str:
    if spring.card is None:
        return f"{spring.name}: wire known, compressed {number(spring.precompression * 1e3)} mm when installed"
    card = spring.card
    mass = "" if card.mass is None else f", mass {number(card.mass * 1e3)} g"
    return (
        f"{card.name}: rate {number(card.rate / 1e3)} N/mm, preload {number(card.preload)} N{mass}"
    )


def _spring_facts(spring: InstalledSpring) -> list[tuple[str, str]]:
    facts = (
        _wire_facts(spring.wire)
        if spring.wire is not None
        else [("spring", f"known by its card, {_spring_fact(spring)}")]
    )
    if spring.wire is not None:
        facts.append(
            (
                "seats",
                "end coils may touch flat seats"
                if spring.seats == "planes"
                else "inactive ends only",
            )
        )
    if spring.guide is not None:
        facts.append(("guide", f"{spring.guide.words()}, without friction"))
    damping = spring.damping
    if damping.mass_damping or damping.stiffness_damping:
        ratio = "" if damping.ratio is None else f"ratio {number(damping.ratio)}: "
        mass, stiffness = number(damping.mass_damping), number(damping.stiffness_damping * 1e6)
        facts.append(("damping", f"{ratio}mass {mass} 1/s, stiffness {stiffness} µs"))
    for word, options in spring.options.items():
        facts.append(
            (
                f"options of {word}",
                ", ".join(f"{key.replace('_', ' ')} {value}" for key, value in options.items()),
            )
        )
    return facts


def _wire_facts(wire: SpringDefinition) -> list[tuple[str, str]]:
    ends = [
        f"{side} {end.kind}, {number(end.inactive_coils)} coils inactive, {number(end.ground_coils)} ground"
        for side, end in (("lower", wire.lower_end), ("upper", wire.upper_end))
    ]
    return [
        ("spring", f"{wire.name}, {wire.hand}-handed"),
        ("wire diameter", value_text(wire.wire_diameter, "wire_diameter")),
        ("mean coil diameter", value_text(wire.mean_diameter, "mean_diameter")),
        ("pitch", value_text(wire.pitch, "pitch")),
        ("material", value_text(wire.material, "material")),
        ("end coils", "; ".join(ends)),
    ]


def case_quantities(case: Case, problem: Problem | None) -> dict[str, float]:
    """Named quantities (SI) of the springs of a case, of a nested pair with ``outer_`` and
    ``inner_`` in front, and of its lift.
    """
    from valvetrain.quantities.statics import design_quantities

    springs = case.springs or (case.train.spring_parts() if case.train is not None else ())
    places = ("",) if len(springs) == 1 else ("outer_", "inner_")
    found = {
        place + name: value
        for place, spring in zip(places, springs, strict=False)
        for name, value in design_quantities(spring).items()
    }
    if problem is None or case.lift_law is None:
        return found
    angle = np.linspace(0.0, 2 * np.pi, 7201)
    lift = np.asarray(problem.valve_lift.lift(angle))
    top = int(np.argmax(lift))
    return found | {"maximum_lift": float(lift[top]), "maximum_lift_cam_angle": float(angle[top])}
