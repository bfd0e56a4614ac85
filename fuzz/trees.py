"""Mutants of the shipped case files: on the tree of their tables, and on their text and bytes."""

from __future__ import annotations

import copy
import random
import tomllib
from functools import cache
from typing import Any

from fuzz import values
from valvetrain.parameters.loading import LIBRARY
from valvetrain.parameters.toml_text import toml_text

TEMPLATES = LIBRARY.parents[1] / "templates"


@cache
def texts() -> dict[str, str]:
    """Text of every shipped case and template."""
    files = [*LIBRARY.glob("*.toml"), *TEMPLATES.glob("*.toml")]
    return {path.stem: path.read_text("utf-8") for path in sorted(files)}


@cache
def trees() -> dict[str, dict[str, Any]]:
    """Tree of every shipped case and template."""
    return {name: tomllib.loads(text) for name, text in texts().items()}


@cache
def key_words() -> tuple[str, ...]:
    """Every key that a shipped case holds."""
    found: set[str] = set()

    def walk(item: Any) -> None:
        if isinstance(item, dict):
            found.update(item)
            for one in item.values():
                walk(one)
        elif isinstance(item, list):
            for one in item:
                walk(one)

    for tree in trees().values():
        walk(tree)
    return tuple(sorted(found))


def places(item: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Paths of everything below ``item``, published values left out (they would be most of it)."""
    found = [path] if path else []
    if isinstance(item, dict):
        for key, one in item.items():
            found += places(one, (*path, key)) if key != "published" else [(*path, key)]
    elif isinstance(item, list):
        for place, one in enumerate(item[:40]):
            found += places(one, (*path, place))
    return found


def mutated(
    rng: random.Random, tree: dict[str, Any], mild: float = 0.55, most: int = 3
) -> dict[str, Any]:
    """A copy with one to ``most`` changes; ``mild`` is the share of those that stay near what was
    there.
    """
    tree = copy.deepcopy(tree)
    for _ in range(min(most, rng.choice((1, 1, 1, 2, 3)))):
        path = rng.choice(places(tree) or [("spring",)])
        table = tree
        for part in path[:-1]:
            table = table[part]
        last = path[-1]
        old = table[last] if isinstance(table, list) or last in table else None
        action = rng.random()
        if action < mild:
            table[last] = values.near(rng, old)
        elif action < 0.8:
            table[last] = values.value(rng)
        elif action < 0.88:
            del table[last]
        elif isinstance(table, dict):
            table[rng.choice((rng.choice(key_words()), rng.choice(values.TEXTS)))] = values.value(
                rng
            )
        else:
            table.insert(
                rng.randrange(len(table) + 1),
                copy.deepcopy(rng.choice(table)) if rng.random() < 0.7 else values.value(rng),
            )
    return tree


def written(tree: dict[str, Any]) -> str:
    """The tree as TOML; what the writer cannot say (very long integers) is said as text."""
    try:
        return toml_text(tree)
    except (ValueError, RecursionError):
        return f'title = "{len(str(list(tree)))}"\n[spring]\nwire_diameter = {"[" * 400}'


def hexadecimal(text: str, rng: random.Random) -> str:
    """A number of the text as a hexadecimal integer of thousands of digits."""
    lines = text.splitlines()
    chosen = [place for place, line in enumerate(lines) if "=" in line and not line.startswith("#")]
    if not chosen:
        return text
    place = rng.choice(chosen)
    lines[place] = f"{lines[place].split('=')[0]}= 0x{'f' * rng.choice((8, 20, 300, 4300, 6000))}"
    return "\n".join(lines)


def scrambled(rng: random.Random, text: str) -> bytes:
    """The text cut, spliced, repeated or with bytes exchanged."""
    content = bytearray(text.encode())
    for _ in range(rng.randint(1, 4)):
        action, size = rng.randrange(8), max(1, len(content))
        first = rng.randrange(size)
        last = min(len(content), first + rng.choice((1, 2, 8, 60, 400)))
        if action == 0:
            del content[first:]
        elif action == 1:
            del content[first:last]
        elif action == 2:
            content[first:first] = content[first:last] * rng.choice((1, 2, 30))
        elif action == 3 and content:
            content[first] = rng.randrange(256)
        elif action == 4:
            content[first:first] = rng.choice(values.TEXTS).encode("utf-8", "surrogatepass")
        elif action == 5:
            other = rng.choice(list(texts().values())).encode()
            start = rng.randrange(len(other))
            content[first:last] = other[start : start + rng.choice((10, 100, 1000))]
        elif action == 6:
            content[first:first] = rng.choice(
                (
                    b"[" * 2000,
                    b"{a=" * 500,
                    b" " * 20000,
                    b"'" * 3,
                    b'"""',
                    b"a." * 800,
                    b"\n" * 5000,
                    b"=",
                    b"#",
                )
            )
        else:
            lines = bytes(content).split(b"\n")
            rng.shuffle(lines)
            content = bytearray(b"\n".join(lines))
    return bytes(content[:2_000_000])


def case_mutant(rng: random.Random) -> bytes:
    """One mutant of one shipped case, as the bytes of its file."""
    name = rng.choice(sorted(texts()))
    kind = rng.random()
    if kind < 0.7:
        return written(mutated(rng, trees()[name])).encode("utf-8", "surrogatepass")
    text = texts()[name] if rng.random() < 0.3 else texts()[name].split("# ----")[0]
    return hexadecimal(text, rng).encode() if kind < 0.73 else scrambled(rng, text)
