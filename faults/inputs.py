"""Damaged and hostile input: bytes of any file, texts of numbers, trees of case files and answers."""

from __future__ import annotations

import copy
import re
import tomllib
from functools import cache
from random import Random
from typing import Any

from valvetrain.parameters.loading import LIBRARY
from valvetrain.parameters.toml_text import toml_text

NUMBERS = (
    "0", "-0", "1", "-1", "2", "7", "100", "65536", "2147483648", "1e9", "-1e9", "1e-9", "1e-30", "1e30", "1e-300", "1e308", "-1e308",
    "1e309", "5e-324", "nan", "inf", "-inf", "0.999999", "1e15", "9" * 40, "9" * 400, "1e99999", "0x10", "1_000", "1,5", "١٢", "½", "+-1",
    "--", ".",
)  # fmt: skip
UNITS = (
    "mm", "m", "km", "nm", "um", "in", "N", "kN", "N/mm", "N/m", "GPa", "Pa", "g", "kg", "kg/m^3", "deg", "rad", "rpm", "Hz", "rad/s", "s",
    "ms", "%", "", "1/s", "N*s/m", "m/s^2", "J", "K", "degC", "furlong", "mm^9", "mm**-3", "lb", "lbf/in", "mm mm mm", "µm", "°", "1", "mm/",
    "()", "decibel", "dimensionless",
)  # fmt: skip
TEXTS = (
    "", " ", "\n", "\r\n", "a\n*INCLUDE, INPUT=/etc/hostname\n*STEP", "</script><script>alert(1)</script>", "]]>", "\"'`", "=1+1", "@SUM(A1)",
    "\x1b[2J\x1b[31m", "\x00", "\x7f", "\x9b31m", "\u2028", "\u202eabc\u2066", "\ufeff", "😀", "é", "名前", "../../../tmp/x", "..", "/", "\\",
    "--help", "~", "%s%n", "{0}", "{% raw %}", "a" * 300, "b" * 5000, "a,b;c", "#", "nul", "*", "?", "x\u0301" * 50, "ﬁ", "İ", "gu2021",
    "outer", "inner", "stock",
)  # fmt: skip
WORDS = (
    "open", "closed-ground", "spline", "stations", "polydyne", "three-arc", "tangent", "cycloidal", "harmonic", "polynomial", "zero", "cam-card",
    "sine-power", "massless", "multi-mass", "finite-element", "wave-rod", "nested", "solid", "lift", "cam", "valve", "finger", "rocker",
    "pushrod", "flat", "roller", "knife", "left", "clamps", "hertz-line", "hunt-crossley", "rigid", "OTEVA 90 SC", "measured", "assumed",
)  # fmt: skip
#: A number in a text.
_NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")


def leaf(chance: Random) -> Any:
    """A plain value of any kind."""
    size = f"{chance.uniform(0, 10) * 10.0 ** chance.randint(-4, 4):.{chance.randint(1, 17)}g}"
    number = chance.choice((size, chance.choice(NUMBERS)))
    others = (0, -1, 3, 10_001, 2**63, 10**400, 0.0, -0.0, 1e300, float("nan"), -float("inf"), True)
    kinds = (
        f"{number} {chance.choice(UNITS)}", f"{number} {chance.choice(UNITS)}", f"{size}, {number} mm", chance.choice(others),
        chance.randint(-5, 50), chance.choice(WORDS), chance.choice(TEXTS),
    )  # fmt: skip
    return chance.choice(kinds)


def value(chance: Random) -> Any:
    """A value, a list or table of them, or one in many brackets."""
    kind = chance.random()
    if kind < 0.8:
        return leaf(chance)
    if kind < 0.9:
        return [leaf(chance) for _ in range(chance.choice((0, 1, 2, 3, 60)))]
    if kind < 0.97:
        return {key: leaf(chance) for key in chance.sample(("value", "status", "kind", *TEXTS), 3)}
    nested: Any = leaf(chance)
    for _ in range(chance.choice((5, 400))):
        nested = [nested] if chance.random() < 0.5 else {"value": nested}
    return nested


def near(chance: Random, old: Any) -> Any:
    """A value like ``old``: its number scaled, its unit exchanged, its length changed."""
    if isinstance(old, bool):
        return not old
    if isinstance(old, (int, float)):
        return old * chance.choice((0, -1, 2, 10, 1000)) + chance.choice((0, 1, 10**9))
    if isinstance(old, list) and old:
        place = chance.randrange(len(old))
        changed = chance.choice(([], old[:1] * 2, [near(chance, old[place])]))
        return [*old[:place], *changed, *old[place + 1 :]]
    if isinstance(old, str) and (found := _NUMBER.match(old)):
        unit = old[found.end() :]
        sizes = (0.0, -1.0, 0.5, 0.9, 1.1, 2.0, 1e-3, 1e3, 1e-12, 1e12)
        scaled = f"{float(found[0]) * chance.choice(sizes):.12g}"
        pairs = ((found[0], f" {chance.choice(UNITS)}"), (chance.choice(NUMBERS), unit))
        return "".join(chance.choice((*pairs, (scaled, unit), (scaled, unit))))
    if isinstance(old, str):
        return chance.choice((chance.choice(WORDS), old + chance.choice(TEXTS), old[:-1]))
    return leaf(chance)


