"""The whole case file as one model, and the :class:`Case` it makes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from valvetrain.parameters.case import Case, Installation, Note, Operation, RodOptions
from valvetrain.parameters.damping import DampingParameters
from valvetrain.parameters.schema_lift import LiftField
from valvetrain.parameters.schema_published import PublishedModel
from valvetrain.parameters.schema_spring import SpringCardModel, SpringModel
from valvetrain.parameters.schema_types import (
    DampingRate,
    Frequency,
    Length,
    PositiveLength,
    PositiveTime,
    Ratio,
    StrictModel,
    Time,
    guarded,
    problem,
    quantities,
    quantity,
)
from valvetrain.parameters.spring import SpringDefinition
from valvetrain.parameters.train_schema import TrainModel

_ROD = RodOptions()

AngularSpeeds = Annotated[tuple[float, ...], quantities("angular speed")]
LineStiffness = Annotated[float, quantity("line stiffness", low=0.0)]
OutputStep = Annotated[float, quantity("angle", low=1e-4, high=0.5)]


class InstallationModel(StrictModel):
    """The [installation] table."""

    precompression: Length | None = None
    installed_height: PositiveLength | None = None
    seats: Literal["planes", "clamps"] = "planes"

    def build(self, spring: SpringDefinition | None) -> Installation:
        """The installation of ``spring``; refuses one that would be stretched or solid."""
        if self.precompression is not None and self.installed_height is not None:
            raise problem("precompression and installed_height are both given and may contradict; give one", ("installed_height",))
        compression = self.precompression or 0.0
        if self.installed_height is not None and spring is not None:
            compression = spring.free_length - self.installed_height
        if compression < 0:
            raise problem("the spring would be stretched, not compressed; lower installed_height or raise precompression")
        if spring is not None and compression > spring.free_length - spring.solid_height:
            room = (spring.free_length - spring.solid_height) * 1e3
            raise problem(f"the spring is solid before this compression; it has {room:.4g} mm of room: compress it less")
        return Installation(compression, self.installed_height, self.seats)


class DampingModel(StrictModel):
    """The [damping] table."""

    ratio: Ratio | None = None
    ratio_frequency: Frequency | None = None
    stiffness_share: Ratio | None = None
    mass_damping: DampingRate | None = None
    stiffness_damping: Time | None = None

    def build(self) -> DampingParameters:
        """The damping; refuses two ways of giving it that disagree."""
        made: DampingParameters = guarded(lambda: DampingParameters(**self.model_dump()))
        return made


class OperationModel(StrictModel):
    """The [operation] table: engine (crank) or cam speeds."""

    engine_speeds: AngularSpeeds | None = None
    cam_speeds: AngularSpeeds | None = None
    cycles: int = 2

    def build(self) -> Operation:
        """The operation, with engine (crank) speeds."""
        if self.engine_speeds is not None and self.cam_speeds is not None:
            raise problem("engine_speeds and cam_speeds are both given; give one (an engine speed is twice the cam speed)", ("cam_speeds",))
        speeds = self.engine_speeds if self.engine_speeds is not None else tuple(2 * speed for speed in self.cam_speeds or ())
        if any(speed <= 0 for speed in speeds):
            raise problem("a speed must be positive; correct the list")
        if not 1 <= self.cycles <= 10_000:
            raise problem("cycles must be a whole number from 1 to 10000", ("cycles",))
        return Operation(speeds, self.cycles)


class RodModel(StrictModel):
    """The [rod] table; defaults stand in :class:`RodOptions`."""

    elements_per_coil: int = _ROD.elements_per_coil
    contact_stiffness: LineStiffness = _ROD.contact_stiffness
    contact_damping_time: Time = _ROD.contact_damping_time
    output_step: OutputStep = _ROD.output_step
    curvature_correction: bool = _ROD.curvature_correction
    time_step: PositiveTime | None = None

    def build(self) -> RodOptions:
        """The constants of the rod."""
        if not 4 <= self.elements_per_coil <= 1000:
            raise problem("elements_per_coil must be a whole number from 4 to 1000", ("elements_per_coil",))
        return RodOptions(**self.model_dump())


class CaseModel(StrictModel):
    """The whole file."""

    name: str | None = None
    title: str = ""
    description: str = ""
    sources: list[str] = Field(default_factory=list)
    remarks: list[str] = Field(default_factory=list)
    spring: SpringModel | None = None
    spring_card: SpringCardModel | None = None
    lift_law: LiftField | None = None
    installation: InstallationModel = InstallationModel()
    damping: DampingModel = DampingModel()
    operation: OperationModel = OperationModel()
    rod: RodModel = RodModel()
    train: TrainModel | None = None
    published: list[PublishedModel] = Field(default_factory=list)

    def build(self, name: str, folder: Path, notes: dict[str, Note]) -> Case:
        """The case; ``folder`` is where relative file names start. Raises a located problem for tables that contradict each other."""
        if self.spring is not None and self.spring_card is not None:
            raise problem("spring and spring_card are both given and may contradict each other; keep one", ("spring_card",))
        if self.spring is None and self.spring_card is None and self.lift_law is None and self.train is None:
            raise problem("the case is empty; it needs at least one of [spring], [spring_card], [lift_law] and [train]")
        name = self.name or name
        spring = _at("spring", self.spring.build, name) if self.spring else None
        published = (_at(("published", index), group.build) for index, group in enumerate(self.published))
        return Case(
            name=name,
            title=self.title,
            description=self.description,
            spring=spring,
            spring_card=_at("spring_card", self.spring_card.build) if self.spring_card else None,
            lift_law=_at("lift_law", self.lift_law.parameters, folder) if self.lift_law else None,
            installation=_at("installation", self.installation.build, spring),
            damping=_at("damping", self.damping.build),
            operation=_at("operation", self.operation.build),
            rod=_at("rod", self.rod.build),
            train=_at("train", self.train.build) if self.train is not None else None,
            published=tuple(value for group in published for value in group),
            notes=notes,
            sources=tuple(self.sources),
            remarks=tuple(self.remarks),
        )


def _at(where: str | tuple[str | int, ...], build: Any, *arguments: Any) -> Any:
    """Call ``build`` and put ``where`` before the path of any problem in it."""
    path = (where,) if isinstance(where, str) else where
    try:
        return guarded(build, *arguments)
    except PydanticCustomError as error:
        context = error.context or {}
        raise problem(str(context.get("reason", error)), (*path, *context.get("path", ()))) from error
