"""The whole case file as one model, and the :class:`Case` it makes."""

from __future__ import annotations

import hashlib
import re
import threading
from collections import OrderedDict
from collections.abc import Container
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, ValidationInfo, field_validator

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.parameters.bounded_file import bounded_bytes, named_file
from valvetrain.parameters.case import Case, Limits, Note, Operation, point_problem
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.installed_spring import Rubbing
from valvetrain.parameters.lift_law import LiftField, LiftLawParameters, LiftModel
from valvetrain.parameters.schema_types import (
    AngularSpeed,
    CaseName,
    Line,
    Name,
    Prose,
    StrictModel,
    guarded,
    problem,
    quantity,
    validate_as,
)
from valvetrain.parameters.spring_blocks import CaseSprings
from valvetrain.parameters.train import TrainParameters
from valvetrain.solution.definition import definition_of
from valvetrain.solution.provenance import PublishedValue, Role
from valvetrain.units import PlainNumber, dimension_of, parse_quantity

#: Number before the unit of a value.
_NUMBER = re.compile(r"[-+.\d]+\s*(?:[eE][-+]?\d+)?")


class ValueModel(StrictModel):
    """One number, with how firmly it is stated, how near a computed one should be, and what it was
    used for.
    """

    value: Any
    relation: Literal["equal", "about", "at-most", "at-least"] = "equal"
    tolerance: Any = None
    origin: Line = ""
    role: Role | None = None
    used_for: Prose = ""
    doubt: Prose = ""
    reading: Prose = ""

    def read(self, quantity: str) -> dict[str, Any]:
        """SI ``value``, the ``unit`` it was written in and the SI ``tolerance``, which is given in per cent or
        in the same dimension, of the ``quantity``.
        """
        dimension = definition_of(quantity).dimension or None
        value = guarded(parse_quantity, self.value, dimension, path=("value",))
        unit, tolerance = _NUMBER.sub("", str(self.value).strip(), count=1).strip(), self.tolerance
        if isinstance(tolerance, str) and tolerance.strip().endswith("%"):
            share = guarded(parse_quantity, tolerance, "ratio", path=("tolerance",))
            tolerance = abs(value) * share
        elif tolerance is not None:
            due = dimension or dimension_of(unit)
            tolerance = guarded(parse_quantity, tolerance, due, path=("tolerance",))
            if tolerance < 0:
                raise problem("a tolerance is zero or more", ("tolerance",))
        return {"quantity": quantity, "value": value, "unit": unit, "tolerance": tolerance}


def _read_value(raw: Any) -> ValueModel:
    return validate_as(ValueModel, raw if isinstance(raw, dict) else {"value": raw})


class PublishedModel(StrictModel):
    """One group of published values."""

    model: Name
    role: Role
    source: Line
    origin: Line = ""
    engine_speed: AngularSpeed | None = None
    reading: Prose = ""
    quantities: dict[str, Annotated[ValueModel, PlainValidator(_read_value)]]

    def build(self) -> tuple[PublishedValue, ...]:
        """The flat list of values, each with what is said of the group where it says nothing itself; raises a
        located problem.
        """
        shared = self.model_dump(exclude={"quantities"})
        return tuple(
            PublishedValue(
                **shared
                | entry.model_dump(exclude_defaults=True, exclude={"value"})
                | guarded(entry.read, name, path=("quantities", name))
            )
            for name, entry in self.quantities.items()
        )


#: Size of the cache of lift laws read from files.
MAX_CACHED = 8
_Key = tuple[type[LiftModel], str, tuple[str, ...], bytes]
_cache: OrderedDict[_Key, LiftLawParameters] = OrderedDict()
_turn = threading.Lock()


def parameters_of(law: LiftModel, folder: Path) -> LiftLawParameters:
    """What the table of a ``law`` says, with the files that it names in ``folder``; one that was
    read from the same bytes before is cached.

    Raises what the table itself raises, which is never cached.
    """
    name = getattr(law, "file", None)
    if not isinstance(name, str):
        return law.parameters(folder)
    key = _key(law, folder, name)
    with _turn:
        if key is not None and key in _cache:
            _cache.move_to_end(key)
            return _cache[key]
    found = law.parameters(folder)
    if key is not None and key == _key(
        law, folder, name
    ):  # the file stayed the same while it was read
        with _turn:
            _cache[key] = found
            while len(_cache) > MAX_CACHED:
                _cache.popitem(last=False)
    return found


def _key(law: LiftModel, folder: Path, name: str) -> _Key | None:
    """The words of a law and the content of its file ``name``; None where that cannot be read."""
    if not type(law).__module__.startswith("valvetrain."):
        return None  # a law of somebody else may read more than this file
    try:
        content = bounded_bytes(named_file(folder, name), "lift table")
    except (InputError, OSError, ValueError):
        return None
    return (
        type(law),
        repr(law),
        tuple(sorted(law.model_fields_set)),
        hashlib.sha256(content).digest(),
    )


CoilNumber = Annotated[float, quantity("ratio", low=0.0)]


