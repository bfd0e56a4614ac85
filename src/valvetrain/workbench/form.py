"""Forms of a case, generated from the typed tables that read it: fields with unit, limits, help and
source, and the refusal in place.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.parameters.annotations import split_notes
from valvetrain.parameters.case import Case, Note
from valvetrain.parameters.installed_spring import DampingParameters, Guide, Rubbing
from valvetrain.parameters.loading import parse_case, parse_toml
from valvetrain.parameters.overrides import REMOVED, read_assignment
from valvetrain.parameters.schema_blocks import is_card
from valvetrain.parameters.schema_case import CaseModel, OperationModel
from valvetrain.parameters.schema_contact import STEEL
from valvetrain.parameters.schema_installed import (
    CardBlock,
    CoilContactModel,
    WireBlock,
)
from valvetrain.parameters.schema_pair import PairedCard
from valvetrain.parameters.schema_types import StrictModel, Table
from valvetrain.parameters.spring_options import options_table
from valvetrain.parameters.train import PARTS, TrainParameters
from valvetrain.workbench.edits import refuse_foreign_files
from valvetrain.workbench.form_fields import Field, field_of, text_of

#: Spring models whose options a form shows even where the file gives none: the fast one, the rod and, of
#: a wire, the one reduced from it.
_DEFAULT_OPTIONS, _OF_A_WIRE = ("multi-mass", "finite-element"), ("reduced-rod",)
#: Tables of a case that a form leaves to its text.
_LEFT = ("published", "points", "name", "sources", "remarks", "study")
#: Angles of a cam card, in the degrees that its ``angle_of`` names.
CARD_ANGLES = ("duration", "advertised_duration", "upper_duration", "lobe_centre")
_TITLES = {"multi-mass": "chain of masses", "finite-element": "finite-element rod"}


@dataclass(frozen=True, slots=True)
class FieldGroup:
    """Fields of one table of the case file.

    Parameters
    ----------
    key : key path of the table, empty for the head of the file
    title : words for people
    fields : the fields in the order of the tables that read them
    """

    key: str
    title: str
    fields: tuple[Field, ...]


def fields(case: Case | str) -> list[FieldGroup]:
    """The form of a case, or of the text of one (TOML): a group for each table that it has.

    Raises :class:`InputError` for a text that is no TOML.

    >>> groups = fields("[spring]\\nwire_diameter = '4 mm'")
    >>> next(one for one in groups[1].fields if one.key == "spring.wire_diameter").number
    4.0
    """
    text = case.text if isinstance(case, Case) else case
    bare, notes, _ = split_notes(parse_toml(text, "case"))
    form = _Form(bare, notes)
    return [group for group in form.groups() if group.fields]


def check(case_text: str, key: str, value_text: str, folder: Path = Path()) -> str | None:
    """The refusal of ``value_text`` at ``key`` as one sentence, None where it is accepted.

    Parameters
    ----------
    case_text : the case (TOML)
    key : key path
    value_text : the value as ``--set`` takes it, empty to remove the key
    folder : of the files that the case names

    >>> check("[lift_law]\\nkind = 'zero'", "operation.cycles", "0")
    'cycles must be a whole number from 1 to 10000'
    """
    try:
        read_change(case_text, key, value_text, folder)
    except InputError as error:
        place = error.where.rpartition(", ")[2]
        return (
            error.reason
            if place in ("", "case") or place == key or key.startswith(f"{place}.")
            else f"{place}: {error.reason}"
        )
    return None


def read_change(
    case_text: str, key: str, value_text: str, folder: Path = Path(), where: str = "case"
) -> tuple[str, Any, Case]:
    """The change as the reader takes it: key path, value, and the changed case.

    A value that only reads as text, such as the title ``24``, is taken as text. Raises
    :class:`InputError` with the reader's sentence.
    """
    path, value = read_assignment(f"{key}={value_text}", key)
    refuse_foreign_files(case_text, {path: value})
    try:
        return path, value, parse_case(case_text, where, folder, where, {path: value})
    except InputError:
        if value is REMOVED or isinstance(value, str):
            raise
        with_text = None
        try:
            with_text = parse_case(case_text, where, folder, where, {path: value_text.strip()})
        except InputError:
            pass
        if with_text is None:
            raise
        return path, value_text.strip(), with_text


class _Form:
    """Walks the bare tree of a case and the tables that read it."""

    def __init__(self, tree: Mapping[str, Any], notes: Mapping[str, Note]) -> None:
        self.tree, self.notes = tree, notes

    def groups(self) -> Iterator[FieldGroup]:
        """Every group, in the order of a file."""
        yield self.group("", "Case", CaseModel, self.tree, ("title", "description"))
        if "spring" in self.tree:
            yield from self.springs("spring", self.tree["spring"], "Spring")
        if isinstance(self.tree.get("spring"), list):
            yield self.group(
                "rubbing",
                "Friction between the springs",
                Rubbing,
                self.tree.get("rubbing", {}),
            )
        law = self.tree.get("lift_law")
        if isinstance(law, dict) and law.get("kind") in registry.names("lifts"):
            yield self.group("lift_law", "Lift law", registry.find("lifts", law["kind"]).table, law)
        yield self.group("operation", "Operation", OperationModel, self.tree.get("operation", {}))
        if isinstance(self.tree.get("train"), dict):
            yield from self.train(self.tree["train"])

    def train(self, table: Mapping[str, Any]) -> Iterator[FieldGroup]:
        """Groups of a train: its own values, its parts, contacts, springs and variants."""
        yield self.group("train", "Train", TrainParameters, table)
        for name, model in PARTS.items():
            if name != "variants" and (name in table or name == "follower"):
                yield self.group(
                    f"train.{name}", text_of(name).capitalize(), model, table.get(name, {})
                )
        contacts = table.get("contacts")
        named = (
            {"": contacts}
            if isinstance(contacts, str)
            else contacts
            if isinstance(contacts, dict)
            else {}
        )
        yield FieldGroup(
            "train.contacts",
            "Contacts",
            tuple(_steel(place, word) for place, word in named.items() if isinstance(word, str)),
        )
        for place, one in contacts.items() if isinstance(contacts, dict) else ():
            if isinstance(one, dict) and one.get("law") in registry.names("contacts"):
                law = registry.find("contacts", one["law"]).table
                yield self.group(
                    f"train.contacts.{place}", f"Contact at the {text_of(place)}", law, one
                )
        sets = table.get("springs")
        for name, springs in sets.items() if isinstance(sets, dict) else ():
            yield from self.springs(f"train.springs.{name}", springs, f"Spring set {name}")
        if isinstance(sets, dict) and any(
            isinstance(one, list) and len(one) > 1 for one in sets.values()
        ):
            yield self.group(
                "train.rubbing",
                "Friction between the springs",
                Rubbing,
                table.get("rubbing", {}),
            )
        for number, variant in enumerate(
            table.get("variants", ()) if isinstance(table.get("variants"), list) else ()
        ):
            yield self.group(
                f"train.variants.{number}", f"Variant {number + 1}", PARTS["variants"], variant
            )

    def springs(self, key: str, raw: Any, title: str) -> Iterator[FieldGroup]:
        """Groups of one spring, or of each of two."""
        if isinstance(raw, dict):
            yield from self.spring(key, raw, title)
            return
        entries = (
            [entry for entry in raw if isinstance(entry, dict)] if isinstance(raw, list) else []
        )
        for place, entry in enumerate(entries):
            whose = f", {('outer', 'inner')[place]}" if len(entries) == 2 else ""
            yield from self.spring(f"{key}.{place}", entry, f"{title}{whose}")

    def spring(self, key: str, raw: Mapping[str, Any], title: str) -> Iterator[FieldGroup]:
        """The block of a spring, its damping, contact, guide and options."""
        by_card = is_card(raw)
        card = PairedCard if "loads_of" in raw else CardBlock
        yield self.group(key, title, card if by_card else WireBlock, raw)
        yield self.group(
            f"{key}.damping", f"{title}: damping", DampingParameters, raw.get("damping", {})
        )
        yield self.group(
            f"{key}.contact",
            f"{title}: contact of its coils",
            CoilContactModel,
            raw.get("contact", {}),
        )
        if not by_card and isinstance(raw.get("guide"), dict):
            yield self.group(f"{key}.guide", f"{title}: guide", Guide, raw["guide"])
        given = raw.get("options")
        options: Mapping[str, Any] = given if isinstance(given, dict) else {}
        own = (word for word in options if word in registry.names("springs"))
        for word in dict.fromkeys((*own, *_DEFAULT_OPTIONS, *(() if by_card else _OF_A_WIRE))):
            table = options_table(word)
            useless = table.wire_only if by_card else table.card_only
            name = _TITLES.get(word, word.replace("-", " "))
            yield self.group(
                f"{key}.options.{word}",
                f"{title}: {name}",
                table,
                options.get(word, {}),
                without=useless,
            )

    def group(
        self,
        key: str,
        title: str,
        model: type[StrictModel | Table],
        raw: Any,
        only: tuple[str, ...] = (),
        without: tuple[str, ...] = (),
    ) -> FieldGroup:
        """The plain values of one table."""
        table: Mapping[str, Any] = raw if isinstance(raw, dict) else {}
        found = []
        for name, info in model.model_fields.items():
            if (only and name not in only) or name in without or (not key and name in _LEFT):
                continue
            path = f"{key}.{name}" if key else name
            if (made := field_of(path, name, info, table.get(name))) is not None:
                if name in CARD_ANGLES and table.get("angle_of") in ("cam", "crank"):
                    made = replace(made, label=f"{made.label} in {table['angle_of']} degrees")
                sets = self.tree.get("train", {}).get("springs", {}) if name == "spring_set" else {}
                source = self.source(path) if made.value_text else ""
                found.append(replace(made, choices=tuple(sets) or made.choices, source=source))
        return FieldGroup(key, title, tuple(found))

    def source(self, path: str) -> str:
        """Status and source of a value: its own note, else that of its table."""
        parts = path.split(".")
        for length in range(len(parts), 0, -1):
            note = self.notes.get(".".join(parts[:length]))
            if note is not None:
                return ": ".join(part for part in (str(note.status or ""), note.source) if part)
        return ""


def _steel(place: str, word: str) -> Field:
    """A contact, or all of them, given by one word."""
    key = f"train.contacts.{place}".rstrip(".")
    label, hint = (
        f"contact at the {text_of(place)}" if place else "all contacts",
        "contact stiffness: default steel values; or a table for each contact",
    )
    return Field(key, label, "text", word, help=hint, choices=(STEEL,))
