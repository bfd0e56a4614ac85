"""Templates of ``valvetrain new``: commented case files by kind."""

from __future__ import annotations

from pathlib import Path

from valvetrain.errors import InputError

TEMPLATES = Path(__file__).parent.parent / "templates"


#: Kind -> what it is, in the order of the help.
KINDS = {
    "spring": "a spring alone", "direct": "a bucket tappet", "finger": "a finger follower", "rocker": "a rocker over the cam",
    "pushrod": "a pushrod and rocker",
}  # fmt: skip


def template_text(kind: str) -> str:
    """The commented case of ``kind`` (a word of :data:`KINDS`), ``NAME.toml`` standing for its
    file.

    Raises :class:`InputError` for an unknown kind.

    >>> "[spring]" in template_text("spring")
    True
    """
    if kind not in KINDS:
        from valvetrain.parameters.changes import nearest

        raise InputError(
            f"there is no template of the kind '{kind[:40]}'; {nearest(kind, tuple(KINDS))}",
            "--kind",
        )
    return (TEMPLATES / f"{kind}.toml").read_text(encoding="utf-8")
