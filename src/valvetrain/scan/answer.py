"""What ``scan`` shows: whether the scan covers the spring, its sizes with their scatter, and its design next to it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from valvetrain.findings.engine import Mark
from valvetrain.findings.words import Amount
from valvetrain.parameters.installed_spring import InstalledSpring
from valvetrain.parameters.summary import percent
from valvetrain.scan import figures
from valvetrain.scan.compare import ComparedNumber, ScanComparison
from valvetrain.scan.result import ScannedSpring
from valvetrain.scan.rules import AS_DRAWN, BRIDGED, RULES, ScanFacts, degrees, length
from valvetrain.solution.definition import label_of
from valvetrain.views.files import spring_text
from valvetrain.views.shown import ShownByRules
from valvetrain.views.style import FigureSpec
from valvetrain.views.table import Line, TextTable

#: Quantities at rest in the first table, and standard deviations of a 95 % interval.
FIRST, BAND = ("installed_rate", "preload", "coil_bind_lift", "mode_1_frequency"), 2.0
GREY = "grey: 95 % of what the scatter of the points leaves"


@dataclass(frozen=True)
class ScanAnswer(ShownByRules):
    """What is shown of a ``scan``, and of the comparison with its design, in the units of the reader by default."""

    rules = RULES

    scan: ScannedSpring
    compared: ScanComparison | None = None

    @property
    def facts(self) -> ScanFacts:
        """The scan as rules read it."""
        return ScanFacts(self.scan, self.compared)

    @property
    def title(self) -> str:
        """The file, and the design that it is compared with."""
        beside = "" if self.compared is None else f", design {self.compared.cases[0].name}"
        return f"Spring from the scan {self.scan.source} ({self.scan.form}, {self.scan.unit}){beside}"  # fmt: skip

    @property
    def headings(self) -> list[str]:
        """Columns of the first table."""
        return [""] if self.compared is None else ["design", "scan", "difference"]

    @property
    def rests_on(self) -> list[str]:
        """What the scan does not show."""
        return list(self.scan.notes)

    @cached_property
    def lines(self) -> list[Line]:
        """Sizes and ends, then how well the scan shows them, or rate and preload of design and scan."""
        return [*self._sizes(), *(self._seen() if self.compared is None else self._loads())]

    def _sizes(self) -> Iterator[Line]:
        facts, words = self.facts, replace(self.words, brief=True)
        for size in facts.sizes:
            bar, name = BAND * float(np.max(size.spread)), size.quantity
            low, high = (Amount(name, float(end(size.values)), bar) for end in (np.min, np.max))
            made = words.span(low, high, 4)
            cells: tuple[str, ...] = (f"{made} ± {words.amount(Amount(name, bar), 2)}",)
            if size.drawn is not None:  # next to the design's
                low, high = (Amount(name, float(end(size.drawn))) for end in (np.min, np.max))
                off = size.values - size.drawn
                furthest = Amount(name, float(off[np.argmax(np.abs(off))]), bar)
                cells = words.span(low, high, 4), made, words.amount(furthest, 2)
            yield Line(size.label, cells)
        for place in ("lower_end", "upper_end"):
            ends = [
                getattr(wire, place)
                for wire in (facts.design, self.scan.definition)
                if wire is not None
            ]
            kinds = (*(end.kind for end in ends), "")[: len(self.headings)]
            yield Line(
                place.replace("_", " "), kinds, "", f"{ends[-1].ground_coils:.2f} turns ground"
            )

    def _seen(self) -> Iterator[Line]:
        scan, seen = self.scan, self.scan.coverage
        share, scatter = scan.points_on_wire / scan.points_fitted, self.words.amount(length(scan.noise), 2)  # fmt: skip
        mark: Mark = "bad" if seen.sector > BRIDGED else "ok"
        yield Line("points", (f"{scan.points_fitted}, scatter {scatter}",), "", f"{100 * share:.0f} % on the wire")  # fmt: skip
        yield Line("seen", (f"{100 * seen.around:.0f} % around the wire",), mark, f"gap about the axis {degrees(seen.sector)}")  # fmt: skip

    def _loads(self) -> Iterator[Line]:
        for number in self.facts.numbers:
            if number.quantity in FIRST:
                mark: Mark = "ok" if abs(number.difference) <= AS_DRAWN else "warn"
                yield Line(label_of(number.quantity), self._compared(number), mark)

    def _compared(self, number: ComparedNumber) -> tuple[str, ...]:
        both = (self.words.amount(Amount(number.quantity, value), 4) for value in (number.design, number.scanned))  # fmt: skip
        return *both, percent(number.difference) if number.design else ""

    def tables(self) -> Mapping[str, TextTable]:
        """Every compared number."""
        rows = tuple((label_of(number.quantity), *self._compared(number)) for number in self.facts.numbers)  # fmt: skip
        return {"numbers": TextTable("Design and scan", ("quantity", *self.headings), rows)}

    def figures(self) -> Mapping[str, FigureSpec]:
        """The points about the axis and the curves; design and scan by force first where there is a design."""
        hint = "unrolled about the axis of the spring; a white band from bottom to top was not seen"
        cloud = FigureSpec("Points and wire axis", hint, figures.cloud)
        if self.compared is None:
            return {"cloud": cloud, "curves": FigureSpec("Curves over the coil", GREY, figures.curves)}  # fmt: skip
        curves = FigureSpec("Scan less design", GREY, figures.curves)
        return {"force": FigureSpec("Force and rate", "", figures.force), "curves": curves, "cloud": cloud}  # fmt: skip

    def computed(self) -> Iterator[str]:
        """What was fitted, and what its intervals leave out."""
        yield "The surface of a tube whose axis is a smooth curve is fitted to the points. Coils are counted from the lower tip."
        yield "The intervals hold for independent errors of the points. A scanner that is wrong by a share of the length is wrong by it in all sizes."

    @property
    def text(self) -> str:
        """The case file that is written: the scanned spring free, or as its design is installed."""
        free = InstalledSpring(wire=self.scan.definition)
        spring = free if self.compared is None else self.compared.cases[1].springs[0]
        return spring_text("scan", spring, "from a scan")


def answer_of_comparison(compared: ScanComparison) -> ScanAnswer:
    """What is shown of a comparison with a design."""
    return ScanAnswer(compared.scan, compared)
