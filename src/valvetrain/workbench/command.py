"""``valvetrain serve``: the workbench in the browser."""

from __future__ import annotations

import errno
import os
import signal
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from valvetrain.cli.options import QuietOption, read_count, read_folder
from valvetrain.cli.outcome import complain, tell
from valvetrain.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    from valvetrain.workbench.settings import ServeSettings

#: Default bounds of one job.
DEFAULT_LIMITS = ("1 h", "4 GB")
PORT, DEFAULT_FOLDER = 8420, Path("workbench")
#: Variable with the token that visitors must show.
TOKEN = "VALVETRAIN_TOKEN"
MISSING = (
    'the workbench in the browser needs NiceGUI; install it with pip install "valvetrain[serve]"'
)


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("serve")(serve)


def serve(
    folder: Annotated[
        Path | None,
        typer.Option(
            "--folder",
            metavar="FOLDER",
            parser=read_folder,
            show_default=False,
            help="Workspace: cases, runs and jobs; made where absent (default: workbench).",
        ),
    ] = None,
    port: Annotated[
        int, typer.Option("--port", metavar="N", help="TCP port; 0 takes a free one.")
    ] = PORT,
    host: Annotated[
        str,
        typer.Option(
            "--host",
            metavar="ADDRESS",
            help="Address listened on; any but this machine's own needs a token.",
        ),
    ] = "127.0.0.1",
    token: Annotated[
        bool,
        typer.Option(
            "--token",
            help="Visitors of this machine's own address must show a token, too: that in the variable VALVETRAIN_TOKEN, else a random one.",
        ),
    ] = False,
    name: Annotated[
        list[str] | None,
        typer.Option(
            "--name",
            metavar="NAME",
            help="Name that browsers call this machine by. Repeatable.",
            show_default=False,
        ),
    ] = None,
    open_page: Annotated[
        bool, typer.Option("--open/--no-open", help="Open the first page in a browser.")
    ] = True,
    most_running: Annotated[
        int, typer.Option("--most-running", metavar="N", help="Jobs that run at a time.")
    ] = 1,
    most_waiting: Annotated[
        int, typer.Option("--most-waiting", metavar="N", help="Jobs that may wait.")
    ] = 8,
    limit: Annotated[
        list[str] | None,
        typer.Option(
            "--limit",
            metavar="BOUND",
            show_default=False,
            help="Longest time and largest memory of a job (default: 1 h, 4 GB): '2 h', '8 GB'. Repeatable.",
        ),
    ] = None,
    quiet: QuietOption = False,
) -> None:
    """Serve the workbench: choose or upload a case, change it in forms, run it, watch and compare
    its answers, in a browser.
    """
    from valvetrain.runs.cost import read_limits
    from valvetrain.workbench.safety import check_settings, is_loopback, new_token
    from valvetrain.workbench.settings import ServeSettings

    limits = read_limits((*DEFAULT_LIMITS, *(limit or ())))
    running, waiting = (
        read_count(most_running, 1, 64, "--most-running"),
        read_count(most_waiting, 0, 1000, "--most-waiting"),
    )
    address = host.strip().strip("[]")
    taken = free_port(address, read_count(port, 0, 65535, "--port"))
    # A word of the command line is read by every user of the machine.
    shown = os.environ.pop(TOKEN, "") or (new_token() if token or not is_loopback(address) else "")
    settings = check_settings(ServeSettings(address, taken, shown, tuple(name or ()), open_page))
    if find_spec("nicegui") is None:
        raise MissingExtraError(MISSING)
    _serve(folder or DEFAULT_FOLDER, settings, running, waiting, limits.seconds, limits.bytes)


def _serve(
    folder: Path, settings: ServeSettings, running: int, waiting: int, seconds: float, memory: float
) -> None:
    """Hold the workspace, serve until a signal, and end the jobs."""
    from valvetrain.workbench.jobs import Jobs
    from valvetrain.workbench.pages import start
    from valvetrain.workbench.workspace import Workspace

    workspace = Workspace(folder)
    release = workspace.hold()
    try:
        with Jobs(workspace, running, waiting, seconds, memory) as jobs:

            def listening() -> None:
                tell(f"workbench '{folder}' at {settings.address}; Ctrl-C ends it")
                if settings.token:
                    complain(f"visitors need its token: {settings.first_page}")

            with _ended_by_signals(), suppress(KeyboardInterrupt):
                start(workspace, jobs, settings, listening)
            going = jobs.running
        tell(
            "the server has ended"
            + (
                f"; {going} running jobs were stopped, what they had finished is saved"
                if going
                else ""
            )
        )
    finally:
        release()


@contextmanager
def _ended_by_signals() -> Iterator[None]:
    """While a server runs, a signal ends it and nothing else: where an event loop runs, the loop's
    server has its own way of ending, and an
    exception in the midst of it would be reported as a fault."""
    import asyncio  # only a server needs it

    def end(number: int, _: Any) -> None:
        try:
            asyncio.get_running_loop()
        except RuntimeError:
            raise KeyboardInterrupt from None
        if number not in (
            signal.SIGINT,
            signal.SIGTERM,
        ):  # which the server hears itself, and hands on when it has ended
            signal.raise_signal(signal.SIGTERM)

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = [
        one
        for name in ("SIGINT", "SIGTERM", "SIGHUP")
        if (one := getattr(signal, name, None)) is not None
    ]
    before = {
        number: signal.signal(number, end)
        for number in numbers
        if signal.getsignal(number) is not signal.SIG_IGN
    }
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def free_port(host: str, port: int) -> int:
    """The port, or a free one for 0. Raises :class:`InputError` where it is taken or the address is
    none of this machine.
    """
    try:
        if not host:
            raise OSError
        places = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        kind, _, _, _, place = places[0]
    except (OSError, UnicodeError):
        raise InputError(f"'{host[:60]}' is no address; give such as 127.0.0.1", "--host") from None
    with socket.socket(kind, socket.SOCK_STREAM) as listener:
        if os.name == "posix":  # elsewhere this option lets two servers share a port
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind(place)
        except PermissionError:
            raise InputError(
                f"port {port} may not be used by everybody; choose one above 1023", "--port"
            ) from None
        except OSError as error:
            if error.errno == errno.EADDRINUSE:
                raise InputError(
                    f"port {port} is taken, perhaps by another server; choose another, or 0 for a free one",
                    "--port",
                ) from None
            raise InputError(
                f"'{host[:60]}' is no address of this machine ({error.strerror}); give 127.0.0.1",
                "--host",
            ) from None
        found: int = listener.getsockname()[1]
        return found