#: What a lift law lends to the train: its name there, table and key of the train, keys that go before it.
_LENT: tuple[tuple[str, str, str, set[str]], ...] = (
    ("lash", "", "lash", {"lash"}),
    ("rocker_ratio", "lever", "ratio", {"ratio", "valve_arm"}),
    ("dead_centre", "crank", "top_dead_centre", {"top_dead_centre", "lobe_centre"}),
)


def lend(tree: Any, law: Any, kept: Container[str] = ()) -> None:
    """Give the train of a case file what it had from a ``law`` that is to be another; ``kept``: keys that the next has too."""
    train = tree.get("train", {})
    for name, part, key, given in _LENT:
        table = train.get(part, {}) if part else train
        if name in law and name not in kept and table and not given & set(table):
            table[key] = law[name]


class CaseModel(StrictModel):
    """The whole file."""

    name: CaseName | None = None
    title: Line = ""
    description: Prose = ""
    study: str = ""
    sources: list[Line] = Field(default_factory=list)
    remarks: list[Prose] = Field(default_factory=list)
    spring: CaseSprings = ()
    rubbing: Rubbing = Rubbing()
    lift_law: LiftField | None = None
    operation: Operation = Operation()
    limits: Limits = Limits()
    train: TrainParameters | None = None
    points: dict[str, CoilNumber] = Field(default_factory=dict)
    published: list[PublishedModel] = Field(default_factory=list)

    @field_validator("rubbing", mode="before")
    @classmethod
    def _two_springs_rub(cls, raw: Any, info: ValidationInfo) -> Any:
        if raw and len(info.data.get("spring", ())) < 2:
            raise problem(
                "rubbing acts between two nested springs; remove it (a train has [train.rubbing])"
            )
        return raw

    @field_validator("train", mode="before")
    @classmethod
    def _with_cam_card(cls, raw: Any, info: ValidationInfo) -> Any:
        """A train with the ``lash``, ``rocker_ratio`` and dead centre of its lift law where it gives none. Another lash in
        the train is one that was set beside the card's, for which the cam is cut.
        """
        if not isinstance(raw, dict):
            return raw
        train = dict(raw)
        for name, part, key, given in _LENT:
            value = getattr(info.data.get("lift_law"), name, None)
            table = train.get(part) if part else train
            if value is not None and isinstance(table, dict) and not given & table.keys():
                lent = {**table, key: PlainNumber(value)}
                train = train | {part: lent} if part else lent
        return train

    def _law_of(self, train: TrainParameters) -> LiftModel | None:
        """The law of a ``train``; a cam card over a bucket tappet, which moves the valve itself, has ``rocker_ratio`` 1.

        A card that contradicts its train is refused with its own place.
        """
        law = self.lift_law
        ratio = getattr(law, "rocker_ratio", None)
        if law is None:
            return None
        if train.kind == "direct" and "rocker_ratio" in type(law).model_fields:
            if ratio not in (None, 1.0):
                raise problem(
                    f"a bucket tappet has no rocker, but rocker_ratio is {ratio:g}; leave it out",
                    ("lift_law", "rocker_ratio"),
                )
            return law.model_copy(update={"rocker_ratio": 1.0})
        made = None if train.lever is None else train.lever.valve_arm / train.lever.drive_arm
        if ratio is not None and made is not None and abs(made / ratio - 1) > 0.02:
            raise problem(
                f"rocker_ratio is {ratio:g} here, but the lever's arms make {made:.4g}; correct one, or leave valve_arm out",
                ("lift_law", "rocker_ratio"),
            )
        return law

    def build(
        self,
        name: str,
        folder: Path,
        notes: dict[str, Note],
        text: str = "",
        changed: tuple[str, ...] = (),
    ) -> Case:
        """The case; ``folder`` is where relative file names start. Raises a located problem for
        tables that contradict each other.
        """
        if not self.spring and self.lift_law is None and self.train is None:
            raise problem(
                "the case is empty; it needs at least one of [spring], [lift_law] and [train]"
            )
        if self.spring and self.train is not None:
            raise problem(
                "a train carries its springs in [train.springs], so this one would stay unused; move it there",
                ("spring",),
            )
        known = registry.names("sources")
        if self.study and known and self.study not in known:
            raise problem(
                f"study '{self.study[:40]}' is unknown; {nearest(self.study, known)}", ("study",)
            )
        refused = point_problem(self.study, self.points, self.spring)
        if refused is not None:
            raise problem(refused[1], ("points", *filter(None, refused[:1])))
        law = self.lift_law if self.train is None else self._law_of(self.train)
        published = (
            guarded(group.build, path=("published", index))
            for index, group in enumerate(self.published)
        )
        return Case(
            name=self.name or name,
            title=self.title,
            description=self.description,
            springs=self.spring,
            rubbing=self.rubbing,
            lift_law=guarded(parameters_of, law, folder, path=("lift_law",)) if law else None,
            operation=self.operation,
            limits=self.limits,
            train=self.train,
            published=tuple(value for group in published for value in group),
            notes=notes,
            sources=tuple(self.sources),
            remarks=tuple(self.remarks),
            study=self.study,
            points=self.points,
            text=text,
            changed=changed,
        )
