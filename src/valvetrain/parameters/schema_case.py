"""The whole case file as one model, and the :class:`Case` it makes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

from pydantic import Field

from valvetrain import registry
from valvetrain.parameters.case import Case, Note, Operation
from valvetrain.parameters.changes import nearest
from valvetrain.parameters.kept_tables import parameters_of
from valvetrain.parameters.schema_installed import RubbingModel, SpringField
from valvetrain.parameters.schema_lift import LiftField
from valvetrain.parameters.schema_names import CaseName, Line, Prose
from valvetrain.parameters.schema_published import PublishedModel
from valvetrain.parameters.schema_types import StrictModel, guarded, placed, problem, quantities, quantity
from valvetrain.parameters.train_card import with_cam_card
from valvetrain.parameters.train_schema import TrainModel
from valvetrain.parameters.wire_points import point_problem
from valvetrain.units import si

_OPERATION = Operation()

AngularSpeeds = Annotated[tuple[float, ...], quantities("angular speed")]
CoilNumber = Annotated[float, quantity("ratio", low=0.0)]
OutputStep = Annotated[float, quantity("angle", low=1e-4, high=0.5)]


class OperationModel(StrictModel):
    """The [operation] table: engine (crank) or cam speeds."""

    engine_speeds: AngularSpeeds | None = None
    cam_speeds: AngularSpeeds | None = None
    cycles: int = Field(default=_OPERATION.cycles, description="cam revolutions run; the last is reported")
    output_step: OutputStep = Field(default=_OPERATION.output_step, description="cam angle between the values kept")

    def build(self) -> Operation:
        """The operation, with engine (crank) speeds."""
        if self.engine_speeds is not None and self.cam_speeds is not None:
            raise problem("engine_speeds and cam_speeds are both given; give one (an engine speed is twice the cam speed)", ("cam_speeds",))
        speeds = self.engine_speeds if self.engine_speeds is not None else tuple(2 * speed for speed in self.cam_speeds or ())
        if any(speed <= 0 for speed in speeds):
            raise problem("a speed must be positive; correct the list")
        for speed in speeds:
            guarded(si, f"{speed * 30 / math.pi:.12g} rpm", "engine_speed")
        if not 1 <= self.cycles <= 10_000:
            raise problem("cycles must be a whole number from 1 to 10000", ("cycles",))
        return Operation(speeds, self.cycles, self.output_step)


class CaseModel(StrictModel):
    """The whole file."""

    name: CaseName | None = None
    title: Line = ""
    description: Prose = ""
    study: str = ""
    sources: list[Line] = Field(default_factory=list)
    remarks: list[Prose] = Field(default_factory=list)
    spring: SpringField | None = None
    rubbing: RubbingModel = RubbingModel()
    lift_law: LiftField | None = None
    operation: OperationModel = OperationModel()
    train: TrainModel | None = None
    points: dict[str, CoilNumber] = Field(default_factory=dict)
    published: list[PublishedModel] = Field(default_factory=list)

    def build(self, name: str, folder: Path, notes: dict[str, Note], text: str = "", changed: tuple[str, ...] = ()) -> Case:
        """The case; ``folder`` is where relative file names start. Raises a located problem for tables that contradict each other."""
        if self.spring is None and self.lift_law is None and self.train is None:
            raise problem("the case is empty; it needs at least one of [spring], [lift_law] and [train]")
        if self.spring is not None and self.train is not None:
            raise problem("a train carries its springs in [train.springs], so this one would stay unused; move it there", ("spring",))
        known = registry.words("sources")
        if self.study and known and self.study not in known:
            raise problem(f"study '{self.study[:40]}' is unknown; {nearest(self.study, known)}", ("study",))
        if self.rubbing.model_fields_set and (self.spring is None or len(self.spring.blocks) < 2):
            raise problem("rubbing acts between two nested springs; remove it (a train has [train.rubbing])", ("rubbing",))
        name = self.name or name
        springs = placed("spring", self.spring.build, name) if self.spring else ()
        refused = point_problem(self.study, self.points, springs)
        if refused is not None:
            raise problem(refused[1], ("points", *filter(None, refused[:1])))
        published = (placed(("published", index), group.build) for index, group in enumerate(self.published))
        return Case(
            name=name,
            title=self.title,
            description=self.description,
            springs=springs,
            rubbing=self.rubbing.build(),
            lift_law=placed("lift_law", parameters_of, self.lift_law, folder) if self.lift_law else None,
            operation=placed("operation", self.operation.build),
            train=placed("train", with_cam_card(self.train, self.lift_law).build) if self.train is not None else None,
            published=tuple(value for group in published for value in group),
            notes=notes,
            sources=tuple(self.sources),
            remarks=tuple(self.remarks),
            study=self.study,
            points=self.points,
            text=text,
            changed=changed,
        )
