"""How a workbench is served: address, token and bounds."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ServeSettings:
    """Address and bounds of one server.

    Parameters
    ----------
    host : address listened on, ``127.0.0.1`` by default
    port : TCP port
    token : what a visitor must show, empty where none is asked for (loopback)
    open_page : open the first page in a browser
    most_upload : largest uploaded file (bytes)
    most_body : largest body of any request (bytes)
    most_sessions : browsers served at a time
    """

    host: str = "127.0.0.1"
    port: int = 8420
    token: str = ""
    open_page: bool = False
    most_upload: int = 5_000_000
    most_body: int = 6_000_000
    most_sessions: int = 32

    @property
    def address(self) -> str:
        """Where a browser finds the first page, without the token: ``http://127.0.0.1:8420/``.

        >>> ServeSettings().address
        'http://127.0.0.1:8420/'
        """
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"http://{host}:{self.port}/"
