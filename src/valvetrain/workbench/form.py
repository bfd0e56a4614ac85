"""Forms of a case, generated from the typed tables that read it: groups of fields with what is
written, and the tables that the case may get.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, get_origin

from pydantic.fields import FieldInfo

from valvetrain import registry
from valvetrain.parameters.curves import FormulaForm, HeightForm, KnotsForm
from valvetrain.parameters.installed_spring import CoilContact, InstalledSpring
from valvetrain.parameters.lift_law import LiftModel
from valvetrain.parameters.loading import parse_toml
from valvetrain.parameters.overrides import split_notes
from valvetrain.parameters.schema_case import CaseModel
from valvetrain.parameters.schema_contact import STEEL, ContactParameters, ContactTable
from valvetrain.parameters.schema_types import StrictModel, Table
from valvetrain.parameters.spring_blocks import fields_of
from valvetrain.parameters.winding import EndCoil
from valvetrain.springs.spec import spring_model
from valvetrain.workbench.form_fields import Field, field_of, parts_of, words_of
from valvetrain.workbench.starts import STARTS

Model = type[StrictModel | Table]
#: Keys of a case that a form leaves to its text.
LEFT = ("published", "points", "name", "sources", "remarks", "study")
#: Tables that a form has as one value.
VALUES = (EndCoil, FormulaForm, HeightForm, KnotsForm)
#: Table that another one of the registry reads -> key whose word names that one, its kind there, and the
#: table for any other word.
NAMED: dict[Any, tuple[str, str, Model]] = {
    LiftModel: ("kind", "lifts", LiftModel),
    ContactParameters: ("law", "contacts", ContactTable),
}
#: Spring models whose options a form shows even where the file gives none; the last is of a wire alone.
SHOWN_OPTIONS = ("multi-mass", "finite-element", "reduced-rod")
#: Angles of a cam card, in the degrees that its ``angle_of`` names.
CARD_ANGLES = ("duration", "advertised_duration", "upper_duration", "lobe_centre")


@dataclass(frozen=True, slots=True)
class Group:
    """Fields of one table of the case file.

    Parameters
    ----------
    key : key path of the table, empty for the head of the file
    title : words for people
    fields : the fields in the order of the table that reads them
    removable : the case may lose the table again
    """

    key: str
    title: str
    fields: tuple[Field, ...]
    removable: bool = False


@dataclass(frozen=True, slots=True)
class Addition:
    """A table that a case may get: its key path, words for a button, and what it is."""

    key: str
    label: str
    help: str


class CaseForm:
    """The form of a case: ``groups``, a :class:`Group` for each table that it has, and ``additions``, an
    :class:`Addition` for each that it may get.

    Parameters
    ----------
    text : the case (TOML); raises :class:`InputError` for what is none
    files : names that a field for a file suggests

    >>> form = CaseForm("[spring]\\nwire_diameter = '4 mm'")
    >>> next(field for field in form.groups[1].fields if field.key == "spring.wire_diameter").number
    4.0
    """

    def __init__(self, text: str, files: Sequence[str] = ()) -> None:
        self.groups: list[Group] = []
        self.additions: list[Addition] = []
        self._tree, self._notes, _ = split_notes(parse_toml(text, "case"))
        self._files = tuple(files)
        self._add("", "Case", CaseModel.model_fields, self._tree)

    def _add(
        self,
        key: str,
        title: str,
        model: Mapping[str, FieldInfo],
        raw: Any,
        without: Sequence[str] = (),
    ) -> None:
        """The group of one table with the fields of its ``model``, then those of the tables in it; ``without``: keys
        that do nothing here.
        """
        given: Mapping[str, Any] = raw if isinstance(raw, Mapping) else {}
        fields, tables = [], []
        for name, info in model.items():
            path = f"{key}.{name}".lstrip(".")
            if path in LEFT or name in without:
                continue
            if (kind := _table_in(info)) is None and name != "options":
                fields.append(self._field(path, info, given))
            else:
                tables.append((path, info, kind))
        if fields:
            optional = (key.endswith(".1") and "damping" in model) or key.rpartition(".")[2] in (
                *STARTS,
                "rubbing",
            )
            self.groups.append(Group(key, title, tuple(fields), raw is not None and optional))
        whose = "" if key in ("", "train") else f"{title}: "
        for path, info, kind in tables:
            name = path.rpartition(".")[2]
            value = given.get(name)
            if name == "options":
                self._add_options(path, whose, "preload" in model, value or {})
            elif isinstance(value, Mapping) and any(
                get_origin(part) in (dict, Mapping) for part in parts_of(info.annotation)
            ):
                for word, entry in value.items():
                    heading = f"{name.removesuffix('s')} {words_of(word)}"
                    self._add_entry(f"{path}.{word}", heading, kind, entry)
            elif value is None and not isinstance(info.default, (StrictModel, Table)):
                if name in STARTS and (name != "spring" or "train" not in given):
                    self._offer(path, f"{whose}{STARTS[name].label}", STARTS[name].help)
            elif name != "rubbing" or value is not None or _has_two_springs(given):
                self._add_entry(path, f"{whose}{words_of(name)}", kind, value)

    def _add_entry(self, key: str, title: str, kind: Any, raw: Any) -> None:
        """The groups of what stands at ``key``: a table, a list of tables, or a word in place of one."""
        title = _capitalized(title)
        if isinstance(raw, str):
            hint = "default steel values; or a table for each contact"
            field = Field(key, title, "text", raw, help=hint, choices=(STEEL,))
            self.groups.append(Group(key, title, (field,)))
            return
        rows = raw if isinstance(raw, list) else [raw]
        for place, row in enumerate(rows):
            which = ("outer", "inner")[place] if kind is InstalledSpring else place + 1
            self._add(
                f"{key}.{place}" if isinstance(raw, list) else key,
                f"{title}, {which}" if len(rows) > 1 else title,
                _model_of(kind, row if isinstance(row, Mapping) else {}),
                row,
            )
        if kind is InstalledSpring and len(rows) == 1:
            self._offer(f"{key}.1", f"Second {title.lower()}", "a spring inside the first")

    def _add_options(self, key: str, whose: str, by_card: bool, given: Mapping[str, Any]) -> None:
        """The groups of the options of spring models, of a spring known ``by_card`` or by its wire."""
        shown = SHOWN_OPTIONS[:-1] if by_card else SHOWN_OPTIONS
        for word in dict.fromkeys((*given, *shown)):
            if word in registry.names("springs"):
                table = registry.find("springs", word).options
                title = f"{whose}{spring_model(word).label}"
                useless = table.wire_only if by_card else table.card_only
                self._add(f"{key}.{word}", title, table.model_fields, given.get(word), useless)

    def _offer(self, key: str, label: str, hint: str) -> None:
        self.additions.append(Addition(key, _capitalized(label), hint))

    def _field(self, key: str, info: FieldInfo, given: Mapping[str, Any]) -> Field:
        """One field, with the words that only this case knows."""
        name = key.rpartition(".")[2]
        made = field_of(key, info, given.get(name), self._source(key))
        if name in CARD_ANGLES and given.get("angle_of") in ("cam", "crank"):
            made = replace(made, label=f"{made.label} in {given['angle_of']} degrees")
        if name == "spring_set":
            made = replace(made, choices=tuple(self._tree["train"].get("springs", ())))
        return replace(made, choices=self._files) if name == "file" else made

    def _source(self, key: str) -> str:
        """Status and source of a value: its own note, else that of its table."""
        parts = key.split(".")
        for length in range(len(parts), 0, -1):
            note = self._notes.get(".".join(parts[:length]))
            if note is not None:
                return ": ".join(part for part in (str(note.status or ""), note.source) if part)
        return ""


def _table_in(info: FieldInfo) -> Any:
    """The type of the table that a field holds, one or several; None for a value."""
    for part in parts_of(info.annotation):
        if part in (InstalledSpring, ContactParameters):
            return part
        if isinstance(part, type) and issubclass(part, (StrictModel, Table)) and part not in VALUES:
            return part
    return None


def _model_of(kind: Any, given: Mapping[str, Any]) -> Mapping[str, FieldInfo]:
    """The fields of the table that reads what is ``given``, of a spring and a law by what it says."""
    if kind is InstalledSpring:
        return fields_of(given)
    if kind is CoilContact:
        return CoilContact.fields_of(given)
    key, group, model = NAMED.get(kind, ("", "", kind))
    if group and given.get(key) in registry.names(group):
        model = getattr(registry.find(group, given[key]), "table", model)
    fields: Mapping[str, FieldInfo] = model.model_fields
    return fields


def _has_two_springs(given: Mapping[str, Any]) -> bool:
    """Whether a case or a train has springs of which one is inside the other."""
    sets = (given.get("spring"), *dict(given.get("springs", {})).values())
    return any(isinstance(springs, list) and len(springs) > 1 for springs in sets)


def _capitalized(words: str) -> str:
    return words[:1].upper() + words[1:]
