"""The pages of the workbench in the browser."""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvetrain.errors import MissingExtraError

if TYPE_CHECKING:
    from valvetrain.workbench.jobs import Jobs
    from valvetrain.workbench.settings import ServeSettings
    from valvetrain.workbench.workspace import Workspace


def start(workspace: Workspace, jobs: Jobs, settings: ServeSettings) -> None:
    """Serve the pages until Ctrl-C. Raises :class:`MissingExtraError` where the web framework is absent."""
    raise MissingExtraError('the pages are not there yet; install with pip install "valvetrain[serve]"')
