"""Headers of security on every answer: what a page may load, embed and run, with the hash of each script that stands in it."""

from __future__ import annotations

import base64
import hashlib
import re
from collections.abc import Iterable

_SCRIPT = re.compile(rb"<script\b([^>]*)>(.*?)</script>", re.DOTALL | re.IGNORECASE)
_DATA = re.compile(rb"""\btype\s*=\s*["']?application/json""", re.IGNORECASE)
#: On every answer.
HEADERS: tuple[tuple[str, str], ...] = (
    ("x-content-type-options", "nosniff"),
    ("x-frame-options", "DENY"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
    ("permissions-policy", "camera=(), geolocation=(), microphone=(), payment=(), usb=()"),
)


def content_security_policy(host: str, page: bytes = b"") -> str:
    """The policy of one answer.

    ``host``: name and port by which the browser called; ``page``: its HTML, of whose own scripts each is let run by its hash, and none
    that gets into the page later. The framework of the pages compiles its templates in the browser, which takes ``unsafe-eval``, and sets
    styles on elements.

    >>> "script-src 'self' 'unsafe-eval';" in content_security_policy("127.0.0.1:8420")
    True
    """
    scripts = " ".join(("'self'", "'unsafe-eval'", *script_hashes(page)))
    return "; ".join((
        "default-src 'self'", f"script-src {scripts}", "script-src-attr 'none'", "style-src 'self' 'unsafe-inline'",
        "img-src 'self' data: blob:", "font-src 'self' data:", "media-src 'self' blob:", "worker-src 'self' blob:",
        f"connect-src 'self' ws://{host} wss://{host}", "object-src 'none'", "base-uri 'none'", "form-action 'self'",
        "frame-src 'none'", "frame-ancestors 'none'",
    ))  # fmt: skip


def script_hashes(page: bytes) -> Iterable[str]:
    """The hash of each script in a page, as a policy names it.

    >>> list(script_hashes(b"<script>1</script><script src='/a.js'></script>"))
    ["'sha256-a4ayc/80/OGda4BO/1o/V0etpOqiLx1JwB5S3beHW0s='"]
    """
    found = (match[2] for match in _SCRIPT.finditer(page) if match[2].strip() and not _DATA.search(match[1]))
    digests = (hashlib.sha256(text.replace(b"\r\n", b"\n")).digest() for text in found)
    return dict.fromkeys(f"'sha256-{base64.b64encode(one).decode()}'" for one in digests)
