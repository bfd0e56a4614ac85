"""``valvetrain serve``: the workbench in the browser."""

from __future__ import annotations

import errno
import os
import signal
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.cli.options import choose_case
from valvetrain.cli.outcome import complain, tell
from valvetrain.cli.request import QuietLine, command_without_case
from valvetrain.errors import InputError, MissingExtraError
from valvetrain.runs.cost import Limits, read_limits
from valvetrain.runs.request_fields import (
    option,
    read_count,
    read_names,
    read_path,
    read_switch,
    read_text,
)

if TYPE_CHECKING:
    from valvetrain.workbench.settings import ServeSettings

#: Variable with the token that visitors must show.
TOKEN = "VALVETRAIN_TOKEN"
MISSING = (
    'the workbench in the browser needs NiceGUI; install it with pip install "valvetrain[serve]"'
)


@dataclass(frozen=True, kw_only=True)
class ServeLine(QuietLine):
    """The command line of ``serve``."""

    case: str = option(
        read_text,
        "Case that is opened: a file, of which a copy is made, or a library case.",
        metavar="[CASE]",
        default="",
    )
    folder: Path = option(
        read_path,
        "Workspace: cases, runs and jobs; made where absent.",
        "--folder",
        "FOLDER",
        default="workbench",
    )
    port: int = option(
        partial(read_count, 0, 65535),
        "TCP port; 0 takes a free one.",
        "--port",
        "N",
        default="8420",
    )
    host: str = option(
        read_text,
        "Address listened on; any but this machine's own needs a token.",
        "--host",
        "ADDRESS",
        default="127.0.0.1",
    )
    token: bool = option(
        read_switch,
        "Visitors of this machine's own address must show a token, too: that in the variable VALVETRAIN_TOKEN, else a random one.",
        "--token",
        default=False,
    )
    names: tuple[str, ...] = option(
        read_names,
        "Name that browsers call this machine by. Repeatable.",
        "--name",
        "NAME",
        default=(),
        repeatable=True,
    )
    open_page: bool = option(
        read_switch, "Open the first page in a browser.", "--open/--no-open", default=True
    )
    most_running: int = option(
        partial(read_count, 1, 64),
        "Jobs that run at a time.",
        "--most-running",
        "N",
        default="1",
    )
    most_waiting: int = option(
        partial(read_count, 0, 1000),
        "Jobs that may wait.",
        "--most-waiting",
        "N",
        default="8",
    )
    limit: Limits = option(
        lambda given, where: read_limits(("1 h, 4 GB", *given), where),
        "Longest time and largest memory of a job (default: 1 h, 4 GB): '2 h', '8 GB'. Repeatable.",
        "--limit",
        "BOUND",
        default=Limits(3600.0, 4e9),
        repeatable=True,
    )


def serve(line: ServeLine) -> None:
    """Serve the workbench in a browser: choose or upload a case, change it in forms, run it, watch and compare its answers."""
    from valvetrain.workbench.settings import (
        ServeSettings,
        check_settings,
        is_loopback,
        new_token,
    )

    address = line.host.strip().strip("[]")
    port = free_port(address, line.port)
    # A word of the command line is read by every user of the machine.
    needed = line.token or not is_loopback(address)
    token = os.environ.pop(TOKEN, "") or (new_token() if needed else "")
    settings = check_settings(ServeSettings(address, port, token, line.names, line.open_page))
    if find_spec("nicegui") is None:
        raise MissingExtraError(MISSING)
    _serve(line, settings)


register = command_without_case("serve", ServeLine, serve)


def _serve(line: ServeLine, settings: ServeSettings) -> None:
    """Hold the workspace, serve until a signal, and end the jobs."""
    from valvetrain.workbench.jobs import Jobs
    from valvetrain.workbench.pages import start
    from valvetrain.workbench.workspace import Workspace

    workspace = Workspace(line.folder)
    release = workspace.hold()
    try:
        if line.case:
            settings = replace(settings, case=workspace.opened(choose_case(line.case)))
        with Jobs(workspace, line.most_running, line.most_waiting, line.limit) as jobs:

            def listening() -> None:
                tell(f"workbench '{line.folder}' at {settings.address}; Ctrl-C ends it")
                if settings.token:
                    complain(f"visitors need its token: {settings.first_page}")

            with _ended_by_signals(), suppress(KeyboardInterrupt):
                start(workspace, jobs, settings, listening)
            going = jobs.running
        stopped = f"; {going} running jobs were stopped, what they had finished is saved"
        tell(f"the server has ended{stopped if going else ''}")
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
        # the server hears the other two itself, and hands them on when it has ended
        if number not in (signal.SIGINT, signal.SIGTERM):
            signal.raise_signal(signal.SIGTERM)

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = (getattr(signal, name, None) for name in ("SIGINT", "SIGTERM", "SIGHUP"))
    heard = [one for one in numbers if one and signal.getsignal(one) is not signal.SIG_IGN]
    before = {number: signal.signal(number, end) for number in heard}
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
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            where = "--host" if error.errno == errno.EADDRNOTAVAIL else "--port"
            raise InputError(
                f"'{host[:60]}' with port {port} cannot be used ({reason}); choose another port, 0 for a free one, or 127.0.0.1",
                where,
            ) from None
        return int(listener.getsockname()[1])
