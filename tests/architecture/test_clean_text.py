"""Tracked files hold no address of a package index, no path of one machine, no word on how the text
was made.

The forbidden words are put together from parts, so that this file does not hold them.
"""

from __future__ import annotations

import re
import subprocess

import pytest

from architecture.layout import ROOT

START = (
    r"(?<![\w.:/$}~-])"  # a path begins here, it is not the tail of an address or of a longer path
)
HOSTS = [
    "pypi" + r"\.",
    "python" + "hosted",
    "anaconda" + r"\.(?:org|com)",
    "dev" + "pi",
    "arti" + "factory",
]
CHOICES = [
    "--" + "(?:extra-)?" + "index-url",
    "--" + "find-links",
    "--" + "trusted-host",
    "(?:PIP|UV)_" + r"\w+=",
]
MAKERS = [
    "cla" + "ude",
    "anth" + "ropic",
    "chat" + "gpt",
    "open" + "ai",
    "co" + "pilot",
    r"language " + "model",
]
FORBIDDEN = {
    "address of a package index": re.compile("|".join(HOSTS), re.I),
    "choice of a package index": re.compile("|".join(CHOICES)),
    "path of one machine": re.compile(
        START + "/" + "(?:work|home|root|Users|mnt|workspace)" + r"/[\w.]"
    ),
    "path outside the repository": re.compile(
        r"(?:\.\./|\b)" + "shared" + "/(?:spec|seeds|design|hooks)"
    ),
    "word on how the text was made": re.compile("|".join(MAKERS), re.I),
}
#: scripts/pins.sh must tell its resolver to leave addresses out, and names the options that do so.
MAY_NAME = {("scripts/pins.sh", "choice of a package index")}


def tracked() -> list[str]:
    """Paths of the repository's own text files: tracked, or new and not ignored."""
    command = ["git", "-C", str(ROOT), "ls-files", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("this copy is not a git checkout, so what belongs to it is not known")
    return sorted({line for line in listed.stdout.splitlines() if (ROOT / line).is_file()})


def findings(path: str, text: str) -> list[str]:
    """``path:line kind: match`` of each forbidden thing in a text."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        for kind, pattern in FORBIDDEN.items():
            if (path, kind) not in MAY_NAME and (match := pattern.search(line)):
                found.append(f"{path}:{number} {kind}: {match[0]}")
    return found


@pytest.mark.parametrize(
    "line",
    [
        "see https://py" + "pi.org/x",
        "pip install --index" + "-url x",
        "PIP" + "_CERT=x",
        "open('/wo" + "rk/main/a')",
        "/ho" + "me/me/x",
        "from ../sha" + "red/spec/a",
        "by Cl" + "aude",
    ],
)
def test_the_rule_catches_what_it_should(line):
    assert len(findings("a.py", line)) == 1


def test_tracked_files_are_clean():
    found = []
    for path in tracked():
        try:
            text = (ROOT / path).read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue
        found += findings(path, text)
    assert not found, "\n".join(found)
