"""Answers as parts of a page: of a saved run, of two runs next to each other, of a test over a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from valvetrain.compare_test import ModelAgainstTest
from valvetrain.errors import InputError
from valvetrain.solution.status import PartialFailures
from valvetrain.views.page import Content, content_of, packed, packed_parts, part_of, unpacked
from valvetrain.views.results import answer_of
from valvetrain.workbench.answers import compare
from valvetrain.workbench.saved_runs import Run

#: A part as results.js takes it: ``html``, and the packed ``data`` of its figures.
Part = dict[str, str]
#: Largest page that is read (bytes).
MAX_PAGE = 50_000_000


def part(content: Content, prefix: str = "") -> Part:
    """An answer as a part of a page; ``prefix``: begins its ids."""
    return {"html": part_of(content.texts, prefix), "data": packed(content.data)}


def run_part(run: Run) -> Part:
    """The answer that the page of a run holds. Raises :class:`InputError` for a run without one."""
    found = _packed_of(run)
    return {"html": part_of(unpacked(found["answer"])), "data": found["data"]}


def test_part(found: ModelAgainstTest) -> Part:
    """Test data over a run, as ``valvetrain compare-test`` shows them."""
    return part(_content(found), "test-")


def comparison_part(run_a: Run, run_b: Run) -> Part:
    """What differs between two runs, as ``valvetrain compare-runs`` shows it, with the figures that both have over each other."""
    content = content_of(compare(run_a, run_b), PartialFailures())
    figures, data = dict[str, Any](), dict[str, Any]()
    try:
        found = [_packed_of(run) for run in (run_a, run_b)]
    except InputError:  # a run without a page has numbers
        return part(content)
    (texts, of_a), (_, of_b) = ((unpacked(one["answer"]), unpacked(one["data"])) for one in found)
    for name, about in texts["figures"].items():
        if (key := f"data-{name}") in of_b and (drawn := over(of_a[key], of_b[key])) is not None:
            figures[name], data[key] = about | {"hint": "solid: run A; dashed: run B"}, drawn
    texts = content.texts | {"figures": content.texts["figures"] | figures}
    return part(replace(content, texts=texts, data=content.data | data))


def over(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, Any] | None:
    """The figure ``first`` with the solid lines of ``second`` dashed over it; None where it has none. Axes reach as far as
    both need.
    """
    lines = [
        trace | {"name": f"{trace.get('name', '')}, B", "line": trace.get("line", {}) | {"dash": "dash"}}
        for trace in second["data"]
        if trace.get("mode") == "lines" and trace.get("line", {}).get("dash", "solid") == "solid"
        and f"yaxis{str(trace.get('yaxis', 'y'))[1:]}" in first["layout"]
    ]  # fmt: skip
    if not lines:
        return None
    made = {**first, "data": [*first["data"], *lines]}
    for layout in ("layout", "narrow"):
        other = second[layout]
        made[layout] = {
            key: _reaching(axis, other.get(key, {})) if key.startswith("yaxis") else axis
            for key, axis in first[layout].items()
        }
    return made


def _reaching(axis: dict[str, Any], other: Mapping[str, Any]) -> dict[str, Any]:
    """A y axis as far as it and another one reach."""
    mine, others = axis.get("range"), other.get("range")
    if not mine or not others:
        return {name: value for name, value in axis.items() if name != "range"}
    return axis | {"range": [min(mine[0], others[0]), max(mine[1], others[1])]}


def _content(result: object) -> Content:
    answer = answer_of(result)
    if answer is None:
        raise InputError(f"a {type(result).__name__} has no answer to show")
    return content_of(answer, PartialFailures())


def _packed_of(run: Run) -> dict[str, str]:
    """Texts and data that the page of a run packs."""
    page = run.page
    if page is None or page.stat().st_size > MAX_PAGE:
        raise InputError("this run wrote no report; run it again", run.run_id)
    try:
        found = packed_parts(page.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError):
        raise InputError("the report of this run is damaged; run it again", run.run_id) from None
    if {"answer", "data"} - found.keys():
        raise InputError("the report of this run is of another version; run it again, or download it", run.run_id)  # fmt: skip
    return found
