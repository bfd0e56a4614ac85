"""Programs outside Python that tests use, by the marker of those tests."""

from __future__ import annotations

import os
import shutil

#: Marker -> (names under which the program is found, Debian package).
PROGRAMS = {
    "chromium": (("chromium", "chromium-browser", "google-chrome"), "chromium"),
    "calculix": (("ccx", "ccx_2.20", "ccx_2.21"), "calculix-ccx"),
}


def program(marker: str) -> str | None:
    """Path of the program that tests with this marker use, or None."""
    return next((path for name in PROGRAMS[marker][0] if (path := shutil.which(name))), None)


def under_ci() -> bool:
    """True where nothing may be left out."""
    return os.environ.get("CI") == "true"
