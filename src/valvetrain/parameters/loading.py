"""Case files and the case library: TOML text in, a frozen :class:`Case` or one clear
:class:`InputError` out.
"""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from pydantic import ValidationError
from pydantic_core import PydanticCustomError

from valvetrain.errors import InputError
from valvetrain.parameters.bounded_file import bounded_bytes
from valvetrain.parameters.case import Case, CaseSummary, PublishedValue
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.overrides import split_notes, with_values
from valvetrain.parameters.schema_case import CaseModel
from valvetrain.parameters.schema_types import MAX_NAME_LENGTH, first_problem
from valvetrain.parameters.templates import template_kind, template_text
from valvetrain.parameters.toml_text import find_line, resolved, toml_text
from valvetrain.units import believed
from valvetrain.units.text import clipped

LIBRARY = Path(__file__).parent / "library"
#: What the name of a template begins with, where a case is called by name.
TEMPLATE = "template:"
#: Keys of more parts than this (``a.b.c``) are no case's, nor are more keys, tables and lists, or
#: more numbers: the largest case has 700, and a table of lifts may have 50 000 lines.
MAX_PARTS, MAX_TABLES, MAX_NUMBERS = 12, 5_000, 120_000


class HasParameters(Protocol):
    """A case as Python users hold it (:class:`valvetrain.Case`)."""

    @property
    def parameters(self) -> Case:
        """The frozen case in SI."""


#: A case, the name of a library case or the path of a case file.
AnyCase = Case | HasParameters | str | os.PathLike[str]
_TABLE = re.compile(r"[=\[{\\]+")
_DEEP_KEY = re.compile(
    rf"""(?<![\w-])(?:(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*){{{MAX_PARTS}}}(?=[\w"'-])"""
)


def case_of(case: AnyCase) -> Case:
    """The case itself, or the one of that name or path; errors as :func:`load_case`."""
    case = getattr(case, "parameters", case)  # of a case as Python users hold it
    if isinstance(case, Case):
        return case
    if not isinstance(case, (str, os.PathLike)):
        raise InputError(
            f"'{str(case)[:40]}' is no case; give a Case, the name of a library case or the path of a case file"
        )
    return load_case(case)


def load_case(
    name_or_path: str | os.PathLike[str], changes: Mapping[str, Any] | None = None
) -> Case:
    """The case of a library name, a template or a TOML file.

    Parameters
    ----------
    name_or_path : name of a library case (:func:`list_cases`), such as ``gu2021-beehive``, path
        of a TOML file, or ``template:KIND`` for what ``valvetrain new --kind KIND`` writes
    changes : key path -> value, as a file would hold it: {"spring.wire_diameter": "4.1 mm"}

    Returns
    -------
    Case, frozen, in SI

    Raises
    ------
    InputError : one sentence: file, line, key path, what is wrong and the remedy

    Examples
    --------
    >>> case = load_case("gu2021-beehive", {"spring.wire_diameter": "4.1 mm"})
    >>> case.spring.wire_diameter.value(0.0).round(6)
    np.float64(0.0041)
    """
    text = os.fspath(name_or_path)
    if not isinstance(text, str) or not text.strip() or "\0" in text:
        raise InputError(
            "a case is called by the name of a library case or the path of a TOML file; give one"
        )
    names = library_names()
    if text in names:
        return read_case(LIBRARY / f"{text}.toml", changes)
    if text.startswith(TEMPLATE):
        kind = template_kind(text.removeprefix(TEMPLATE))
        return parse_case(template_text(kind), kind, where=text, changes=changes)
    path = Path(text)
    if path.suffix == ".toml" or os.sep in text or os.path.exists(text):
        return read_case(path, changes)
    near = path.with_name(f"{path.stem}.toml")
    if os.path.isfile(near):  # a name without its ending, or with a slip in it
        raise InputError(
            f"there is no case '{_one_line(text, 60)}' in the library; did you mean the file {_one_line(str(near), 60)}?"
        )
    raise InputError(
        f"there is no case '{_one_line(text, 60)}' in the library; {nearest(text, names)} (a file ends in .toml)"
    )


def read_case(path: Path, changes: Mapping[str, Any] | None = None) -> Case:
    """The case in the file ``path``; errors as :func:`load_case`."""
    name = os.fsencode(path.stem).decode(
        "utf-8", "replace"
    )  # the name of a case is text, that of its file any bytes
    return parse_case(
        read_text(path),
        name=clipped(name, MAX_NAME_LENGTH),
        folder=path.parent,
        where=path.name,
        changes=changes,
    )


