"""``valvetrain new``: a case from a template, or the first file of a study, search or identification of a case."""

from __future__ import annotations

import math
import os
import shlex
import sys
from collections.abc import Mapping
from dataclasses import dataclass, make_dataclass
from pathlib import Path
from typing import Any

import typer

from valvetrain.cli.request import AnswerLine, command_without_case
from valvetrain.errors import InputError
from valvetrain.parameters.templates import (
    KINDS,
    QUESTIONS,
    TRAINS,
    engine_names,
    engine_text,
    flag,
    template_kind,
    template_text,
)
from valvetrain.runs.request_fields import option, read_text

#: Kind of request -> what its file asks of a case.
REQUESTS = {
    "study": "what decides in a case",
    "lash": "where and how fast its valve lands over lash",
    "optimise": "the best spring for it",
    "identify": "its wire from measured loads, by a card its damping from measured surge",
}
#: Least radius (m) of a cam under a flat face that a written case has.
NOSE = 3e-3
#: Kind of request -> the command that runs it, where that has another name.
COMMANDS = {"lash": "study"}


@dataclass(frozen=True, kw_only=True)
class CaseLine(AnswerLine):
    """What is written, besides the answers of an engine."""

    name: str = option(read_text, "Name of the file; NAME.toml is written.", metavar="NAME")
    kind: str = option(
        read_text,
        f"Kind of case: {', '.join(f'{word} ({meaning})' for word, meaning in KINDS.items())}; "
        f"or with --case: {', '.join(f'{word} ({meaning})' for word, meaning in REQUESTS.items())}.",
        "--kind --train",
        "KIND",
        default="spring",
    )
    case: str = option(read_text, "The case that a study is about.", "--case", "CASE", default="")
    like: str = option(
        read_text,
        f"An engine whose numbers have sources, in place of a template: {', '.join(engine_names())}.",
        "--like",
        "NAME",
        default="",
    )


def _answer_option(name: str) -> Any:
    asked = QUESTIONS[name]
    meaning = f"{asked.meaning[0].upper()}{asked.meaning[1:]}."
    return option(read_text, meaning, flag(name), asked.follows, default="")


NewLine = make_dataclass(
    "NewLine",
    [(name, str, _answer_option(name)) for name in QUESTIONS],
    bases=(CaseLine,),
    frozen=True,
    kw_only=True,
)


def new(line: CaseLine) -> None:
    """Write NAME.toml, a commented case, or a study of --case, that runs without changes.

    An engine is written from what you have of it: spring card, cam card, masses, red line, as options or, at a terminal,
    one question after another. What you leave open is assumed, and every answer says so.
    """
    from valvetrain.cli.outcome import Outcome, deliver

    name, kind, case = line.name, line.kind, line.case
    answers = {word: text for word in QUESTIONS if (text := getattr(line, word))}
    if line.like:
        if answers or case or kind != "spring":
            raise InputError("it gives the whole engine; leave the other options out and change its file", "--like")  # fmt: skip
        kind, path = line.like, _written(name, engine_text(line.like))
        label = f"{path}: an engine like {kind}\n  {_assumptions(path)}\n  next: valvetrain sweep {shlex.quote(str(path))}"
    elif kind in REQUESTS:
        path = write_request(name, kind, case)
        label = f"{path}: {REQUESTS[kind]}\n  next: valvetrain {COMMANDS.get(kind, kind)} {shlex.quote(str(path))}"
    elif case:
        raise InputError(
            f"a {template_kind(kind)} case is not about another; give --kind {', '.join(REQUESTS)}, or leave --case out",
            "--case",
        )
    else:
        kind = template_kind(kind)
        if not (answers or line.json or line.quiet) and kind in TRAINS and sys.stdin.isatty():
            answers = _asked(kind)
        path = write_template(name, kind, answers)
        label = f"{path}: {KINDS[kind]}\n  {_assumptions(path)}\n  next: valvetrain run {shlex.quote(str(path))}"
    data = {"command": "new", "kind": kind, "files": [str(path)]}
    deliver(Outcome(data, lambda console: console.print(label, soft_wrap=True)))


register_new = command_without_case("new", NewLine, new)


def _asked(kind: str) -> dict[str, str]:
    """Answers to the questions of a kind of train, typed one by one; what was left open is not among them."""
    from valvetrain.parameters.card_case import questions_of

    typer.echo("Enter takes the value in brackets, Ctrl-D all that are left.", err=True)
    answers: dict[str, str] = {}
    for word, one, default in questions_of(kind):
        if word in ("open_load", "open_height") and "rate" in answers:
            continue
        try:
            typed = input(f"{word.replace('_', ' ')}, {one.meaning} [{default or 'none'}]: ")
        except EOFError:
            break
        if typed.strip():
            answers[word] = typed
    return answers


