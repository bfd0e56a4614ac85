"""Unit: every way in which a key of an identification file is taken: what is read, what is refused,
and the key that is named.
"""

from __future__ import annotations

from typing import Any

import pytest

from valvetrain.errors import InputError
from valvetrain.explore.part import MAX_LENGTH, Part

MISSING = object()
#: Way of taking, what is told beside the key, what the file holds, what is read.
READ: list[tuple[str, tuple[Any, ...], Any, Any]] = [
    ("text", (), "spring", "spring"), ("text", ("own",), MISSING, "own"), ("text", ("own",), "other", "other"),
    ("text", ("one", ("one", "two")), "two", "two"),
    ("texts", (), "one", ("one",)), ("texts", (), ["one", "two"], ("one", "two")), ("texts", (), [], ()), ("texts", (), MISSING, ()),
    ("truth", (False,), True, True), ("truth", (True,), False, False),
    ("truth", (True,), MISSING, True), ("truth", (False,), MISSING, False),
    ("plain", (), 3, 3.0), ("plain", (), 0.25, 0.25), ("plain", (2.0,), MISSING, 2.0), ("plain", (2.0,), 0, 0.0),
    ("amount", ("m",), "4 mm", (4e-3, "mm")), ("amount", ("N", 7.0), MISSING, (7.0, "N")), ("amount", (None, 7.0), MISSING, (7.0, "")),
    ("amount", ("N/m",), "40 N/mm", (40e3, "N/mm")), ("amount", (None,), "2 kN", (2e3, "kN")), ("amount", (None,), 0.3, (0.3, "")),
    ("amounts", ("m",), "0, 5, 10 mm", (0.0, 5e-3, 10e-3)), ("amounts", ("N",), ["1 N", "2 kN"], (1.0, 2000.0)),
    ("amounts", (None,), [1, 2.5], (1.0, 2.5)), ("amounts", (None,), 3, (3.0,)),
]  # fmt: skip
#: The same, and words of the refusal.
REFUSED: list[tuple[str, tuple[Any, ...], Any, str]] = [
    ("text", (), MISSING, "is missing; give key"), ("text", (), 3, "is '3'; write a text"), ("text", ("own",), ["a"], "write a text"),
    ("text", ("one", ("one", "two")), "three", "'three' is unknown"),
    ("texts", (), 3, "holds something else than texts"), ("texts", (), True, "holds something else than texts"),
    ("texts", (), ["one", 2], "holds something else than texts"), ("texts", (), [["one"]], "holds something else than texts"),
    ("texts", (), {"one": "two"}, "holds something else than texts"),
    ("truth", (False,), 1, "is '1'; write true or false"), ("truth", (False,), "true", "write true or false"),
    ("plain", (), MISSING, "is 'missing'; write a number"), ("plain", (), True, "is 'True'; write a number"),
    ("plain", (), "3", "write a number"),
    ("amount", ("m",), MISSING, "is missing; give key"), ("amount", ("m",), "4 N", "is a force"), ("amount", ("m",), True, ""),
    ("amounts", ("m",), MISSING, "is missing; give key"), ("amounts", ("m",), "1, 2 N", "is a force"), ("amounts", ("m",), [True], ""),
    ("parts", (), MISSING, "there is none; write a table [key.NAME]"), ("parts", (), {}, "there is none"),
    ("parts", (), 3, "write a table"),
    ("parts", (), {" ": {}}, "is no name"), ("parts", (), {"a" * (MAX_LENGTH + 1): {}}, "is no name"),
    ("parts", (), {"a\x07": {}}, "is no name"),
    ("parts", (), {"a": 3}, "write a table"),
]  # fmt: skip


def part(holds: Any, where: str = "search") -> Part:
    return Part({} if holds is MISSING else {"key": holds}, where)


@pytest.mark.parametrize(("way", "told", "holds", "due"), READ)
def test_a_key_is_read_as_what_it_must_be(way, told, holds, due):
    table = part(holds)
    found = getattr(table, way)("key", *told)
    assert found == (
        pytest.approx(due)
        if way in ("plain", "amounts")
        else (pytest.approx(due[0]), due[1])
        if way == "amount"
        else due
    )
    assert isinstance(found, type(due)) and table.has("key") == (holds is not MISSING)
    table.finish()


@pytest.mark.parametrize("where", ["search", ""])
@pytest.mark.parametrize(("way", "told", "holds", "words"), REFUSED)
def test_a_refusal_names_the_key(way, told, holds, words, where):
    with pytest.raises(InputError) as refused:
        getattr(part(holds, where), way)("key", *told)
    assert words in str(refused.value)
    assert refused.value.where.removesuffix(".a").removesuffix("[0]") == (
        f"{where}.key" if where else "key"
    )


def test_tables_below_a_key_stand_by_their_names():
    found = part({"a": {"x": 1}, "b" * MAX_LENGTH: {}}).parts("key")
    assert [(name, one.where) for name, one in found] == [
        ("a", "search.key.a"),
        ("b" * MAX_LENGTH, "search.key." + "b" * 40),
    ]
    assert found[0][1].plain("x") == 1.0


def test_what_nobody_takes_is_refused_with_the_nearest_that_was_taken():
    table = Part({"draws": 3, "speed": 4}, "search")
    table.take("draws")
    table.take("speeds")
    with pytest.raises(InputError, match=r"key 'speed' is unknown.*speeds") as refused:
        table.finish()
    assert refused.value.where == "search"
    with pytest.raises(InputError, match="write a table"):
        Part([1], "search")
