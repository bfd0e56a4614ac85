"""Frames of a film, one after the other: a video, a folder of pictures, or an array; nothing is
in memory but the current frame.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.arrays import Ints
from valvetrain.errors import InputError
from valvetrain.measured.tables import read_content
from valvetrain.parameters.bounded_file import file_head

Picture = NDArray[Any]
#: Larger pictures are no frames of a high-speed film; longer films are cut first.
MAX_PIXELS, MAX_FRAMES, MAX_PICTURE_BYTES = 16_000_000, 500_000, 200_000_000
#: Names of pictures that a folder of frames holds.
PICTURES = (".png", ".tif", ".tiff", ".jpg", ".jpeg", ".bmp")
#: Slower films play at the rate of a screen, which is not that of the camera.
SLOWEST_RATE = 200.0
#: First bytes of containers of video (from the fifth on for those of the MP4 family).
_MARKS = (
    b"RIFF",
    b"\x1aE\xdf\xa3",
    b"\0\0\1\xba",
    b"\0\0\1\xb3",
    b"OggS",
    b"FLV\1",
    b"0&\xb2u\x8ef\xcf\x11",
    b"YUV4MPEG2",
)
_ATOMS = (b"ftyp", b"moov", b"mdat", b"wide", b"free", b"skip")
#: What OpenCV reads when it is loaded: its decoders are silent, and unpack no picture beyond the
#: bound, whatever its header claims.
_SETTINGS = {
    "OPENCV_FFMPEG_LOGLEVEL": "-8", "OPENCV_LOG_LEVEL": "OFF", "OPENCV_IO_MAX_IMAGE_PIXELS": str(MAX_PIXELS),
    "OPENCV_FFMPEG_CAPTURE_OPTIONS": f"max_pixels;{MAX_PIXELS}",
}  # fmt: skip


def opencv() -> Any:
    """The module ``cv2``, loaded on first use. Raises :class:`InputError` naming the extra where it
    is missing.
    """
    for name, value in _SETTINGS.items():
        os.environ.setdefault(name, value)
    try:
        import cv2
    except ImportError as error:
        raise InputError(
            "a film is read with OpenCV; install the extra 'film' (pip install 'valvetrain[film]')"
        ) from error
    return cv2


@dataclass(eq=False)
class Film:
    """A film that can be run through as often as needed.

    ``read``: yields every picture and adds time stamps (s, of the file) to the list that it gets. ``rate``: frames a
    second that the file itself gives, 0 where it does not. ``claimed``: frames it should hold, 0 unknown.
    ``clock``: after a run, the time stamp of each frame; ``numbers``: its number, where names of files count.
    """

    name: str
    rows: int
    columns: int
    read: Callable[[list[float]], Iterator[Picture]]
    rate: float = 0.0
    claimed: int = 0
    clock: list[float] = field(default_factory=list)
    numbers: Ints | None = None
    notes: tuple[str, ...] = ()

    def frames(self) -> Iterator[Picture]:
        """Every frame as a picture of grey levels (rows, columns). Raises :class:`InputError` for a
        damaged one or one of another size.
        """
        self.clock = []
        for number, picture in enumerate(self.read(self.clock)):
            if picture.shape != (self.rows, self.columns):
                raise InputError(
                    f"frame {number} of '{self.name}' has {picture.shape[1]} x {picture.shape[0]} pixels, those before {self.columns} x "
                    f"{self.rows}; give one film of one scene"
                )
            yield picture


def open_film(film: str | os.PathLike[str] | Picture) -> Film:
    """A film from a video, a folder of pictures or an array (frames, rows, columns). Raises
    :class:`InputError` for anything else.
    """
    if isinstance(film, np.ndarray):
        whole = film.ndim == 3 and all(film.shape) and film.dtype.kind in "uif"
        if not whole or film[0].size > MAX_PIXELS:
            shape = " x ".join(map(str, film.shape))
            raise InputError(
                f"an array of shape {shape} is no film; give grey levels of shape (frames, rows, columns)"
            )
        return Film(
            "array", film.shape[1], film.shape[2], lambda clock: iter(film), claimed=len(film)
        )
    path = Path(film)
    return _folder(path) if path.is_dir() else _video(path)


def _video(path: Path) -> Film:
    """A video whose first bytes are those of a container: a text that names other files or
    addresses is never followed.
    """
    name, head, _ = file_head(path, "film")
    if not (head.startswith(_MARKS) or head[4:8] in _ATOMS):
        raise InputError(
            f"'{name}' is no video that can be read; export the film as AVI, MP4 or MKV, or give the folder of all frames as PNG pictures"
        )
    cv2, file = opencv(), str(path.resolve())
    video = cv2.VideoCapture(file, cv2.CAP_FFMPEG)
    columns, rows, rate, claimed = (
        float(video.get(key)) if video.isOpened() else 0.0
        for key in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT, cv2.CAP_PROP_FPS, cv2.CAP_PROP_FRAME_COUNT)
    )  # fmt: skip
    if rows * columns > MAX_PIXELS:
        raise InputError(
            f"'{name}' claims frames of {columns:g} x {rows:g} pixels, more than {MAX_PIXELS / 1e6:g} million; cut the picture"
        )
    first = _next(video, name)
    if first is None:
        raise InputError(
            f"no frame of '{name}' can be read; it is cut short, damaged or of a kind that OpenCV does not read: export it as AVI or as a "
            "folder of PNG pictures"
        )

    def read(clock: list[float]) -> Iterator[Picture]:
        video = cv2.VideoCapture(file, cv2.CAP_FFMPEG)
        while len(clock) < MAX_FRAMES and (frame := _next(video, name)) is not None:
            clock.append(float(video.get(cv2.CAP_PROP_POS_MSEC)) * 1e-3)
            coloured = frame.ndim == 3 and frame.shape[2] == 3
            yield (
                cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
                if coloured
                else frame.reshape(frame.shape[:2])
            )

    rate = rate if 0 < rate < 1e8 else 0.0
    count = int(claimed) if 0 < claimed < 1e9 else 0
    if (
        head[24:28] == b"avih"
    ):  # of a cut AVI the decoder counts what is left, its head what there was
        count = max(count, int.from_bytes(head[48:52], "little"))
    return Film(name, first.shape[0], first.shape[1], read, rate, count)


def _next(video: Any, name: str) -> Picture | None:
    """The next frame of the film; None at its end. Raises :class:`InputError` where the decoder
    fails: a shorter film would give other numbers.
    """
    try:
        good, frame = video.read()
    except Exception as error:  # cv2.error: what it cannot decode it raises
        raise InputError(f"a frame of '{name}' is damaged; export it again") from error
    return frame if good else None


def _folder(path: Path) -> Film:
    """Pictures of a folder in the order of the numbers in their names."""

    def order(file: Path) -> list[Any]:
        parts = re.split(r"([0-9]+)", file.stem)  # every second one is a number
        return [int(part) if place % 2 else part for place, part in enumerate(parts)]

    pictures = [file for file in path.iterdir() if file.suffix.lower() in PICTURES and file.is_file()]  # fmt: skip
    files = sorted(sorted(pictures), key=order)
    if not 1 <= len(files) <= MAX_FRAMES:
        raise InputError(
            f"folder '{path.name[:80]}' holds {len(files) or 'no'} pictures ({', '.join(PICTURES)}); give a video file or a folder of 1 to "
            f"{MAX_FRAMES} frames"
        )
    rows, columns = _picture(files[0]).shape
    counted = [re.findall(r"[0-9]{1,15}", file.stem) for file in files]
    numbers = np.array([int(found[-1]) if found else 0 for found in counted])
    steps = np.diff(numbers)
    step = max(1, int(np.median(steps))) if len(steps) else 1
    counts: Ints | None = (numbers - numbers[0]) // step
    notes: tuple[str, ...] = ()
    if (steps < 1).any() or (steps % step).any() or steps.sum() // step > 4 * len(files):
        counts = None
        notes = ("the names of the pictures do not count frames, so frames lost between them cannot be found",)  # fmt: skip
    return Film(path.name[:80], rows, columns, lambda clock: map(_picture, files), claimed=len(files), numbers=counts, notes=notes)  # fmt: skip


def _picture(path: Path) -> Picture:
    """A picture as grey levels. Raises :class:`InputError` for one that is too large, damaged or no
    picture.
    """
    cv2, content = opencv(), read_content(path, MAX_PICTURE_BYTES, "frame")
    flags = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_ANYDEPTH | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        picture = cv2.imdecode(np.frombuffer(content, np.uint8), flags)
    except cv2.error:
        picture = None
    if picture is None or picture.ndim != 2 or picture.size > MAX_PIXELS:
        raise InputError(
            f"frame '{path.name[:80]}' is no picture, damaged, or larger than {MAX_PIXELS / 1e6:g} million pixels; export the frames again"
        )
    decoded: Picture = picture
    return decoded
