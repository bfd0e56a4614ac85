"""Values that a stranger's case file may hold: extremes, wrong units, foreign signs, deep nesting."""

from __future__ import annotations

import random
from typing import Any

NUMBERS = (
    "0", "-0", "1", "-1", "2", "3", "4", "5", "7", "13", "100", "400", "1000", "65536", "1000000", "2147483648", "1e9", "-1e9", "1e-9",
    "1e-30",
    "1e30", "1e-300", "1e300", "1e308", "1e309", "5e-324", "nan", "inf", "-inf", "0.1", "0.5", "0.999999", "1.0000001", "1e15", "1e-15",
    "9" * 40, "9" * 400, "1e1000", "1e99999", "0x10", "1_000", "1,5", "1/2", "١٢", "½", "+-1", "1e", "--", ".",
)  # fmt: skip
UNITS = (
    "mm", "m", "km", "nm", "um", "in", "N", "kN", "N/mm", "N/m", "GPa", "MPa", "Pa", "g", "kg", "kg/m^3", "g/cm^3", "deg", "rad", "rpm",
    "Hz",
    "rad/s", "s", "ms", "%", "", "1/s", "N*s/m", "N/m^1.5", "N/m^2", "m/s^2", "J", "K", "degC", "furlong", "mm^9", "mm**-3", "lb", "lbf/in",
    "mm mm mm", "µm", "°", "parsec", "1", "mm/", "light_year", "Ångström", "banana", "mm^1.999", "()", "decibel", "delta_degC",
    "dimensionless",
)  # fmt: skip
TEXTS = (
    "", " ", "\n", "\t", "\r\n", "a\n*INCLUDE, INPUT=/etc/hostname\n*STEP", "<!--<script>", "</script><script>alert(1)</script>", "]]>",
    "<img src=x onerror=alert(1)>", "\"'`", "=1+1", "@SUM(A1)", "+cmd", "-1", "\x1b[2J\x1b[31m", "\x07", "\x00", "\x7f", "\x9b31m",
    "\u2028\u2029", "\u202eabc\u2066", "\ufeff", "\ufffd", "😀", "é", "名前", "a/b", "../../../tmp/x", "..", ".", "/", "\\", "C:\\x", "-",
    "--help",
    "~", "$HOME", "%s%n", "{0}", "{{7*7}}", "{% raw %}", "${jndi:x}", "a" * 300, "b" * 5000, "a,b;c", "#", "# x", "nul", "con", "*", "?",
    "|",
    "%", "[0]", "x\u0301" * 50, "ﬁ", "İ", "ß", "\U000e0041", "gu2021", "gu2021, Table 1", "nobody1999", "outer", "inner", "spring", "stock",
)  # fmt: skip
WORDS = (
    "open", "closed", "closed-ground", "open-ground", "spline", "stations", "polydyne", "three-arc", "tangent", "cycloidal", "harmonic",
    "modified-sine", "polynomial", "zero", "cam-card", "sine-power", "flank-pulse", "massless", "multi-mass", "finite-element",
    "modal-varied",
    "modal-uniform", "wave-rod", "linear", "nested", "solid", "lift", "cam", "valve", "direct", "finger", "rocker", "pushrod", "planar",
    "lumped",
    "single-mass", "flat", "domed", "roller", "knife", "left", "right", "planes", "bonded", "hertz-line", "hertz-point", "hunt-crossley",
    "lankarani-nikravesh", "flores", "rigid", "restitution", "EN 10270-2 VDSiCr", "OTEVA 90 SC", "published", "measured", "assumed",
    "identified",
)  # fmt: skip


