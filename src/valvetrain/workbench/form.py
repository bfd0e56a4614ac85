"""Forms of a case, generated from the typed tables that read it: fields with unit, limits, help and source, and the refusal in place."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from valvetrain.parameters.case import Case

FieldKind = Literal["number", "text", "choice", "flag", "curve"]


@dataclass(frozen=True, slots=True)
class Field:
    """One value of a case.

    Parameters
    ----------
    key : key path, as ``--set`` and :meth:`Workspace.set_value` take it
    label : words of the key
    kind : ``number`` (with a unit), ``text``, ``choice`` (one of ``choices``), ``flag`` (true, false), ``curve`` (over the coils)
    value_text : as written in the file, empty where it is left out
    unit : usual unit, in which ``limits`` are told
    limits : lowest and highest value in ``unit``, None for none
    help : what it means
    source : where the value comes from (status and source of its note)
    required : the case cannot be read without it
    default_text : what holds where it is left out
    choices : words of a ``choice``
    number : the value in ``unit``, for a slider; None where it is no single number
    slides : a slider makes sense
    """

    key: str
    label: str
    kind: FieldKind
    value_text: str
    unit: str = ""
    limits: tuple[float | None, float | None] = (None, None)
    help: str = ""
    source: str = ""
    required: bool = False
    default_text: str = ""
    choices: tuple[str, ...] = ()
    number: float | None = None
    slides: bool = False


@dataclass(frozen=True, slots=True)
class FieldGroup:
    """Fields of one table of the case file.

    Parameters
    ----------
    key : key path of the table, empty for the head of the file
    title : words for people
    fields : the fields, those that the file gives first
    """

    key: str
    title: str
    fields: tuple[Field, ...]


def fields(case: Case) -> list[FieldGroup]:
    """The form of a case: a group for each table that it has."""
    return []


def check(case_text: str, key: str, value_text: str, folder: Path = Path()) -> str | None:
    """The refusal of ``value_text`` at ``key`` as one sentence, None where it is accepted; ``folder``: of the files that the case names."""
    return None
