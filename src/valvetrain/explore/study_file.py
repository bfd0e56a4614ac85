"""A study file: case, varied quantities, sampler and outputs; read to a plan."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

from pydantic import Field, model_validator

from valvetrain.explore.engine import Evaluation
from valvetrain.explore.files import (
    MAX_VARIED,
    CorrelationModel,
    FileText,
    Names,
    VaryModel,
    case_of_file,
    space_of_file,
    text_of_file,
)
from valvetrain.explore.outputs import Outputs
from valvetrain.explore.samplers import sampler
from valvetrain.explore.table import StudyPlan
from valvetrain.parameters.schema_types import Line, StrictModel, problem
from valvetrain.registry import find
from valvetrain.solution.definition import is_defined, no_quantity
from valvetrain.units import si_speeds

#: What is computed from the points besides their own numbers.
Kind = Literal["points", "tolerance", "surrogate"]


class PointsModel(StrictModel):
    """The ``[points]`` table: the sampler, and its options, which it checks itself."""

    sampler: str = "latin-hypercube"

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, raw: Any) -> Any:
        if not isinstance(raw, dict):
            raise problem("a table with sampler and its options is needed here")
        return {key: value for key, value in raw.items() if key == "sampler"}


class StudyModel(StrictModel):
    """The whole file."""

    kind: Kind = "points"
    title: Line = ""
    description: Line = ""
    case: str
    changes: dict[str, Any] = Field(default_factory=dict)
    engine_speeds: str | list[Any] | None = None
    spring_models: Names = Field(default_factory=list)
    spring_sets: Names = Field(default_factory=list)
    outputs: Names
    rest_model: str = ""
    points: PointsModel = PointsModel()
    vary: list[VaryModel] = Field(min_length=1, max_length=MAX_VARIED)
    correlation: list[CorrelationModel] = Field(default_factory=list, max_length=MAX_VARIED)


class StudyText(FileText[StudyModel]):
    """A study file read, with the options of its sampler."""

    def __init__(self, text: str, where: str, folder: Path) -> None:
        super().__init__(text, where, folder, StudyModel)
        points = self.tree.get("points", {})
        self.sampler_options = {key: value for key, value in points.items() if key != "sampler"}


def read_study_file(path: Path) -> StudyText:
    """The study file at ``path``. Raises :class:`InputError`, one sentence with file, line and key."""
    return StudyText(text_of_file(path, "study file"), path.name[:60], path.parent)


def read_plan(text: StudyText) -> StudyPlan:
    """The plan of a study file. Raises :class:`InputError`, one sentence with file, line and key."""
    model = text.model
    case = text.guarded(("case",), lambda: case_of_file(model.case, model.changes, text.folder))
    space = space_of_file(text, model.vary, case, model.correlation)
    spec = text.guarded(("points", "sampler"), lambda: sampler(model.points.sampler, ""))
    options = text.guarded(("points",), lambda: spec.read_options(dict(text.sampler_options)))
    if model.kind == "tolerance" and spec.word != "saltelli":
        raise text.located(
            ("points", "sampler"),
            "a study of kind 'tolerance' needs the sampler saltelli; choose it",
        )
    for index, name in enumerate(model.outputs):
        if not is_defined(name):
            raise text.located(("outputs", index), no_quantity(name))
    if not model.outputs:
        raise text.located(
            ("outputs",), "names no quantity; name one or more of docs/quantities.md"
        )
    for key, word in (
        ("rest_model", model.rest_model),
        *(("spring_models", one) for one in model.spring_models),
    ):
        if word:
            text.guarded((key,), lambda word=word: find("springs", word))
    speeds = model.engine_speeds
    experiment = text.guarded(
        ("engine_speeds",),
        lambda: Evaluation(
            case,
            space,
            Outputs(
                model.outputs,
                engine_speeds=None if speeds is None else si_speeds(speeds),
                spring_models=model.spring_models,
                spring_sets=model.spring_sets,
                rest_model=model.rest_model,
            ),
        ),
    )
    title = model.title or f"{case.name}: {spec.shown_name}"
    plan = StudyPlan(experiment, spec, options, title, model.kind, model.description)
    if space.correlation is not None:
        text.guarded(("points", "sampler"), plan.draws)
    return plan
