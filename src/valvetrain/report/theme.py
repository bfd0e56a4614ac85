"""The look of every page and figure: colours, type, marks. Nothing here knows what is drawn."""

from __future__ import annotations

from valvetrain import registry
from valvetrain.springs.spec import spring_model

INK = "#1b2430"
MUTED = "#5f6b7a"
RULE = "#c9d0d9"
GRID = "#e9edf1"
BAND = "#f4f6f9"
PAPER = "#ffffff"

FONT = "'Source Sans 3', 'Segoe UI', 'Helvetica Neue', 'Liberation Sans', Arial, sans-serif"

#: Colours of a series that belongs to no model, in order.
SERIES = (
    "#1f5aa6",
    "#d9772b",
    "#16877a",
    "#7a4fa0",
    "#7b8794",
    "#a33b53",
    "#8c6d1f",
    "#3c7d3f",
    "#4b5aa8",
    "#1b2430",
)

#: Light to dark, for maps of a quantity that starts at zero.
SEQUENTIAL = (
    "#ffffff",
    "#dbe8f4",
    "#a9cbe6",
    "#66a3d2",
    "#2f74b5",
    "#174a8a",
    "#3a1752",
    "#a3263f",
)


def model_label(model: str) -> str:
    """A spring model's name as a reader knows it; any other label without its hyphens."""
    return (
        spring_model(model).label
        if registry.is_known("springs", model)
        else model.replace("-", " ")
    )


#: Where the words next to a mark are, so that marks of several origins at one place stay readable.
LABEL_SIDES = {"circle": "top", "diamond": "right", "triangle": "left", "square": "bottom"}


def mix(first: str, second: str, share: float) -> str:
    """Colour between two ``#rrggbb`` colours; ``share`` 0 gives the first."""
    ends = [[int(text[place : place + 2], 16) for place in (1, 3, 5)] for text in (first, second)]
    return "#" + "".join(
        f"{round(one + (two - one) * share):02x}" for one, two in zip(*ends, strict=True)
    )


def ramp(count: int, first: str = "#9fc3e6", last: str = "#12294f") -> tuple[str, ...]:
    """``count`` colours from light to dark, for things with an order such as coils."""
    return tuple(mix(first, last, index / max(count - 1, 1)) for index in range(count))
