"""What ``film`` shows: doubts, how far a model is from the film or what moves most, peaks and surge lines."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from valvetrain.film import figures
from valvetrain.film.model import FilmedModel
from valvetrain.film.result import CoilMotion
from valvetrain.film.rules import RULES, FilmFacts, displacement, frequency, nearest, ratio, rpm
from valvetrain.film.surge import BAND
from valvetrain.film.tables import LINE_COLUMNS, line_table, peak_columns, peak_table
from valvetrain.views.columns import table_of
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import FigureSpec
from valvetrain.views.table import Line, TextTable

#: Coils and surge lines in the first table at most.
COILS, LINES = 7, 2


@dataclass(frozen=True)
class FilmAnswer(ShownByRules):
    """What is shown of a film, and of the run that is compared with it; ``synthetic``: it was computed; ``folder`` of its
    files, which the next step names.
    """

    rules = RULES

    motion: CoilMotion
    model: FilmedModel | None = None
    synthetic: bool = False
    folder: str = ""

    @property
    def facts(self) -> FilmFacts:
        """The film as rules read it."""
        return FilmFacts(self.motion, self.model, self.folder)

    @property
    def title(self) -> str:
        """The film, and the case that is compared with it."""
        model = self.model
        beside = (
            "" if model is None else f", {model.spring} spring of {model.case} by {model.model}"
        )
        return f"Film {self.motion.seen.name}{', synthetic' * self.synthetic}{beside}"

    @property
    def headings(self) -> list[str]:
        """Columns of the first table."""
        return [""] if self.model is None else ["film", "model", "apart (rms)"]

    @cached_property
    def lines(self) -> list[Line]:
        """Peaks of the coils that move most, surge lines, and how well the film shows them."""
        motion, words = self.motion, self.words
        place = float(np.nanmedian(motion.spread))
        within = words.amount(displacement(place * motion.metres_per_pixel), 2)
        rows = [
            *self._coils(), *self._surge(), ("frames", f"{len(motion.places)} at {motion.seen.frame_rate:g} a second"),
            ("place of a coil", f"{place:.2g} px, {within}")
        ]  # fmt: skip
        if motion.phase is not None:
            rows.insert(
                -2, ("cam speed", f"{rpm(motion.phase.cam_speed)}, by the {motion.phase.by}")
            )
        blank = ("",) * 3
        return [Line(label, (*cells, *blank)[: len(self.headings)]) for label, *cells in rows]

    def _coils(self) -> Iterator[tuple[str, ...]]:
        for top in sorted(self.motion.peaks, key=lambda top: -top.mean)[:COILS]:
            peak, bar, *more = (self.words.amount(displacement(float(value)), digits) for value, digits in (
                (top.mean, 4), (BAND * top.spread, 2),
                *(() if self.model is None else ((self.model.peaks[top.coil - 1], 4), (self.model.apart[top.coil - 1], 2)))
            ))  # fmt: skip
            yield f"coil {top.coil}", f"{peak} ± {bar}", *more

    def _surge(self) -> Iterator[tuple[str, ...]]:
        for place, line in enumerate(self.facts.lines[:LINES], 1):
            pair = (line, nearest(self.model, line))
            yield f"surge line {place}", *(f"{self.words.said(frequency(two), 5)}, damping {ratio(two)}" for two in pair if two)  # fmt: skip

    def tables(self) -> Mapping[str, TextTable]:
        """All peaks and surge lines, by the columns that JSON and CSV have."""
        peaks = peak_table(self.motion, self.model)
        return {
            "peaks": table_of("Peaks along the spring", peak_columns(self.model), peaks, self.words),
            "surge": table_of("Surge lines", LINE_COLUMNS, line_table(self.motion), self.words)
        }  # fmt: skip

    def figures(self) -> Mapping[str, FigureSpec]:
        """The coils over the cam angle, of a cam that does not turn the decay first."""
        shaded = "shaded: valve closed; " + ("mean of the turns" if self.model is None else "dashed: the model")  # fmt: skip
        return {
            "coils": FigureSpec("Motion of the coils", shaded, figures.coils),
            "decay": FigureSpec("Free decay", "the coil that rings most", figures.decay),
            "space-time": FigureSpec("Space-time picture with the tracks", "", figures.space_time)
        }  # fmt: skip

    def computed(self) -> Iterator[str]:
        """What was found and done."""
        yield "Coils are followed by the glare line on each of them and counted from the seat. Displacements are along the picture, towards the seat."
        yield "The damping of a free decay goes into your case: name it in place of job-t."
        for note in (*self.motion.notes, *(() if self.model is None else self.model.notes)):
            yield f"{note[:1].upper()}{note[1:]}."


def answer_of_model(model: FilmedModel) -> FilmAnswer:
    """What is shown of a run that is compared with a film."""
    return FilmAnswer(model.motion, model)
