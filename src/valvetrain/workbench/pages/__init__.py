"""The pages of the workbench in the browser, with NiceGUI."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

from valvetrain.errors import MissingExtraError

if TYPE_CHECKING:
    from valvetrain.workbench.jobs import Jobs
    from valvetrain.workbench.settings import ServeSettings
    from valvetrain.workbench.workspace import Workspace

#: A valve spring, drawn by a line: the icon of the page, so that none is fetched elsewhere.
ICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32"><path d="M6 5h20M6 27h20M7 9l18 4M7 14l18 4M7 19l18 4" '
    'stroke="#1f5aa6" stroke-width="3" stroke-linecap="round" fill="none"/></svg>'
)


def start(
    workspace: Workspace,
    jobs: Jobs,
    settings: ServeSettings,
    listening: Callable[[], None] = lambda: None,
) -> None:
    """Serve the pages until Ctrl-C.

    Parameters
    ----------
    workspace : cases and runs that are shown
    jobs : what computes
    settings : address, token and bounds
    listening : called once the address answers

    Raises
    ------
    MissingExtraError : the web framework is not installed
    """
    try:
        from nicegui import app, ui
    except ImportError:
        raise MissingExtraError(
            'the pages need NiceGUI; install with pip install "valvetrain[serve]"'
        ) from None
    from valvetrain.workbench.pages import frame as assets
    from valvetrain.workbench.pages import routes
    from valvetrain.workbench.pages.connections import tell_briefly, uvicorn_options
    from valvetrain.workbench.pages.desk import Desk
    from valvetrain.workbench.pages.guard import Guard

    tell_briefly()
    desk = Desk(workspace, jobs, settings)
    routes.register(desk)
    app.add_middleware(Guard, settings=settings)

    async def tell_once() -> None:
        await _until_listening(settings.host, settings.port)
        listening()
        await assets.warm()
        await asyncio.to_thread(workspace.cases)

    app.on_startup(tell_once)
    app.on_shutdown(desk.close)
    with suppress(KeyboardInterrupt):
        ui.run(
            host=settings.host,
            port=settings.port,
            title="valvetrain",
            favicon=ICON,
            dark=False,
            language="en-US",
            reload=False,
            show=settings.open_page and not settings.token and settings.path,
            tailwind=False,
            show_welcome_message=False,
            reconnect_timeout=30.0,
            gzip_middleware_factory=None,
            uvicorn_logging_level="warning",
            **uvicorn_options(settings),
        )


#: Seconds between two looks whether the server listens.
LOOK = 0.05


async def _until_listening(host: str, port: int) -> None:
    """Wait until ``port`` takes connections."""
    place = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(host, host)
    while True:
        try:
            _, writer = await asyncio.open_connection(place, port)
        except OSError:
            await asyncio.sleep(LOOK)
            continue
        writer.close()
        return