def number(rng: random.Random) -> Any:
    """A number, bare."""
    kind = rng.randrange(8)
    if kind == 0:
        return rng.choice(
            (
                0,
                1,
                -1,
                2,
                3,
                4,
                7,
                60,
                400,
                10_000,
                10_001,
                2**31,
                2**63,
                -(2**63),
                10**18,
                10**400,
                10**5000,
            )
        )
    if kind == 1:
        return rng.choice(
            (
                0.0,
                -0.0,
                1.0,
                1e-300,
                1e300,
                float("nan"),
                float("inf"),
                -float("inf"),
                5e-324,
                1e-9,
                0.3,
                1e9,
            )
        )
    if kind == 2:
        return rng.uniform(-10, 10) * 10.0 ** rng.randint(-12, 12)
    return rng.randint(-5, 50)


def text_number(rng: random.Random) -> str:
    """A number as text, sensible about every second time."""
    if rng.random() < 0.5:
        return f"{rng.uniform(0, 10) * 10.0 ** rng.randint(-4, 4):.{rng.randint(1, 17)}g}"
    return rng.choice(NUMBERS)


def leaf(rng: random.Random) -> Any:
    """A plain value of any kind."""
    kind = rng.randrange(10)
    if kind < 4:
        return f"{text_number(rng)}{rng.choice(('', ' ', ' ', '  '))}{rng.choice(UNITS)}"
    if kind < 6:
        return number(rng)
    if kind == 6:
        return rng.choice((True, False))
    if kind == 7:
        return rng.choice(WORDS)
    if kind == 8:
        return (
            f"{', '.join(text_number(rng) for _ in range(rng.randint(1, 6)))} {rng.choice(UNITS)}"
        )
    return rng.choice(TEXTS)


def value(rng: random.Random, depth: int = 0) -> Any:
    """A value, a list or a table of them."""
    kind = rng.random()
    if kind < 0.8 or depth > 3:
        return leaf(rng)
    if kind < 0.9:
        return [value(rng, depth + 1) for _ in range(rng.choice((0, 1, 2, 3, 3, 60)))]
    if kind < 0.97:
        keys = (
            "value",
            "status",
            "source",
            "kind",
            "name",
            "law",
            "file",
            rng.choice(TEXTS),
            rng.choice(WORDS),
        )
        return {rng.choice(keys): value(rng, depth + 1) for _ in range(rng.randint(0, 4))}
    nested: Any = leaf(rng)
    for _ in range(rng.choice((5, 50, 400))):
        nested = [nested] if rng.random() < 0.5 else {"value": nested}
    return nested


def near(rng: random.Random, old: Any) -> Any:
    """A value like ``old``: its number scaled, its unit exchanged, its length changed."""
    if isinstance(old, bool):
        return not old
    if isinstance(old, int):
        return rng.choice((old + 1, old - 1, -old, old * 10, old * 1000, 0, old * 10**9))
    if isinstance(old, float):
        return old * rng.choice((0.0, -1.0, 0.5, 2.0, 1e-3, 1e3, 1e-30, 1e30))
    if isinstance(old, list):
        many = list(old)
        for _ in range(rng.randint(1, 3)):
            action = rng.randrange(5)
            if action == 0 and many:
                del many[rng.randrange(len(many))]
            elif action == 1 and many:
                many.insert(rng.randrange(len(many) + 1), rng.choice(many))
            elif action == 2:
                rng.shuffle(many)
            elif action == 3 and many:
                place = rng.randrange(len(many))
                many[place] = near(rng, many[place])
            else:
                many.append(value(rng))
        return many
    if isinstance(old, str):
        head, _, unit = old.partition(" ")
        try:
            size = float(head)
        except ValueError:
            return rng.choice(
                (
                    rng.choice(WORDS),
                    rng.choice(TEXTS),
                    old + rng.choice(TEXTS),
                    old[: rng.randint(0, len(old))],
                )
            )
        action = rng.randrange(4)
        if action == 0:
            return f"{head} {rng.choice(UNITS)}"
        if action == 1:
            return f"{rng.choice(NUMBERS)} {unit}"
        return f"{size * rng.choice((0.0, -1.0, 0.5, 0.9, 1.1, 2.0, 1e-3, 1e3, 1e-12, 1e12)):.12g} {unit}"
    return leaf(rng)