def _assumptions(path: Path) -> str:
    """Sentence on the spring damping of a template, which neither cards nor drawings give, and on values assumed."""
    from valvetrain.parameters.loading import load_case

    case = load_case(path)
    spring = (case.springs if case.train is None else case.train.spring_parts())[0]
    ratio, hertz = spring.damping.ratio, spring.damping.ratio_frequency
    damped = f"its spring is damped by {ratio:g} of critical at {hertz:g} Hz, an assumption until you measure it"
    assumed = ", ".join(case.record().assumed)
    return f"{damped}\n  assumed: {assumed}" if assumed else damped


def write_template(name: str, kind: str, answers: Mapping[str, str] | None = None) -> Path:
    """Write the template of ``kind`` (a key of :data:`KINDS`) to ``name`` with the ending ``.toml``, an engine with
    the ``answers`` of its cards; returns its path.

    Raises :class:`InputError` for an unknown kind, a name that no file may bear, a file that is there, or an answer that cannot be.
    """
    if answers and kind not in TRAINS:
        raise InputError(
            f"{flag(next(iter(answers)))} is of an engine; give --kind {', '.join(TRAINS)}, or 'valvetrain spring-card' for a spring alone",
            "--kind",
        )
    if not answers:
        return _written(name, template_text(kind))
    from valvetrain.parameters.card_case import card_case_text
    from valvetrain.parameters.loading import parse_case
    from valvetrain.system.build import build

    text = _with_room(card_case_text(kind, answers))
    try:
        build(parse_case(text, where="the case")).must_run()
    except InputError as error:
        asked = [
            word for word, one in QUESTIONS.items() if one.key.rpartition(".")[2] in error.reason
        ]
        where = flag(max(asked, key=len)) if asked else error.where
        lift = flag("advertised_lift")
        more = f"; {lift} is often 0.020 in with lash" if where == flag("advertised") else ""
        raise InputError(error.reason + more, where) from None
    return _written(name, text)


def _with_room(text: str) -> str:
    """The case with an assumed base circle so large that a cam under a flat face has a radius of :data:`NOSE` at least."""
    from valvetrain.mechanism.contour import curvature_radius_flat
    from valvetrain.parameters.card_case import with_value
    from valvetrain.parameters.loading import parse_case
    from valvetrain.system.build import build

    key, train = ("train", "cam", "base_radius"), parse_case(text, where="the case").train
    if train is None or train.follower is None or train.follower.shape != "flat" or not train.cam:
        return text
    wide = 2 * train.cam.base_radius
    larger = with_value(text, key, f"{wide * 1e3:.6g} mm")
    gear = build(parse_case(larger, where="the case")).members[0].gear
    if gear is None:
        return text
    mechanism = gear.mechanism
    contour = mechanism.tables[mechanism.interactions[mechanism.interaction_index("cam")].table]
    needed = wide + NOSE - float(curvature_radius_flat(contour).min())
    if needed <= train.cam.base_radius:
        return text
    return with_value(text, key, f"{math.ceil(needed * 1e3)} mm")


def write_request(name: str, kind: str, case: str) -> Path:
    """Write the first file of ``kind`` (a key of :data:`REQUESTS`) about a ``case``, the name of
    one of the library or a path; returns its path.

    Raises :class:`InputError` without a case, for one that cannot be read, and as :func:`write_template`.
    """
    from valvetrain.explore.first_files import request_text
    from valvetrain.parameters.loading import load_case

    if not case:
        raise InputError(f"which case? give --case my-train.toml, which {kind} is about", "--case")
    told = os.path.relpath(case, Path(name).parent) if os.path.isfile(case) else case
    return _written(name, request_text(kind, load_case(case), told))


def _written(name: str, text: str) -> Path:
    from valvetrain.parameters.loading import library_names
    from valvetrain.solution.atomic import write_text

    stem = name.removesuffix(".toml")
    last = Path(stem).name
    ends_as_folder = stem.endswith(("/", "/.", ".."))
    if not last.strip() or ends_as_folder or not stem.isprintable() or len(last) > 80:
        raise InputError(f"'{name[:40]}' cannot be the name of a file; give such as my-spring")
    if stem in library_names():
        raise InputError(f"'{stem}' is a case of the library; choose another name")
    path = Path(f"{stem}.toml")
    try:
        taken = path.exists() or path.is_symlink()
    except OSError as error:
        raise InputError(
            f"'{name[:40]}' cannot be the name of a file ({error.strerror}); give such as my-spring"
        ) from None
    if taken:
        raise InputError(f"the file '{path}' is there already; choose another name or remove it")
    return write_text(path, text.replace("NAME.toml", str(path)))
