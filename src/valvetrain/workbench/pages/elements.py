"""Elements of the pages: plain HTML with words, and the parts that have a script of their own."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
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


class Scripted(ui.element):
    """An element with a script of its own: the values it shows (``props``), and what is called ``on`` its events."""

    def __init__(self, on: Mapping[str, Handler] = MappingProxyType({}), **props: Any) -> None:
        super().__init__()
        for event, handler in on.items():
            self.on(event, handler)
        self.tell(**props)

    def tell(self, **props: Any) -> None:
        """Change what it shows."""
        for key, value in props.items():
            self.props[key] = value
        self.update()


class Theme(Scripted, component="theme.js"):
    """The button for light or dark, which shows its state."""


class Form(Scripted, component="form.js"):
    """The form of a case: ``groups`` of fields, those ``open`` at first, and ``additions``, as
    :class:`valvetrain.workbench.form.CaseForm` has them.
    """

    def answer(self, key: str, sentence: str) -> None:
        """The refusal of what was typed for ``key``, or of the table that was to be added or
        removed; empty where it was taken.
        """
        self.run_method("answer", key, sentence)


class Slider(Scripted, component="slider.js"):
    """One of ``quantities`` on a slider, with the curve that follows it; ``floats``: the case has a float speed."""

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


class Order(Scripted, component="order.js"):
    """What to run: ``kinds`` of jobs with their fields, what is ``given``, ``estimate``, ``refusal``, and whether a job is
    running (``busy``).
    """


class JobPanel(Scripted, component="job.js"):
    """State of a ``job``."""


class Results(Scripted, component="results.js"):
    """An answer, fetched from ``source`` (an address of this server): verdict, first figure, rows; the rest folded."""


class Upload(Scripted, component="upload.js"):
    """A file to send to ``url``, at most so large (``most``, bytes); ``many``: several together. ``field``: its id."""
