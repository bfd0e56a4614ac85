"""Lift files whose true lift is a closed form, drawn by a seed: spacing, rounding, noise and every way to write a table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

INCH = 25.4
#: Spacing of the stations (cam deg), step of the last digit (mm) with its unit and factor, and headings by language.
SPACINGS = (0.5, 1.0, 2.0, 2.5, 5.0, 10.0)
STEPS = (
    (0.0254, "in"),
    (0.0254, "thou"),
    (0.0127, "in"),
    (0.01, "mm"),
    (0.001, "mm"),
    (0.001, "um"),
)
UNITS = {"in": INCH, "thou": INCH / 1e3, "mm": 1.0, "um": 1e-3}
HEADINGS = {
    "en": ("{turn} angle (deg)", "valve lift ({unit})"), "de": ("{turn} [Grad]", "Ventilhub [{unit}]"),
    "fr": ("angle {turn} (deg)", "levée de soupape ({unit})"),
}  # fmt: skip
TURNS = {
    "en": {"cam": "cam", "crank": "crank"}, "de": {"cam": "Nockenwinkel", "crank": "Kurbelwinkel"},
    "fr": {"cam": "arbre à cames", "crank": "vilebrequin"},
}  # fmt: skip


@dataclass(frozen=True)
class KnownLift:
    """Lift (mm) of a ``shape`` over cam degrees: ``height``, ``half`` of the event, ``nose``, ``skew`` of the polynomial,
    velocity of the ramps (mm/deg).
    """

    shape: str
    height: float
    half: float
    nose: float
    skew: float = 0.0
    ramp: float = 0.0

    def lift(self, angle, derivative=0):
        """Lift, or its second derivative per square degree."""
        x = np.asarray(angle, dtype=float) - self.nose
        u = np.abs(x) / self.half
        inside = u < 1
        v = 1 - np.clip(u, 0, 1)
        if self.shape == "polynomial":
            square, c = np.clip(u, 0, 1) ** 2, self.skew
            w = 1 - square
            value = (
                w**3 * (1 + c * square),
                w
                * ((-6 * w + 24 * square) * (1 + c * square) - 24 * c * square * w + 2 * c * w**2),
            )
        elif self.shape == "harmonic":
            value = ((1 - np.cos(np.pi * v)) / 2, np.pi**2 / 2 * np.cos(np.pi * v))
        elif self.shape == "cycloidal":
            value = (v - np.sin(2 * np.pi * v) / (2 * np.pi), 2 * np.pi * np.sin(2 * np.pi * v))
        else:
            value = (10 * v**3 - 15 * v**4 + 6 * v**5, 60 * v - 180 * v**2 + 120 * v**3)
        scale = self.height / (1.0, self.half**2)[derivative == 2]
        return scale * value[derivative == 2] * inside + self._ramp(np.abs(x), derivative)

    def _ramp(self, away, derivative):
        """A ramp of constant velocity, 4 deg of onset, 14 deg long, which leaves the flank over its first 25 deg."""
        lengths = np.array([4.0, 14.0, 25.0])
        since = self.half + 10 - away
        onset, steady, end = (
            np.clip(since - start, 0, length)
            for start, length in zip((0, 4, 18), lengths, strict=True)
        )
        if derivative == 2:
            parts = (
                np.pi / (2 * length) * np.sin(np.pi * at / length)
                for at, length in ((onset, 4.0), (end, 25.0))
            )
            return self.ramp * np.subtract(*parts)
        begin, last = (
            at / 2 - length / (2 * np.pi) * np.sin(np.pi * at / length)
            for at, length in ((onset, 4.0), (end, 25.0))
        )
        return self.ramp * (begin + steady + end - last)

    def truth(self):
        """Peak (m), cam rad above 0.050 in, and least and largest acceleration (m/rad2)."""
        grid = self.nose + np.linspace(-self.half - 12, self.half + 12, 200_001)
        lift, bend = self.lift(grid), self.lift(grid, 2)
        over, step = np.flatnonzero(lift > 0.05 * INCH), np.pi / 180 * (grid[1] - grid[0])
        first, last = over[0], over[-1]
        beyond = [
            (lift[at] - 0.05 * INCH) / (lift[at] - lift[out])
            for at, out in ((first, first - 1), (last, last + 1))
        ]
        degree = np.pi / 180
        return {
            "peak_lift": 1e-3 * lift.max(), "duration_at_50_thou": step * (last - first + sum(beyond)),
            "nose_acceleration": 1e-3 * bend.min() / degree**2, "largest_acceleration": 1e-3 * bend.max() / degree**2,
        }  # fmt: skip


@dataclass(frozen=True)
class KnownFile:
    """A file with its ``text``, its true lift, and whether it is clean: stations at most 2 deg apart, noise below 0.1 % of lift."""

    text: str
    true: KnownLift
    spacing: float
    step: float
    noise: float

    @property
    def clean(self) -> bool:
        return self.spacing <= 2 and self.noise < 1e-3 * self.true.height


def known_file(seed: int) -> KnownFile:
    """The file of a ``seed``."""
    rng = np.random.default_rng([53, seed])
    shape = str(rng.choice(["polynomial", "polynomial", "harmonic", "cycloidal", "3-4-5", "ramps"]))
    height, half = rng.uniform(5, 13), rng.uniform(48, 75)
    true = KnownLift(
        "polynomial" if shape == "ramps" else shape, height, half, rng.uniform(0, 360), rng.uniform(0, 1.2),
        rng.uniform(0.005, 0.02) * (shape == "ramps"),
    )  # fmt: skip
    spacing = float(rng.choice(SPACINGS))
    step, unit = STEPS[rng.integers(len(STEPS))]
    noise = float(rng.choice([0.0, 0.0005, 0.0015, 0.004, 0.0127])) * (rng.random() < 0.8)
    turn, language = str(rng.choice(["cam", "crank"])), str(rng.choice(list(HEADINGS)))
    offset = float(rng.choice([0.0, 0.0, rng.uniform(-1, 1)]))
    sign = float(rng.choice([1.0, 1.0, -1.0]))
    angles = np.arange(0.0, 360.0, spacing)
    around = true.nose + np.mod(angles - true.nose + 180, 360) - 180
    lifts = sign * true.lift(around) + offset + rng.normal(0, 1, len(angles)) * noise
    lifts = np.round(lifts / step) * step / UNITS[unit]
    digits = max(0, round(-np.log10(step / UNITS[unit]) + 0.2))
    factor = 2.0 if turn == "crank" else 1.0
    mark = str(rng.choice([",", ";", "\t"]))
    comma = mark != "," and rng.random() < 0.5
    rows = [
        f"{factor * angle:.1f}{mark}{lift:.{digits}f}"
        for angle, lift in zip(angles, lifts, strict=True)
    ]
    if comma:
        rows = [row.replace(".", ",") for row in rows]
    if rng.random() < 0.3:
        rows.reverse()
    names = mark.join(HEADINGS[language]).format(turn=TURNS[language][turn], unit=unit)
    return KnownFile("\n".join([names, *rows]) + "\n", true, spacing, step, noise)


def three_arc(angles, base=15e-3, flank=60e-3, nose=4e-3, rise=8e-3):
    """Polar radius of base circle, flank and nose arcs (m) at angles from the nose."""
    far, beyond = base + rise - nose, flank - base
    opening = np.arccos(((flank - nose) ** 2 - far**2 - beyond**2) / (2 * far * beyond))
    away = np.abs(np.mod(angles + np.pi, 2 * np.pi) - np.pi)

    def arc(distance, radius, off):
        return distance * np.cos(off) + np.sqrt(
            np.maximum(radius**2 - (distance * np.sin(off)) ** 2, 0.0)
        )

    # the flank's centre lies beyond the cam's, opposite to where the flank begins
    centre = -beyond * np.array([np.cos(opening), np.sin(opening)])
    towards = (np.array([far, 0.0]) - centre) / (flank - nose)
    touch = centre + flank * towards
    meets = np.arctan2(touch[1], touch[0])
    return np.select(
        [away < meets, away < opening],
        [arc(far, nose, away), arc(-beyond, flank, away - opening)],
        base,
    )


def polar_table(angles, radii) -> bytes:
    """A contour (rad, m) as a file of degrees and millimetres."""
    rows = [
        f"{angle:g},{1e3 * radius:.5f}"
        for angle, radius in zip(np.degrees(angles), radii, strict=True)
    ]
    return "\n".join(["angle (deg),radius (mm)", *rows]).encode()
