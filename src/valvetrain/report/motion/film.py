"""A short film of a moving picture for slides: GIF by Pillow, MP4 by OpenCV; no browser is needed."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from valvetrain.errors import InputError, RunFailedError
from valvetrain.report import theme
from valvetrain.report.motion.parts import Array, Variant
from valvetrain.report.motion.project import colouring_of, flat_shapes, shades
from valvetrain.report.motion.springs import COLOURS
from valvetrain.report.text import number, rpm
from valvetrain.solution.atomic import write_bytes

if TYPE_CHECKING:
    from PIL.Image import Image
    from PIL.ImageDraw import ImageDraw

#: Pictures per second, and bounds: seconds, width (px), bytes of the file.
RATE, MAX_LENGTH, WIDEST, NARROWEST, MAX_BYTES = 25, 20.0, 1920, 320, 25_000_000
ENDINGS = (".gif", ".mp4")
#: Colours of a GIF, and how much finer the picture is drawn than shown.
PALETTE, FINER = 255, 2
_PILLOW = (
    "pictures are drawn by Pillow, which is not installed; install it with: pip install pillow"
)
_OPENCV = "an MP4 needs OpenCV; install it with: pip install 'valvetrain[film]', or write a GIF"


@dataclass(frozen=True, slots=True)
class FilmRequest:
    """A film as requested: ``duration`` (s) of one cam revolution, ``picture_width`` (px; height
    16:9), ``colour``: key of the colouring.
    """

    duration: float = 4.0
    picture_width: int = 800
    colour: str = ""

    def check(self) -> None:
        """Raise :class:`InputError` for values beyond the bounds and for a colour that no wire
        has.
        """
        if self.colour and self.colour not in COLOURS:
            raise InputError(
                f"there is no colour '{self.colour[:40]}'; use {', '.join(COLOURS)}", "--colour"
            )
        if not 1 <= self.duration <= MAX_LENGTH:
            raise InputError(
                f"a film of {self.duration:g} s is too short or too long; choose 1 to {MAX_LENGTH:g} s",
                "--duration",
            )
        if not NARROWEST <= self.picture_width <= WIDEST:
            raise InputError(
                f"a film {self.picture_width} px wide is too small or too large; choose {NARROWEST} to {WIDEST}",
                "--width",
            )


@dataclass(frozen=True, slots=True)
class Film:
    """A film that was written: its file, pictures, bytes, and how many times slower than the engine
    it runs.
    """

    path: Path
    pictures: int
    size: int
    slowness: float


def check_ending(path: Path) -> None:
    """Raise :class:`InputError` for a file that is neither GIF nor MP4, or whose writer is not
    installed.
    """
    if path.suffix.lower() not in ENDINGS:
        raise InputError(f"a film ends in .gif or .mp4; '{path.name[:60]}' does not", "--output")
    if find_spec("PIL") is None:
        raise InputError(_PILLOW, "--output")
    if path.suffix.lower() == ".mp4":
        _opencv()


def write_film(variant: Variant, path: Path, request: FilmRequest = FilmRequest()) -> Film:
    """Write one cam revolution of a run as a film.

    Parameters
    ----------
    variant : the run, as :func:`valvetrain.report.motion.scene.moving_picture` gives it
    path : a file that ends in .gif or .mp4, written whole or not at all
    request : seconds, width and colouring

    Returns
    -------
    Film

    Raises
    ------
    InputError : another ending, a missing package, a colouring that the run does not have, bounds;
        RunFailedError for a film that came out
        larger than 25 MB

    Examples
    --------
    >>> import valvetrain as vt
    >>> from valvetrain.report.motion.scene import moving_picture
    >>> run = moving_picture(vt.simulate("job-t", "2000 rpm", spring_models=["multi-mass"])).variants[0]
    >>> write_film(run, Path("spring.gif"), FilmRequest(duration=1.0, picture_width=320)).pictures
    25
    """
    request.check()
    check_ending(path)
    known = sorted({one.key for spring in variant.springs for one in spring.colourings})
    if request.colour and request.colour not in known:
        sentence = f"it has {', '.join(known)}" if known else "its springs show no colours"
        raise InputError(f"this run has no colour '{request.colour[:40]}'; {sentence}", "--colour")
    count = round(request.duration * RATE)
    frames = film_frames(variant, count)
    pictures = (picture for picture in _pictures(variant, frames, request))
    content = _gif(pictures) if path.suffix.lower() == ".gif" else _mp4(pictures)
    if len(content) > MAX_BYTES:
        raise RunFailedError(
            f"the film takes {len(content) / 1e6:.0f} MB, more than {MAX_BYTES / 1e6:.0f} MB; make it shorter or narrower"
        )
    write_bytes(path, content)
    turn = 4 * np.pi / variant.engine_speed
    return Film(path, count, len(content), request.duration / turn)


def film_frames(variant: Variant, count: int) -> list[int]:
    """Frames next to ``count`` even steps of the cam; that of the largest force in place of the
    step next to it.
    """
    angles = np.arange(count) * 2 * np.pi / count
    found = [int(np.argmin(np.abs(variant.cam_angle - angle))) for angle in angles]
    if variant.forces:
        force = variant.forces[0]
        peak = float(force.cam_angle[int(np.argmax(force.values))])
        found[int(np.argmin(np.abs(angles - peak)))] = int(
            np.argmin(np.abs(variant.cam_angle - peak))
        )
    return found


def _pictures(variant: Variant, frames: list[int], request: FilmRequest) -> Iterator[Image]:
    from PIL import Image, ImageDraw

    width, height = request.picture_width // 2 * 2, request.picture_width * 9 // 16 // 2 * 2
    size = (FINER * width, FINER * height)
    place = _Place(variant, size)
    base = Image.new("RGB", size, theme.PAPER)
    _still_parts(ImageDraw.Draw(base), variant, place, request)
    for frame in frames:
        picture = base.copy()
        draw = ImageDraw.Draw(picture)
        shapes = [one for one in flat_shapes(variant, frame, request.colour) if len(one.points) > 2]
        pixels, first = place.at(np.concatenate([one.points for one in shapes])), 0
        for one in shapes:
            draw.polygon(pixels[first : first + len(one.points)], fill=one.colour)
            first += len(one.points)
        _cursor(draw, variant, frame, place)
        yield picture.resize((width, height), Image.Resampling.LANCZOS)


class _Place:
    """Layout of the picture: the view on the left, the forces on the right, in pixels of the finer
    picture.
    """

    def __init__(self, variant: Variant, size: tuple[int, int]) -> None:
        from PIL import ImageFont

        self.width, self.height = size
        self.unit = self.height / 100
        self.font, self.small = (ImageFont.load_default(share * self.unit) for share in (3.9, 3.3))
        ends = [
            flat_shapes(variant, int(frame))
            for frame in np.linspace(0, len(variant.cam_angle) - 1, 13).astype(int)
        ]
        every = np.concatenate([one.points for shapes in ends for one in shapes])
        (left, low), (right, high) = every.min(axis=0), every.max(axis=0)
        self.box = (0.02 * self.width, 10 * self.unit, 0.5 * self.width, 84 * self.unit)
        x0, y0, x1, y1 = self.box
        self.scale = 0.98 * min((x1 - x0) / (right - left), (y1 - y0) / (high - low))
        self.middle = ((left + right) / 2, (low + high) / 2)
        self.plot = (0.59 * self.width, 14 * self.unit, 0.97 * self.width, 72 * self.unit)
        values = (
            np.concatenate([force.values for force in variant.forces])
            if variant.forces
            else np.array([0.0, 1.0])
        )
        self.low, self.high = min(0.0, float(values.min())), 1.05 * float(values.max()) or 1.0

    def at(self, points: Array) -> list[tuple[float, float]]:
        """Pixels of points (n, 2) in m."""
        x0, y0, x1, y1 = self.box
        across = (x0 + x1) / 2 + self.scale * (points[:, 0] - self.middle[0])
        down = (y0 + y1) / 2 - self.scale * (points[:, 1] - self.middle[1])
        return list(zip(across.tolist(), down.tolist(), strict=True))

    def in_plot(self, cam_angle: Array, force: Array) -> list[tuple[float, float]]:
        """Pixels of a curve over the cam angle (rad)."""
        x0, y0, x1, y1 = self.plot
        across = x0 + (x1 - x0) * np.asarray(cam_angle) / (2 * np.pi)
        down = y1 - (y1 - y0) * (np.asarray(force) - self.low) / (self.high - self.low)
        return list(zip(across.tolist(), down.tolist(), strict=True))


def _still_parts(draw: ImageDraw, variant: Variant, place: _Place, request: FilmRequest) -> None:
    """The static parts of the picture: title, curves with their axes, colour scale."""
    unit = place.unit
    draw.text((0.02 * place.width, 2 * unit), variant.title, fill=theme.INK, font=place.font)
    x0, y0, x1, y1 = place.plot
    for angle in range(0, 361, 90):
        x = x0 + (x1 - x0) * angle / 360
        draw.line((x, y0, x, y1), fill=theme.GRID, width=FINER)
        draw.text((x, y1 + unit), f"{angle}°", fill=theme.MUTED, font=place.small, anchor="ma")
    step = _nice(place.high - place.low)
    for level in np.arange(np.ceil(place.low / step) * step, place.high, step):
        ((_, y),) = place.in_plot(np.zeros(1), np.array([level]))
        draw.line((x0, y, x1, y), fill=theme.RULE if level == 0 else theme.GRID, width=FINER)
        draw.text((x0 - unit, y), f"{level:g}", fill=theme.MUTED, font=place.small, anchor="rm")
    draw.text(
        ((x0 + x1) / 2, y1 + 5.4 * unit),
        "cam angle",
        fill=theme.MUTED,
        font=place.small,
        anchor="ma",
    )
    draw.text((x0 - unit, y0 - 4.6 * unit), "N", fill=theme.MUTED, font=place.small, anchor="ra")
    left = x0
    for force in variant.forces:
        draw.line(
            place.in_plot(force.cam_angle, force.values),
            fill=force.colour,
            width=2 * FINER,
            joint="curve",
        )
        draw.text(
            (left, y0 - 5 * unit), force.label, fill=force.colour, font=place.small, anchor="la"
        )
        left += draw.textlength(force.label, font=place.small) + 2 * unit
    _scale(draw, variant, place, request.colour)
    slowness = request.duration * variant.engine_speed / (4 * np.pi)
    label = (
        f"{rpm(variant.engine_speed):.6g} rpm of the crank, 1/{number(slowness, 3)} of real time"
    )
    draw.text((x1, 96 * unit), label, fill=theme.MUTED, font=place.small, anchor="rs")


def _scale(draw: ImageDraw, variant: Variant, place: _Place, key: str) -> None:
    colouring = colouring_of(variant, key)
    if colouring is None:
        return
    x0, x1, y, unit = place.box[0], place.box[2], 87 * place.unit, place.unit
    tones = shades(colouring, np.linspace(colouring.low, colouring.high, 128))
    for part, tone in enumerate(tones):
        left, right = (x0 + (x1 - x0) * (part + side) / 128 for side in (0, 1))
        draw.rectangle((left, y, right, y + 2.4 * unit), fill=tuple(int(value) for value in tone))
    for x, anchor, label in (
        (x0, "la", f"{number(colouring.low, 3)}"),
        ((x0 + x1) / 2, "ma", f"{colouring.label} ({colouring.unit})"),
        (x1, "ra", f"{number(colouring.high, 3)}"),
    ):
        draw.text((x, y + 3.2 * unit), label, fill=theme.INK, font=place.small, anchor=anchor)


def _cursor(draw: ImageDraw, variant: Variant, frame: int, place: _Place) -> None:
    x0, y0, x1, y1 = place.plot
    angle = float(variant.cam_angle[frame])
    x = x0 + (x1 - x0) * angle / (2 * np.pi)
    draw.line((x, y0, x, y1), fill=theme.INK, width=FINER)
    for force in variant.forces:
        ((_, y),) = place.in_plot(
            np.zeros(1), np.array([np.interp(angle, force.cam_angle, force.values)])
        )
        size = 0.9 * place.unit
        draw.ellipse((x - size, y - size, x + size, y + size), fill=force.colour)
    label = (
        f"cam angle {np.degrees(angle):.1f}°   valve lift {1e3 * variant.valve_lift[frame]:.2f} mm"
    )
    draw.text((x0, y1 + 12 * place.unit), label, fill=theme.INK, font=place.font, anchor="la")


def _nice(span: float) -> float:
    raw = span / 5
    size = 10.0 ** np.floor(np.log10(raw))
    return float(next(one * size for one in (1, 2, 5, 10) if one * size >= raw))


def _gif(pictures: Iterator[Image]) -> bytes:
    """One palette for all pictures, taken from a quarter of them, so that nothing flickers."""
    from PIL import Image

    every = list(pictures)
    some = every[:: max(1, len(every) // 8)]
    sheet = Image.new("RGB", (some[0].width, some[0].height * len(some)))
    for place, one in enumerate(some):
        sheet.paste(one, (0, place * one.height))
    palette = sheet.quantize(PALETTE)
    flat = [one.quantize(palette=palette, dither=Image.Dither.NONE) for one in every]
    out = io.BytesIO()
    flat[0].save(
        out,
        "GIF",
        save_all=True,
        append_images=flat[1:],
        duration=1000 // RATE,
        loop=0,
        optimize=False,
    )
    return out.getvalue()


def _mp4(pictures: Iterator[Image]) -> bytes:
    cv2 = _opencv()
    with tempfile.TemporaryDirectory(prefix="valvetrain-film-") as folder:
        path, writer = Path(folder) / "film.mp4", None
        for picture in pictures:
            if writer is None:
                writer = cv2.VideoWriter(
                    str(path), cv2.VideoWriter_fourcc(*"mp4v"), RATE, picture.size
                )
                if not writer.isOpened():
                    raise InputError("this OpenCV writes no MP4; write a GIF instead", "--output")
            writer.write(np.asarray(picture)[:, :, ::-1].copy())
        if writer is not None:
            writer.release()
        return path.read_bytes()


def _opencv() -> Any:
    try:
        import cv2
    except ImportError as error:
        raise InputError(_OPENCV, "--output") from error
    return cv2
