"""Unit: a page that is read back knows what stands behind which tab, and what behind none."""

from __future__ import annotations

from valvetrain.report.page import Details, Page, Section, Tabs, render, text
from valvetrain.report.read_page import sections_of


def test_parts_before_behind_and_after_tabs():
    first = Tabs(
        (("3000 rpm", (text("slow"), text("slow too"))), ("4000 rpm", (text("fast"),))), "one"
    )
    second = Tabs(
        (("stock", (text("soft"),)), ("performance", (Details("more", (text("hard"),)),))), "two"
    )
    sections = (
        Section("a", "First", (text("before"), first, text("between"), second, text("after"))), Section("b", "Second", (text("alone"),)),
        Section("c", "Third", (Tabs((("only", (text("last"),)),), "three"),)), Section("d", "Fourth", (text("end"),)),
    )  # fmt: skip
    found = sections_of(render(Page("Own", "", "", (), sections)))
    assert [one.key for one in found] == ["a", "b", "c", "d"]
    assert [(part.text, part.tab) for one in found for part in one.parts] == [
        ("before", ""),
        ("slow", "3000 rpm"),
        ("slow too", "3000 rpm"),
        ("fast", "4000 rpm"),
        ("between", ""),
        ("soft", "stock"),
        ("hard", "performance"),
        ("after", ""),
        ("alone", ""),
        ("last", "only"),
        ("end", ""),
    ]
