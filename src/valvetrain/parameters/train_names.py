"""What users call the kinds of train, and the answer to a name that no case file takes."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence

#: Kind of train -> what it is.
TITLES = {
    "direct": "a bucket tappet", "finger": "a finger follower", "rocker": "a rocker over the cam", "pushrod": "a pushrod and rocker",
}  # fmt: skip

#: Name in use -> kind of train that it means.
SYNONYMS = {
    "bucket": "direct", "bucket-tappet": "direct", "tappet": "direct", "direct-acting": "direct", "direct-attack": "direct",
    "inverted-bucket": "direct", "cam-on-bucket": "direct", "shim-under-bucket": "direct", "shim-over-bucket": "direct",
    "finger-follower": "finger", "roller-finger": "finger", "roller-finger-follower": "finger", "rff": "finger", "follower": "finger",
    "swing-arm": "finger", "swinging-arm": "finger", "swing-follower": "finger", "end-pivot": "finger", "cam-follower": "finger",
    "end-pivot-rocker": "finger", "centre-pivot": "rocker", "center-pivot": "rocker", "rocker-arm": "rocker", "overhead-rocker": "rocker",
    "push-rod": "pushrod", "ohv": "pushrod", "overhead-valve": "pushrod", "cam-in-block": "pushrod", "lifter": "pushrod",
    "hydraulic-lifter": "pushrod", "roller-lifter": "pushrod", "small-block": "pushrod",
}  # fmt: skip

#: Names of engines whose train may be one of several.
_SEVERAL = {
    name: ("direct", "finger", "rocker") for name in ("ohc", "sohc", "dohc", "overhead-cam")
}
#: Names that belong at another key.
_SHAPES = ("roller", "flat", "domed", "knife", "flat-tappet", "mushroom", "solid-roller")


def meant_kind(name: str, kinds: tuple[str, ...]) -> str | None:
    """The kind of train that ``name`` means, one of ``kinds``; None where it is none or several.

    >>> meant_kind("Bucket tappet", tuple(TITLES)), meant_kind("pushrods", tuple(TITLES)), meant_kind("ohc", tuple(TITLES))
    ('direct', 'pushrod', None)
    """
    word = re.sub(r"[\s_]+", "-", name[:60].strip().lower())
    for one in (word, word.removesuffix("s")):
        kind = one if one in kinds else SYNONYMS.get(one)
        if kind in kinds:
            return kind
    return None


def _listed(kinds: Sequence[str]) -> list[str]:
    """Kinds with what they are called."""
    return [f"{one} ({TITLES[one]})" if one in TITLES else one for one in kinds]


def choice_of(kinds: Sequence[str]) -> str:
    """All kinds, each with what it is called.

    >>> choice_of(("direct", "finger"))
    'direct (a bucket tappet) or finger (a finger follower)'
    """
    *others, last = _listed(kinds)
    return f"{', '.join(others)} or {last}" if others else last


def answer(name: str, kinds: tuple[str, ...]) -> str:
    """A clause that says which of ``kinds`` kinds was meant by ``name``.

    >>> answer("bucket", tuple(TITLES))
    'a bucket tappet is called direct: write "direct"'
    """
    if (kind := meant_kind(name, kinds)) is not None:
        return f'{TITLES.get(kind, kind)} is called {kind}: write "{kind}"'
    word = re.sub(r"[\s_]+", "-", name[:60].strip().lower())
    listed, choice = _listed(kinds), choice_of(kinds)
    if word in _SHAPES:
        return f"that is a shape of what runs on the cam, given in [train.follower]; kinds are {choice}"
    if word in _SEVERAL:
        several = [one for one in listed if one.split()[0] in _SEVERAL[word]]
        return f"an overhead cam drives {', '.join(several[:-1])} or {several[-1]}; write which"
    if close := difflib.get_close_matches(word, [*kinds, *SYNONYMS], n=1, cutoff=0.7):
        kind = close[0] if close[0] in kinds else SYNONYMS[close[0]]
        return f"did you mean {kind}?"
    return f"use {choice}"
