"""What tests of studies, searches and identifications share."""

from __future__ import annotations

from pathlib import Path

from valvetrain.explore.files import FileText
from valvetrain.explore.identification_file import (
    IdentificationModel,
    IdentificationPlan,
    read_identification,
)


def identification_plan(text: str, name: str, folder: Path) -> IdentificationPlan:
    """The plan of an identification written in ``text`` of the file ``name`` in a folder."""
    return read_identification(FileText(text, name, folder, IdentificationModel))
