"""How a workbench is served: address, token and bounds."""

from __future__ import annotations

import ipaddress
import secrets
from dataclasses import dataclass

from valvetrain.errors import InputError


@dataclass(frozen=True, slots=True)
class ServeSettings:
    """Address and bounds of one server.

    Parameters
    ----------
    host : address listened on, ``127.0.0.1`` by default
    port : TCP port
    token : what a visitor must show, empty where none is required (loopback)
    names : names of this machine that a browser may call it by, in addition to its addresses
    open_page : open the first page in a browser
    case : id of the case whose page is the first one; empty: the start
    most_upload : largest uploaded file (bytes)
    most_body : largest body of any request, and largest message of a socket (bytes)
    most_sessions : pages that are open at a time
    most_requests : requests that are answered at a time
    """

    host: str = "127.0.0.1"
    port: int = 8420
    token: str = ""
    names: tuple[str, ...] = ()
    open_page: bool = False
    case: str = ""
    most_upload: int = 5_000_000
    most_body: int = 6_000_000
    most_sessions: int = 32
    most_requests: int = 128

    @property
    def address(self) -> str:
        """Where a browser finds the first page, without the token: ``http://127.0.0.1:8420/``.

        >>> ServeSettings().address
        'http://127.0.0.1:8420/'
        """
        host = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(self.host, self.host)
        return f"http://{f'[{host}]' if ':' in host else host}:{self.port}{self.path}"

    @property
    def path(self) -> str:
        """Path of the first page: that of the case, else the start."""
        return f"/case/{self.case}" if self.case else "/"

    @property
    def first_page(self) -> str:
        """The address with the token, where there is one: what is opened first.

        >>> ServeSettings(token="abc").first_page
        'http://127.0.0.1:8420/?token=abc'
        """
        return f"{self.address}?token={self.token}" if self.token else self.address


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches the address.

    >>> is_loopback("127.0.0.1"), is_loopback("::1"), is_loopback("0.0.0.0"), is_loopback("10.0.0.5")
    (True, True, False, False)
    """
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host.lower() == "localhost"


def new_token() -> str:
    """A random token of 192 bits.

    >>> len(new_token()) > 30
    True
    """
    return secrets.token_urlsafe(24)


def check_settings(settings: ServeSettings) -> ServeSettings:
    """The settings; raises :class:`InputError` for an address beyond this machine without a token,
    or a short one.
    """
    if not settings.token and not is_loopback(settings.host):
        raise InputError(
            f"address '{settings.host}' is reached from elsewhere, so it needs a token",
            "--host",
        )
    if settings.token and (
        len(settings.token) < 16 or not settings.token.isascii() or not settings.token.isprintable()
    ):
        raise InputError(
            "a token has at least 16 plain characters; leave the variable out to get a random one",
            "VALVETRAIN_TOKEN",
        )
    return settings
