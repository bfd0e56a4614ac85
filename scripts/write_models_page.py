"""Write docs/models.md: which spring model runs which shipped case, found by running all of them
cheaply.

Use: python scripts/write_models_page.py
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import valvetrain
from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.parameters.case import Case
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.loading import load_case
from valvetrain.runs.compare import compare_study, sweep_study
from valvetrain.runs.run import run_study
from valvetrain.solution.study import Study
from valvetrain.springs.spec import SpringModelSpec, spring_model
from valvetrain.system.build import build

#: The one speed of all runs (rad/s of the crank), low enough that every train settles soon.
ENGINE_SPEED = 2000 * math.pi / 30
COMMANDS = ("run", "compare", "sweep")
NO_LIFT = "the case has no lift law, so nothing moves: `compare` shows statics and modes by every model, `run` by finite elements"
INTRODUCTION = """# Spring models and shipped cases

Which spring model runs which shipped case under `valvetrain run`, `compare` and `sweep`. Written by `scripts/write_models_page.py` from
real runs at one engine speed with coarse meshes; a test runs them again and compares. A letter stands for a reason below the table.
"""
AFTER = """
Every model also runs from a program (`valvetrain.simulate`, `compare`, `sweep`) and in a case of one's own, with the same reasons
where it cannot. What each model knows and leaves out:
"""


def coarse(case: Case) -> Case:
    """The case with few elements per coil and one cam turn of prescribed motion, which changes
    numbers and not what can run.
    """

    def few(springs: tuple[InstalledSpring, ...]) -> tuple[InstalledSpring, ...]:
        return tuple(
            spring.with_options("finite-element", elements_per_coil=6) for spring in springs
        )

    train = case.train
    if train is not None:
        train = train.replace(
            springs={name: few(springs) for name, springs in train.springs.items()}, variants=()
        )
    return replace(
        case, springs=few(case.springs), train=train, operation=replace(case.operation, cycles=1)
    )


def outcomes(case: Case) -> dict[tuple[str, str], str]:
    """(model word, command) -> empty where it ran, else the reason in a sentence."""
    words, found = registry.words("springs"), {}
    problem = build(case, spring_models=words)
    still = [member.model.word for member in problem.members if member.model.no_motion]
    for command in COMMANDS:
        moving = [word for word in words if word not in still]
        found |= {(word, command): reason for word, reason in _command(case, command, moving)}
        found |= {(word, command): _without_motion(case, command, word, moving) for word in still}
    return found


def _without_motion(case: Case, command: str, word: str, moving: list[str]) -> str:
    """Reason of a model of statics and modes. Solids take minutes: those of a spring alone under
    compare are run by tests of their own.
    """
    if command == "compare" and case.train is None:
        return ""
    try:
        _study(
            case, command, [ENGINE_SPEED], [*moving[:1], word] if command == "compare" else [word]
        )
    except InputError as error:
        return str(error)
    return ""


def _command(case: Case, command: str, words: list[str]) -> Iterator[tuple[str, str]]:
    """Word and reason of each model under one command."""
    speeds = [ENGINE_SPEED] if case.lift_law is not None else []
    try:
        study = _study(case, command, speeds, words)
    except InputError as error:
        yield from ((word, str(error)) for word in words)
        return
    for word in words:
        runs = [run for run in study.solutions if run.model == word]
        if runs:
            run = runs[0]
            yield word, "" if run.status.completed else run.status.message
        else:
            yield word, "" if word in {one.model for one in study.rest} else NO_LIFT


def _study(case: Case, command: str, speeds: list[float], words: list[str]) -> Study:
    if command == "run":
        return run_study(case, engine_speeds=speeds, spring_models=words, workers=1)
    if command == "compare":
        return compare_study(case, engine_speeds=speeds, spring_models=words, workers=1)
    return sweep_study(
        case, speeds or [ENGINE_SPEED], spring_models=words, workers=1, critical=None
    )


def page(found: dict[str, dict[tuple[str, str], str]]) -> str:
    """The page of what was found per case."""
    words, notes = registry.words("springs"), {}

    def letter(reason: str) -> str:
        return f"({notes.setdefault(reason, chr(ord('a') + len(notes)))})"

    rows = []
    for name, outcome in found.items():
        cells = []
        for word in words:
            said = {command: outcome[word, command] for command in COMMANDS}
            ran = [command for command in COMMANDS if not said[command]]
            reasons = dict.fromkeys(_plain(reason) for reason in said.values() if reason)
            text = "all" if len(ran) == len(COMMANDS) else ", ".join(ran)
            cells.append(
                " ".join(part for part in (text, *(letter(reason) for reason in reasons)) if part)
            )
        rows.append(f"| `{name}` | {' | '.join(cells)} |")
    head = f"| case | {' | '.join(f'`{word}`' for word in words)} |\n|---|{'---|' * len(words)}\n"
    below = "".join(
        f"\n- ({mark}) {reason[0].upper()}{reason[1:]}." for reason, mark in notes.items()
    )
    return (
        f"{INTRODUCTION}\n`all`: all three commands.\n\n{head}"
        + "\n".join(rows)
        + f"\n{below}\n{AFTER}\n{_knowledge()}"
    )


def _plain(reason: str) -> str:
    """A reason without the names of one case."""
    if "holds no lift law" in reason or "does not move" in reason:
        return NO_LIFT
    if "is a train; leave solid out" in reason:
        return "solids serve a spring alone: their statics and modes under `compare`"
    if "statics and modes" in reason and "days" in reason:
        return "solids give statics and modes under `compare`; a cam cycle would take them days"
    return reason.split("is known by its card only; ")[-1].removeprefix("--spring: ").rstrip(".")


def _knowledge() -> str:
    specs: list[SpringModelSpec] = [spring_model(word) for word in registry.words("springs")]
    rows = "".join(f"| `{spec.word}` | {spec.knows} | {spec.leaves_out} |\n" for spec in specs)
    return f"| model | knows | leaves out |\n|---|---|---|\n{rows}"


def models_page() -> str:
    """docs/models.md from real runs."""
    return page(
        {
            summary.name: outcomes(coarse(load_case(summary.name)))
            for summary in valvetrain.list_cases()
        }
    )


if __name__ == "__main__":
    place = Path(__file__).resolve().parents[1] / "docs" / "models.md"
    place.write_text(models_page(), encoding="utf-8")
    print(f"wrote {place.name}")
