"""A case: everything that defines one study, frozen, in SI, with the source and status of its
values.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from copy import copy
from dataclasses import InitVar, dataclass, field, fields, is_dataclass, replace
from enum import Enum
from numbers import Real
from typing import Annotated, Any, Literal, get_args

import numpy as np
from pydantic import Field, StrictInt

from valvetrain import registry
from valvetrain.errors import FrozenMapping, InputError
from valvetrain.parameters.changes import differences, nearest
from valvetrain.parameters.installed_spring import (
    CoilContact,
    DampingParameters,
    InstalledSpring,
    Rubbing,
)
from valvetrain.parameters.lift_law import LiftLawParameters
from valvetrain.parameters.own_parts import part_digest
from valvetrain.parameters.schema_types import (
    AngularSpeed,
    PositiveLength,
    Table,
    guarded,
    problem,
    quantities,
    quantity,
    table,
)
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.train import TrainParameters
from valvetrain.solution.force_peak import FORCE_BANDWIDTH
from valvetrain.solution.provenance import CaseRecord, PublishedValue
from valvetrain.units import MAX_SPEEDS, format_quantity, si

#: Fields of a case that change none of its numbers.
_TEXTS = (
    "name", "title", "description", "notes", "sources", "remarks", "published", "text", "changed", "limits",
)  # fmt: skip
#: Fields of its parts that change none where the case does not give them.
_NO_NUMBER = (
    "permitted_seating_velocity", "face_diameter", "red_line", "force_bandwidth", "replica", "stated_solid_height", "top_dead_centre",
)  # fmt: skip


def content(item: Any, exact: bool = True) -> bytes:
    """Frozen parameters as bytes, numbers to the last bit, or to 12 digits where not ``exact``."""
    return b"\0".join(_parts(item, exact))


def _parts(item: Any, exact: bool) -> Iterator[bytes]:
    if isinstance(item, (bool, str, bytes, Enum, type(None))):
        yield repr(item).encode()
    elif isinstance(item, (float, int, np.number)):
        # a whole number and the same float are one value
        yield (float(item).hex() if exact else f"{float(item) + 0.0:.12g}").encode()
    elif isinstance(item, np.ndarray):
        yield str(item.shape).encode()
        for number in item.ravel().tolist():
            yield from _parts(number, exact)
    elif is_dataclass(item) and not isinstance(item, type):
        yield type(item).__name__.encode()
        for one in fields(item):
            unsaid = one.name in _NO_NUMBER and getattr(item, one.name) == one.default
            if one.compare and (exact or not (unsaid or one.name == "name")):
                yield one.name.encode()
                yield from _parts(getattr(item, one.name), exact)
    elif isinstance(item, Mapping):
        for key in sorted(item, key=str):
            yield str(key).encode()
            yield from _parts(item[key], exact)
        yield b"}"
    elif isinstance(item, (tuple, list)):
        for one in item:
            yield from _parts(one, exact)
        yield b"]"
    elif callable(item):
        yield part_digest(item).encode()
    else:
        yield repr(item).encode()


def point_problem(
    study: str, points: Mapping[str, float], springs: Iterable[InstalledSpring]
) -> tuple[str, str] | None:
    """Why ``points`` (name -> coil number) cannot be read: the name of the first that cannot, empty
    for all, and a sentence.

    None where all can: their ``study`` names each, and each is between the lower tip and the end
    of the shortest wire.
    """
    if not points:
        return None
    if not study:
        return (
            "",
            "the points are those that a published study reads; name it in 'study', or remove them",
        )
    names = tuple(registry.find("sources", study).points)
    coils = min(
        (spring.wire.total_coils for spring in springs if spring.wire is not None), default=math.inf
    )
    for name, coil in points.items():
        if name not in names:
            changed_keys = nearest(name, names) if names else "it names none; remove them"
            return name, f"study '{study}' reads no point '{name[:40]}'; {changed_keys}"
        if isinstance(coil, bool) or not isinstance(coil, Real) or not math.isfinite(coil):
            return name, f"{coil!r} is no coil number; give a number of coils from the lower tip"
        if not 0 <= coil <= coils:
            return (
                name,
                f"coil {coil:g} is beyond the wire of {coils:g} coils; give a number from 0 to {coils:g}",
            )
    return None


__all__ = [
    "Case", "CaseSummary", "CoilContact", "DampingParameters", "InstalledSpring", "LiftLawParameters", "Limits",
    "Note", "Operation", "PublishedValue", "Rubbing",
]  # fmt: skip

ValueStatus = Literal["measured", "published", "assumed", "identified"]
STATUSES: tuple[str, ...] = get_args(ValueStatus)
#: Fields of a case that are words about it.
_WORDS = ("name", "title", "description", "text", "changed")


@dataclass(frozen=True, slots=True)
class Note:
    """Where a value comes from: ``status`` and ``source`` (key of the references, then the place)."""

    status: ValueStatus | None = None
    source: str = ""


AngularSpeeds = Annotated[tuple[float, ...], quantities("angular speed")]
OutputStep = Annotated[float, quantity("angle", low=1e-4, high=0.5)]
ForceBandwidth = Annotated[float, quantity("frequency", low=100.0, high=50e3)]


@table("the operation")
class Operation(Table):
    """What is run: ``engine_speeds`` (rad/s of the crank, twice the cam's), ``cycles`` (cam
    revolutions of a spring alone, the last is reported; None: until the motion repeats),
    ``output_step`` (cam rad) between stored values, ``red_line`` (rad/s of the crank), the highest
    speed in use, and ``force_bandwidth`` (Hz), below which the peak of a spring's force is taken.
    """

    engine_speeds: AngularSpeeds = ()
    cycles: StrictInt | None = Field(
        default=None,
        description="cam revolutions run, the last is reported: until the motion repeats, at most 40, with finite elements at most 8",
    )
    output_step: OutputStep = Field(
        default=math.radians(0.5), description="cam angle between stored values"
    )
    red_line: AngularSpeed | None = Field(
        default=None,
        description="highest engine speed in use, of the crank: a sweep says how far control reaches beyond it",
    )
    force_bandwidth: ForceBandwidth = Field(
        default=FORCE_BANDWIDTH,
        description="cut-off below which the peak of a spring's force is taken, such as that of a load cell",
    )
    cam_speeds: InitVar[AngularSpeeds | None] = None

    def __post_init__(self, cam_speeds: tuple[float, ...] | None) -> None:
        if self.engine_speeds and cam_speeds is not None:
            raise problem(
                "engine_speeds and cam_speeds are both given; give one (an engine speed is twice the cam speed)",
                ("cam_speeds",),
            )
        speeds = self.engine_speeds or tuple(2 * speed for speed in cam_speeds or ())
        if any(speed <= 0 for speed in speeds):
            raise problem("a speed must be positive; correct the list")
        if len(speeds) > MAX_SPEEDS:
            raise problem(f"there are more than {MAX_SPEEDS} speeds; take a larger step")
        object.__setattr__(self, "engine_speeds", tuple(dict.fromkeys(speeds)))
        if self.red_line is not None:
            in_rpm = format_quantity(self.red_line, "rpm", 12)
            guarded(si, in_rpm, "engine_speed", path=("red_line",))
        if self.cycles is not None and not 1 <= self.cycles <= 10_000:
            raise problem("cycles must be a whole number from 1 to 10000", ("cycles",))

    def replace(self, **changes: Any) -> Operation:
        """A copy with fields changed; what stays was read before and is not doubted again."""
        given, changed = Operation(**changes), copy(self)
        for name in changes:
            object.__setattr__(changed, name, getattr(given, name))
        return changed

    @property
    def top_speed(self) -> float:
        """The red line (rad/s), else the highest engine speed; 0 where neither is given."""
        return self.red_line or max(self.engine_speeds, default=0.0)


@table("the limits")
class Limits(Table):
    """What a shop accepts on its spin rig: ``bounce`` of the valve off its seat and ``loft``, the gap of an open contact (m).
    They judge results and move nothing.
    """

    bounce: PositiveLength | None = Field(default=None, description="without it 0.1 mm")
    loft: PositiveLength | None = Field(default=None, description="without it none")


@dataclass(frozen=True, slots=True)
class CaseSummary:
    """One line of the case library."""

    name: str
    title: str
    holds: tuple[str, ...] = ()
    sources: tuple[str, ...] = ()


@dataclass(frozen=True)
class Case:
    """Everything that defines a study; SI throughout.

    ``springs``: one or two, outer first, under prescribed motion of their retainer; a ``train``
    holds its own. ``study``: name of the published study that the case re-runs. ``points``: coil
    numbers at which its points on the wire are read, by their names, where they are others than the
    study's. ``text``: the case file as resolved, with what was changed from outside; read again it
    gives an equal case. ``changed``: key paths that were set from outside the file. Text and
    changes take no part in comparisons.

    >>> import valvetrain as vt
    >>> case = vt.load_case("job-t")
    >>> slow = case.replace(operation=case.operation.replace(cycles=3), name="slow")
    >>> sorted(case.diff(slow))
    ['name', 'operation.cycles']
    """

    name: str
    title: str = ""
    description: str = ""
    springs: tuple[InstalledSpring, ...] = ()
    rubbing: Rubbing = Rubbing()
    lift_law: LiftLawParameters | None = None
    operation: Operation = Operation()
    limits: Limits = Limits()
    train: TrainParameters | None = None
    published: tuple[PublishedValue, ...] = ()
    notes: Mapping[str, Note] = field(default_factory=FrozenMapping)
    sources: tuple[str, ...] = ()
    remarks: tuple[str, ...] = ()
    study: str = ""
    points: Mapping[str, float] = field(default_factory=FrozenMapping)
    text: str = field(default="", compare=False, repr=False)
    changed: tuple[str, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "notes", FrozenMapping(self.notes))
        object.__setattr__(self, "points", FrozenMapping(self.points))

    def replace(self, **fields: Any) -> Case:
        """A copy with fields changed, which follow ``text`` as remarks; ``changed`` names them.

        Raises :class:`InputError` for points that cannot be read.
        """
        result = replace(self, **fields)
        refused = point_problem(result.study, result.points, result.springs)
        if refused is not None:
            raise InputError(refused[1], ".".join(filter(None, ("points", refused[0]))))
        names = [name for name in fields if name not in _WORDS]
        remarks = "".join(
            f"# changed: {name} = {' '.join(repr(fields[name]).split())}\n" for name in names
        )
        return replace(
            result,
            text=result.text + remarks,
            changed=tuple(dict.fromkeys((*result.changed, *names))),
        )

    def diff(self, other: Case) -> dict[str, tuple[Any, Any]]:
        """Key path -> (value here, value in ``other``) of everything that differs."""
        return differences(self, other)

    @property
    def digest(self) -> str:
        """16 hexadecimal digits of all that can change a number of the case, to 12 digits of its values, whatever text
        and units said so; names of the case and of its parts take no part.
        """
        values = tuple(getattr(self, one.name) for one in fields(self) if one.name not in _TEXTS)
        return hashlib.sha256(content(values, exact=False)).hexdigest()[:16]

    def cite(self) -> tuple[str, ...]:
        """Keys of the references (valvetrain/references.bib) this case draws on, in order of first
        use.
        """
        texts = [
            *self.sources,
            *(note.source for note in self.notes.values()),
            *(value.source for value in self.published),
        ]
        keys = [text.split(",")[0].strip() for text in texts]
        return tuple(dict.fromkeys(key for key in keys if key and " " not in key))

    @property
    def spring(self) -> SpringDefinition | None:
        """Wire of the first spring; None where the case has no spring or knows it by its card only."""
        return self.springs[0].wire if self.springs else None

    def require_spring(self) -> SpringDefinition:
        """Wire of the first spring. Raises :class:`InputError` when the case has none."""
        if self.spring is None:
            if self.train is not None:
                raise InputError(
                    f"case '{self.name}' is a valvetrain; give a case whose [spring] table holds one of its wires"
                )
            raise InputError(
                f"case '{self.name}' defines no wire of a spring; give wire_diameter and so on in its [spring] table"
            )
        return self.spring

    def record(self) -> CaseRecord:
        """What may be shown of this case: words, sources, published values and the resolved text.

        Keys of works that valvetrain/references.bib does not hold are shown as they are.
        """
        from valvetrain.citations import references

        known = references()
        return CaseRecord(
            name=self.name,
            title=self.title,
            description=self.description,
            study=self.study,
            remarks=self.remarks,
            published=self.published,
            citations=tuple(known[key].text() if key in known else key for key in self.cite()),
            zero_of_angle=self.lift_law.zero if self.lift_law is not None else "",
            changed=self.changed,
            text=self.text,
            points=tuple(self.points.items()),
            red_line=self.operation.red_line,
            top_speed=self.operation.top_speed,
            digest=self.digest,
            limits=tuple(
                (name, value)
                for name, value in (
                    ("permitted_bounce_height", self.limits.bounce),
                    ("permitted_loft_gap", self.limits.loft),
                )
                if value is not None
            ),
            assumed=tuple(
                _called(key) for key, note in self.notes.items() if note.status == "assumed"
            ),
        )


def _called(key: str) -> str:
    """What a value is called by the last two parts of its key: ``train.springs.card.0.mass`` is the spring mass."""
    key = re.sub(r"train\.springs\.[^.]+\.\d+|spring\.\d+", "spring", key)
    parts = [part for part in key.split(".") if part not in ("train", "lift_law", "operation")]
    return " ".join(parts[-2:]).replace("_", " ") or key.replace("_", " ")
