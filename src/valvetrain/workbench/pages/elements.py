"""Elements of the pages: plain HTML with words, and the parts that have a script of their own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from nicegui import ui
from nicegui.elements.mixins.text_element import TextElement

from valvetrain.workbench.pages.live_curve import Trace, live_figure

Handler = Callable[..., Any]


def tag(name: str, /, label: str = "", classes: str = "", **attributes: str | None) -> ui.element:
    """An HTML element ``name`` with ``words``; an underscore in the name of an attribute is
    for a hyphen, None leaves it out.
    """
    made = TextElement(tag=name, text=label) if label else ui.element(name)
    if classes:
        made.classes(classes)
    for key, value in attributes.items():
        if value is not None:
            made.props[key.rstrip("_").replace("_", "-")] = value
    return made


def button(
    label: str, on_click: Handler, classes: str = "button", **attributes: str | None
) -> ui.element:
    """A button."""
    return tag("button", label, classes, type="button", **attributes).on("click", on_click, args=[])


def link(label: str, href: str, classes: str = "", **attributes: str | None) -> ui.element:
    """A link."""
    return tag("a", label, classes, href=href, **attributes)


class Theme(ui.element, component="theme.js"):
    """The button for light or dark, which shows its state."""


class Form(ui.element, component="form.js"):
    """The form of a case: ``groups`` of fields and ``additions`` as
    :mod:`valvetrain.workbench.pages.forms` gives them.
    """

    def __init__(
        self,
        groups: Sequence[Mapping[str, Any]],
        additions: Sequence[Mapping[str, str]],
        opened: Sequence[str],
        on: Mapping[str, Handler],
    ) -> None:
        super().__init__()
        self.props["groups"], self.props["additions"], self.props["open"] = (
            list(groups),
            list(additions),
            list(opened),
        )
        for event, handler in on.items():
            self.on(event, handler)

    def show(
        self, groups: Sequence[Mapping[str, Any]], additions: Sequence[Mapping[str, str]]
    ) -> None:
        """Other fields or values."""
        self.props["groups"], self.props["additions"] = list(groups), list(additions)
        self.update()

    def answer(self, key: str, sentence: str) -> None:
        """The refusal of what was typed for ``key``, or of the table that was to be added or
        removed; empty where it was taken.
        """
        self.run_method("answer", key, sentence)


class Slider(ui.element, component="slider.js"):
    """One quantity on a slider, with the curve that follows it."""

    def __init__(
        self,
        quantities: Sequence[Mapping[str, Any]],
        engine_speed: str,
        floats: bool,
        on: Mapping[str, Handler],
    ) -> None:
        super().__init__()
        self.props["quantities"], self.props["speed"] = list(quantities), engine_speed
        self.props["floats"] = floats
        for event, handler in on.items():
            self.on(event, handler)

    def show(
        self, quantities: Sequence[Mapping[str, Any]], engine_speed: str, floats: bool
    ) -> None:
        """Other quantities or values of theirs; ``floats``: the case has a float speed."""
        self.props["quantities"], self.props["speed"] = list(quantities), engine_speed
        self.props["floats"] = floats
        self.update()

    def float_answer(self, label: str) -> None:
        """The float speed in words."""
        self.run_method("floatAnswer", label)

    def answer(
        self, lines: Sequence[Trace], numbers: Sequence[Mapping[str, str]], sentence: str
    ) -> None:
        """What the chain answered: lines (none where it was overtaken), numbers, or a sentence."""
        self.run_method("answer", live_figure(lines), list(numbers), sentence)

    def rod_answer(self, lines: Sequence[Trace], sentence: str) -> None:
        """What the rod answered."""
        self.run_method("rodAnswer", live_figure(lines), sentence)


class Order(ui.element, component="order.js"):
    """What to run."""

    def __init__(self, choices: Mapping[str, Any], on_estimate: Handler, on_run: Handler) -> None:
        super().__init__()
        self.tell(estimate="", refusal="", busy=False, **choices)
        self.on("estimate", on_estimate)
        self.on("run", on_run)

    def tell(self, **values: Any) -> None:
        """Change what it shows."""
        for key, value in values.items():
            self.props[key] = value
        self.update()


class JobPanel(ui.element, component="job.js"):
    """State of a job."""

    def __init__(self, on_cancel: Handler, on_again: Handler) -> None:
        super().__init__()
        self.props["job"] = None
        self.on("cancel", on_cancel, args=[])
        self.on("again", on_again, args=[])

    def show(self, job: Mapping[str, Any] | None) -> None:
        """Another state; nothing is sent where it is the same."""
        if self.props["job"] != job:
            self.props["job"] = job
            self.update()


class Results(ui.element, component="results.js"):
    """An answer, fetched from ``source`` (an address of this server): verdict, first figure, rows; the rest folded."""

    def __init__(self, source: str = "") -> None:
        super().__init__()
        self.props["source"] = source

    def show(self, source: str) -> None:
        """Another answer."""
        if self.props["source"] != source:
            self.props["source"] = source
            self.update()


class Upload(ui.element, component="upload.js"):
    """A file to send to ``url``; ``many``: several together."""

    def __init__(
        self,
        field: str,
        label: str,
        hint: str,
        url: str,
        accept: str,
        most: int,
        on_done: Handler | None = None,
        many: bool = False,
    ) -> None:
        super().__init__()
        shown_unit = {
            "field": field,
            "label": label,
            "hint": hint,
            "url": url,
            "accept": accept,
            "most": most,
            "many": many,
        }
        for key, value in shown_unit.items():
            self.props[key] = value
        if on_done is not None:
            self.on("done", on_done)