def parse_case(
    text: str,
    name: str = "case",
    folder: Path = Path(),
    where: str = "case",
    changes: Mapping[str, Any] | None = None,
) -> Case:
    """The case written in ``text``; ``folder`` is where the files it names are looked for,
    ``where`` names it in messages.
    """
    tree = parse_toml(text, where)
    if not tree:
        raise InputError(
            "the case file is empty; it needs at least one of [spring], [lift_law] and [train]",
            where,
        )
    return case_of_tree(tree, name, folder, where, changes, text)


def case_of_tree(
    tree: Mapping[str, Any],
    name: str = "case",
    folder: Path = Path(),
    where: str = "case",
    changes: Mapping[str, Any] | None = None,
    text: str = "",
    published: tuple[PublishedValue, ...] | None = None,
) -> Case:
    """The case of a ``tree`` of tables as its file would hold them; ``text`` is that file, written
    from the tree where there is none. ``published``: values that were read of it before.
    """
    try:
        if changes:
            tree = with_values(tree, changes)
        _refuse_long_integers(tree, "", where)
        bare, notes, bad = split_notes(tree)
        for note_path, reason in bad.items():
            raise _located(text, tuple(note_path.split(".")), reason, where)
        if published is not None:
            bare.pop("published", None)
        with believed():  # the tables have doubted what was written
            model = CaseModel.model_validate(bare, context={"name": name})
            case = model.build(name, folder, notes, text, tuple(changes or ()))
            if published is not None:
                case = replace(case, published=published)
        # A lift law from a file is written out, so that the text alone gives the case again.
        from_file = case.lift_law is not None and "file" in bare["lift_law"]
        return (
            replace(case, text=toml_text(resolved(tree, case.lift_law if from_file else None)))
            if changes or from_file or not text
            else case
        )
    except ValidationError as error:
        raise _located(text, *first_problem(error), where) from None
    except PydanticCustomError as error:
        context = error.context or {}
        raise _located(
            text, tuple(context.get("path", ())), str(context.get("reason", error)), where
        ) from None
    except RecursionError:
        raise InputError("the tables are nested too deeply; flatten them", where) from None
    except ArithmeticError as error:
        raise InputError(
            f"its numbers are too large or too small to compute with ({error}); check them and their units",
            where,
        ) from error


def library_names() -> tuple[str, ...]:
    """Names of the cases that ship with the package."""
    return tuple(sorted(path.stem for path in LIBRARY.glob("*.toml")))


def list_cases() -> tuple[CaseSummary, ...]:
    """One line per library case; what each holds is read from its tables, without building it.

    Returns
    -------
    tuple of CaseSummary: ``name``, ``title``, ``holds`` (tables of the case) and ``sources`` (keys
    of references)

    Raises
    ------
    InputError : a library file that cannot be read

    Examples
    --------
    >>> [summary.name for summary in list_cases() if "gu2021" in summary.sources]
    ['gu2021-beehive', 'gu2021-beehive-blind']
    """
    summaries = []
    for name in library_names():
        tree = parse_toml(read_text(LIBRARY / f"{name}.toml"), name)
        holds = tuple(key for key in ("spring", "lift_law", "train", "published") if key in tree)
        summaries.append(
            CaseSummary(
                name, str(tree.get("title", "")), holds, tuple(map(str, tree.get("sources", ())))
            )
        )
    return tuple(summaries)