def _places(item: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Paths of everything below ``item``; of published values, which would be most, the whole."""
    found = [path] if path else []
    if isinstance(item, dict) and path[-1:] != ("published",):
        for key, one in item.items():
            found += _places(one, (*path, key))
    elif isinstance(item, list) and path[-1:] != ("published",):
        for place, one in enumerate(item[:40]):
            found += _places(one, (*path, place))
    return found


def mutated(chance: Random, tree: dict[str, Any], mild: float = 0.55) -> dict[str, Any]:
    """A copy with one to three changes; ``mild``: the share of those near to what was there."""
    tree = copy.deepcopy(tree)
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        path, action = chance.choice(_places(tree) or [("spring",)]), chance.random()
        table = tree
        for part in path[:-1]:
            table = table[part]
        last = path[-1]
        if action < mild:
            old = table[last] if isinstance(table, list) or last in table else None
            table[last] = near(chance, old)
        elif action < 0.8:
            table[last] = value(chance)
        elif action < 0.88:
            table.pop(last, None) if isinstance(table, dict) else table.pop(last)
        elif isinstance(table, dict):
            table[chance.choice((*key_words(), chance.choice(TEXTS)))] = value(chance)
        else:
            table.insert(chance.randrange(len(table) + 1), value(chance))
    return tree


@cache
def cases() -> dict[str, dict[str, Any]]:
    """Tree of every shipped case and template."""
    files = [*LIBRARY.glob("*.toml"), *(LIBRARY.parents[1] / "templates").glob("*.toml")]
    return {path.stem: tomllib.loads(path.read_text("utf-8")) for path in sorted(files)}


@cache
def key_words() -> tuple[str, ...]:
    """Every key that a shipped case holds."""
    paths = (path for tree in cases().values() for path in _places(tree))
    return tuple(sorted({path[-1] for path in paths if isinstance(path[-1], str)}))


def case_text(tree: dict[str, Any]) -> bytes:
    """The tree as TOML; what the writer cannot say is a text of many brackets."""
    try:
        return toml_text(tree).encode("utf-8", "surrogatepass")
    except (ValueError, RecursionError):
        return b"[spring]\nwire_diameter = " + b"[" * 400


def case_mutant(chance: Random) -> bytes:
    """A mutant of a shipped case: of its tables, or of its text."""
    tree = cases()[chance.choice(sorted(cases()))]
    if chance.random() < 0.7:
        return case_text(mutated(chance, tree))
    text = case_text({key: one for key, one in tree.items() if key != "published"})
    return damaged_text(chance, text) if chance.random() < 0.5 else damaged(chance, text)


@cache
def short_cases() -> dict[str, dict[str, Any]]:
    """The shipped cases at one speed, without what was published of them."""
    found, left_out = {}, ("published", "study", "sources", "remarks")
    for name, whole in cases().items():
        tree = {key: one for key, one in copy.deepcopy(whole).items() if key not in left_out}
        operation = tree.setdefault("operation", {})
        operation.pop("cam_speeds", None)
        operation |= {"engine_speeds": "4000 rpm"} if "lift_law" in tree else {}
        tree.get("train", {}).pop("variants", None)
        found[name] = tree
    return found


def damaged(chance: Random, content: bytes) -> bytes:
    """Bytes exchanged, zeroed, cut, repeated or removed."""
    changed = bytearray(content)
    for _ in range(chance.choice((1, 1, 1, 2, 5))):
        first = chance.randrange(max(1, len(changed)))
        last = min(len(changed), first + chance.choice((1, 1, 4, 64, 4096)))
        action = chance.randrange(6)
        if action <= 1 and changed:
            changed[first] ^= 1 << chance.randrange(8)
        elif action == 2:
            changed[first:last] = chance.choice((bytes(last - first), chance.randbytes(8)))
        elif action == 3:
            del changed[first:]
        elif action == 4:
            changed[first:first] = changed[first:last] * chance.choice((1, 30))
        else:
            del changed[first:last]
    return bytes(changed)


def _scaled(line: str, factor: float) -> str:
    return _NUMBER.sub(lambda one: f"{float(one[0]) * factor:g}", line)


def damaged_text(chance: Random, content: bytes) -> bytes:
    """A text with numbers, lines or separators exchanged, or in another encoding."""
    text = content.decode("utf-8", "replace")
    for _ in range(chance.choice((1, 1, 2, 4))):
        lines, action = text.split("\n"), chance.randrange(7)
        place = chance.randrange(len(lines))
        if action <= 2 and (found := [*_NUMBER.finditer(lines[place])]):
            one = chance.choice(found)
            new = chance.choice((str(near(chance, one[0])), chance.choice(NUMBERS)))
            lines[place] = lines[place][: one.start()] + new + lines[place][one.end() :]
        elif action == 3:
            lines[place] = chance.choice(("", lines[place] * 2, chance.choice(TEXTS)))
        elif action == 4:
            lines[place:] = chance.choice(
                (lines[: place + 1], lines[place + 1 :], lines[:place:-1])
            )
        elif action == 5:
            old, new = chance.choice(
                ((",", ";"), (".", ","), (",", "\t"), ("mm", "N"), ("deg", "s"))
            )
            lines = [line.replace(old, new) for line in lines]
        else:
            factor = chance.choice((0.0, -1.0, 1e-3, 1e3, 1e6, 1e300))
            lines[place:] = [_scaled(line, factor) for line in lines[place:]]
        text = "\n".join(lines)
    return text.encode(chance.choice(("utf-8",) * 8 + ("utf-16", "latin-1")), "replace")