def read_text(path: Path, what: str = "case") -> str:
    """The text of the TOML file ``path``, which messages call ``what``; errors as :func:`load_case`."""
    try:
        return bounded_bytes(path, what).decode("utf-8-sig")
    except InputError as error:
        raise InputError(error.reason, _one_line(path.name or str(path), 60)) from None
    except UnicodeDecodeError:
        raise InputError("is no text file; it is TOML in UTF-8", path.name[:60]) from None
    except FileNotFoundError:
        name = _one_line(str(path), 120)
        other = (
            ", or list the library with 'valvetrain cases'" if what == "case" else f" of the {what}"
        )
        raise InputError(f"there is no file '{name}'; check the path{other}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "bad path"
        raise InputError(
            f"the file cannot be read ({reason}); check the path and its permissions",
            _one_line(path.name, 60),
        ) from None


def parse_toml(text: str, where: str, what: str = "case") -> dict[str, Any]:
    """The tree of a TOML text, ``where`` naming it in messages; :class:`InputError` for what is
    none, too deep, of numbers too long, or another kind of file than ``what`` (a key of
    ``KINDS_OF_FILE``).
    """
    if (deep := _DEEP_KEY.search(text)) is not None:
        line = text.count("\n", 0, deep.start()) + 1
        raise InputError(
            f"a key has more than {MAX_PARTS} parts with dots between; write tables",
            f"{where}, line {line}",
        )
    for what_of, most, count in (
        ("keys, tables and lists", MAX_TABLES, sum(1 for _ in _TABLE.finditer(text))),
        ("numbers", MAX_NUMBERS, text.count(",")),
    ):
        if count > most:
            raise InputError(f"has more than {most} {what_of}; leave some out", where)
    try:
        tree = tomllib.loads(text)
        _refuse_long_integers(tree, "", where)
    except RecursionError:
        raise InputError("the values are nested too deeply; flatten them", where) from None
    except ValueError as error:
        if Path(where).suffix.lower() not in ("", ".toml"):
            raise InputError(
                f"is no {what}, which is a TOML file; {KINDS_OF_FILE[what].made}", where
            ) from None
        raise InputError(
            f"is not valid TOML: {_one_line(str(error), 160)}; correct or complete it there", where
        ) from None
    _refuse_other_kind(tree, where, what)
    return tree


@dataclass(frozen=True)
class KindOfFile:
    """A kind of TOML file: keys that it alone has at the top, its command, how it is written."""

    keys: frozenset[str]
    command: str
    made: str


#: Name of a kind of file in messages -> how it differs from the others.
KINDS_OF_FILE = {
    "case": KindOfFile(
        frozenset({"lift_law", "train", "spring"}),
        "run",
        "write one by 'valvetrain new', or make a spring tester's table one by 'valvetrain spring-card'",
    ),
    "identification file": KindOfFile(
        frozenset({"measurements"}), "identify", "docs/identification.md shows one"
    ),
    "optimisation file": KindOfFile(
        frozenset({"objective"}), "optimise", "docs/optimisation.md shows one"
    ),
    "study file": KindOfFile(frozenset({"outputs"}), "study", "docs/studies.md shows one"),
}


def _refuse_other_kind(tree: Mapping[str, Any], where: str, what: str) -> None:
    due = KINDS_OF_FILE[what]
    found = next((name for name, kind in KINDS_OF_FILE.items() if kind.keys & tree.keys()), what)
    if found == what or due.keys & tree.keys() or (found == "case" and "case" in tree):
        return
    article, other = ("an" if name[0] in "io" else "a" for name in (found, what))
    remedy = (
        f"'valvetrain {due.command}' takes {other} {what} that names its case, as in "
        f'case = "{where or "my-engine.toml"}"; {due.made}'
        if found == "case"
        else f"run it by 'valvetrain {KINDS_OF_FILE[found].command}'"
    )
    raise InputError(f"is {article} {found}, not {other} {what}; {remedy}", where)


def _refuse_long_integers(item: Any, path: str, where: str) -> None:
    """TOML knows integers of 64 bits; longer ones, in hexadecimal of any length, cannot even be
    written out.
    """
    if isinstance(item, dict):
        for key, value in item.items():
            _refuse_long_integers(value, f"{path}.{key}" if path else key, where)
    elif isinstance(item, list):
        for value in item:
            _refuse_long_integers(value, path, where)
    elif isinstance(item, int) and not -(2**63) <= item < 2**63:
        raise InputError(
            f"the whole number at '{path}' has more than 64 bits; write a shorter one", where
        )


def _located(text: str, path: tuple[str | int, ...], reason: str, where: str) -> InputError:
    line = find_line(text, path)
    place = where if line is None else f"{where}, line {line}"
    key = _one_line(".".join(str(part) for part in path), 80)
    return InputError(_one_line(reason, 400), ", ".join(filter(None, (place, key))))


def _one_line(text: str, limit: int) -> str:
    clean = " ".join("".join(char if char.isprintable() else " " for char in text).split())
    return clean if len(clean) <= limit else clean[: limit - 3] + "..."
