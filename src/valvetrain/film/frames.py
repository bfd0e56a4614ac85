"""Frames of a film, one after the other: a video, a folder of pictures, or an array; nothing is
in memory but the current frame.
"""

from __future__ import annotations

import os
import re
import stat
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from valvetrain.errors import InputError


def picture_size(content: bytes) -> tuple[int, int] | None:
    """Rows and columns that a PNG, JPEG, TIFF or BMP claims to have; None for anything else."""
    readers = (
        (b"\x89PNG\r\n\x1a\n", _png),
        (b"\xff\xd8", _jpeg),
        (b"II*\0", _tiff),
        (b"MM\0*", _tiff),
        (b"BM", _bmp),
    )
    for mark, read in readers:
        if content.startswith(mark):
            try:
                return read(content)
            except (struct.error, IndexError):
                return None
    return None


def _png(content: bytes) -> tuple[int, int]:
    columns, rows = struct.unpack(">II", content[16:24])
    return rows, columns


def _bmp(content: bytes) -> tuple[int, int]:
    columns, rows = struct.unpack("<ii", content[18:26])
    return abs(rows), abs(columns)


def _jpeg(content: bytes) -> tuple[int, int] | None:
    """The first frame header among the segments."""
    place = 2
    while place + 9 < len(content):
        if content[place] != 0xFF:
            return None
        kind = content[place + 1]
        if kind == 0xFF:
            place += 1
            continue
        if 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):
            rows, columns = struct.unpack(">HH", content[place + 5 : place + 9])
            return rows, columns
        place += 2 + int(struct.unpack(">H", content[place + 2 : place + 4])[0])
    return None


def _tiff(content: bytes) -> tuple[int, int] | None:
    """Width and length in the first directory."""
    order = "<" if content[:2] == b"II" else ">"
    (place,) = struct.unpack(order + "I", content[4:8])
    (count,) = struct.unpack(order + "H", content[place : place + 2])
    found: dict[int, int] = {}
    for start in range(place + 2, place + 2 + 12 * min(count, 200), 12):
        tag, kind = struct.unpack(order + "HH", content[start : start + 4])
        form = {3: "H", 4: "I"}.get(kind)
        if tag in (256, 257) and form:
            (found[tag],) = struct.unpack(
                order + form, content[start + 8 : start + 8 + (2 if form == "H" else 4)]
            )
    return (found[257], found[256]) if len(found) == 2 else None


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


def opencv() -> Any:
    """The module ``cv2``, loaded on first use. Raises :class:`InputError` naming the extra where it
    is missing.
    """
    for name, level in (("OPENCV_FFMPEG_LOGLEVEL", "-8"), ("OPENCV_LOG_LEVEL", "OFF")):
        os.environ.setdefault(name, level)  # decoders would write their own lines on standard error
    try:
        import cv2
    except ImportError as error:
        sentence = (
            "a film is read with OpenCV; install the extra 'film' (pip install 'valvetrain[film]')"
        )
        raise InputError(sentence) from error
    if hasattr(
        cv2.utils, "logging"
    ):  # not in every version; the variable above says the same to an OpenCV that is loaded here
        cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    return cv2


@dataclass(eq=False)
class Film:
    """A film that can be run through as often as needed.

    ``rate``: frames a second that the file itself gives, 0 where it does not. ``claimed``: frames
    it should hold, 0 unknown.
    ``clock``: after a run, the time stamp (s, of the file) of each frame; ``numbers``: its number,
    where names of files count.
    """

    name: str
    rows: int
    columns: int
    rate: float = 0.0
    claimed: int = 0
    clock: list[float] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    notes: tuple[str, ...] = ()

    def frames(self) -> Iterator[Picture]:
        """Every frame as a picture of grey levels (rows, columns)."""
        raise NotImplementedError


@dataclass(eq=False)
class ArrayFilm(Film):
    """Frames of an array (frames, rows, columns)."""

    array: Picture = field(default_factory=lambda: np.zeros((0, 0, 0)))

    def frames(self) -> Iterator[Picture]:
        """Every picture of the array."""
        yield from self.array


@dataclass(eq=False)
class FolderFilm(Film):
    """Pictures of a folder in the order of the numbers in their names."""

    files: tuple[Path, ...] = ()

    def frames(self) -> Iterator[Picture]:
        """Every picture of the folder. Raises :class:`InputError` for a damaged one or one of
        another size.
        """
        self.clock = []
        for path in self.files:
            picture = _picture(path)
            if picture.shape != (self.rows, self.columns):
                raise InputError(
                    f"'{path.name[:80]}' has {picture.shape[1]} x {picture.shape[0]} pixels, those before {self.columns} x {self.rows}; "
                    "put one film in a folder"
                )
            yield picture


@dataclass(eq=False)
class VideoFilm(Film):
    """A video file that OpenCV reads."""

    path: Path = field(default_factory=Path)

    def frames(self) -> Iterator[Picture]:
        """Every frame that can be decoded, as grey levels."""
        cv2 = opencv()
        self.clock = []
        with _capture(self.path) as video:
            while len(self.clock) < MAX_FRAMES:
                good, frame = _next(video, self.name)
                if not good or frame is None:
                    return
                if frame.shape[:2] != (self.rows, self.columns):
                    raise InputError(
                        f"frames of '{self.name}' change their size; cut the film to one scene"
                    )
                self.clock.append(float(video.get(cv2.CAP_PROP_POS_MSEC)) * 1e-3)
                yield (
                    cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
                    if frame.ndim == 3 and frame.shape[2] == 3
                    else frame.reshape(frame.shape[:2])
                )


def open_film(film: str | os.PathLike[str] | Picture) -> Film:
    """A film from a video, a folder of pictures or an array (frames, rows, columns). Raises
    :class:`InputError` for anything else.
    """
    if isinstance(film, np.ndarray):
        if (
            film.ndim != 3
            or not all(film.shape)
            or film.dtype.kind not in "uif"
            or film[0].size > MAX_PIXELS
        ):
            shape = " x ".join(map(str, film.shape))
            raise InputError(
                f"an array of shape {shape} is no film; give grey levels of shape (frames, rows, columns)"
            )
        return ArrayFilm("array", film.shape[1], film.shape[2], claimed=len(film), array=film)
    path = Path(film)
    shown = path.name[:80] or str(path)[:80]
    try:
        kind = path.stat().st_mode
        if stat.S_ISDIR(kind):
            return _folder(path, shown)
        if not stat.S_ISREG(kind):
            raise InputError(
                f"'{shown}' is no regular file; give a video file or a folder of pictures"
            )
        with path.open("rb") as file:
            begin = file.read(64)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", "") or "the name is no file name"
        raise InputError(
            f"film '{shown}' cannot be read: {reason.lower()}; check the name and the folder"
        ) from error
    return _video(path, shown, begin)


def _video(path: Path, shown: str, begin: bytes) -> Film:
    """A video whose first bytes are those of a container: a text that names other files or
    addresses is never followed.
    """
    if not begin:
        raise InputError(f"'{shown}' is empty; export the film again")
    if picture_size(begin):
        raise InputError(
            f"'{shown}' is a picture, one frame; give a video file or the folder of all frames"
        )
    if not (begin.startswith(_MARKS) or begin[4:8] in _ATOMS):
        raise InputError(
            f"'{shown}' is no video that can be read; export the film as AVI, MP4 or MKV, or as a folder of PNG pictures"
        )
    cv2 = opencv()
    with _capture(path) as video:
        if not video.isOpened():
            raise InputError(
                f"'{shown}' is damaged or of a kind that OpenCV does not read; export it as AVI or as a folder of PNG pictures"
            )
        columns, rows = (
            int(video.get(one)) for one in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT)
        )
        if rows * columns > MAX_PIXELS:
            raise InputError(
                f"'{shown}' claims frames of {columns} x {rows} pixels, more than {MAX_PIXELS / 1e6:g} million; cut the picture"
            )
        good, frame = _next(video, shown)
        if not good or frame is None:
            raise InputError(
                f"no frame of '{shown}' can be read; it is cut short or damaged, so export it again"
            )
        rows, columns = frame.shape[:2]
        rate, claimed = (
            float(video.get(cv2.CAP_PROP_FPS)),
            float(video.get(cv2.CAP_PROP_FRAME_COUNT)),
        )
    rate = rate if np.isfinite(rate) and 0 < rate < 1e8 else 0.0
    count = int(claimed) if np.isfinite(claimed) and 0 < claimed < 1e9 else 0
    if (
        begin[24:28] == b"avih"
    ):  # of a cut AVI the decoder counts what is left, its head what there was
        count = max(count, int.from_bytes(begin[48:52], "little"))
    return VideoFilm(shown, rows, columns, rate, count, path=path)


@contextmanager
def _capture(path: Path) -> Iterator[Any]:
    """The open video; its decoder may not unpack frames beyond the bound, whatever their headers
    claim.
    """
    cv2, name = opencv(), "OPENCV_FFMPEG_CAPTURE_OPTIONS"
    before = os.environ.get(name)
    os.environ[name] = f"max_pixels;{MAX_PIXELS}"
    try:
        video = cv2.VideoCapture(str(path.resolve()), cv2.CAP_FFMPEG)
    finally:
        if before is None:
            del os.environ[name]
        else:
            os.environ[name] = before
    try:
        yield video
    finally:
        video.release()


def _next(video: Any, shown: str) -> tuple[bool, Picture | None]:
    """The next frame of the film ``shown``; False at its end. Raises :class:`InputError` where the decoder
    fails: a shorter film would give other numbers.
    """
    try:
        good, frame = video.read()
    except Exception as error:  # cv2.error: what it cannot decode it raises
        raise InputError(f"a frame of '{shown}' is damaged; export it again") from error
    return bool(good), frame


def _folder(path: Path, shown: str) -> Film:
    files = sorted(
        (one for one in path.iterdir() if one.suffix.lower() in PICTURES and one.is_file()),
        key=lambda path: (
            tuple(
                (int(part), "") if part.isdigit() else (-1, part)
                for part in re.split(r"([0-9]+)", path.stem)
                if part
            ),
            path.name,
        ),
    )
    if not files:
        raise InputError(
            f"folder '{shown}' holds no pictures ({', '.join(PICTURES)}); give the folder of the frames or a video file"
        )
    if len(files) > MAX_FRAMES:
        raise InputError(
            f"folder '{shown}' holds {len(files)} pictures, more than {MAX_FRAMES}; split the film"
        )
    rows, columns = _picture(files[0]).shape
    numbers, notes = _numbers(files)
    return FolderFilm(
        shown, rows, columns, claimed=len(files), numbers=numbers, notes=notes, files=tuple(files)
    )


def _numbers(files: list[Path]) -> tuple[list[int], tuple[str, ...]]:
    """Numbers of the frames as their names count them; empty, with a sentence, where they do not."""
    found = [re.findall(r"[0-9]{1,15}", path.stem) for path in files]
    if not all(found):
        return [], (
            "the names of the pictures hold no numbers, so frames lost between them cannot be found",
        )
    values = [int(one[-1]) for one in found]
    steps = [two - one for one, two in pairwise(values)]
    step = int(np.median(steps)) if steps else 1
    if (
        not steps
        or min(steps) < 1
        or step < 1
        or any(one % step for one in steps)
        or (values[-1] - values[0]) // step > 4 * len(values)
    ):
        sentence = "the numbers in the names of the pictures do not count frames, so frames lost between them cannot be found"
        return [], (sentence,) if steps else ()
    return [(one - values[0]) // step for one in values], ()


def _picture(path: Path) -> Picture:
    """A picture as grey levels. Raises :class:`InputError` for one that is too large, damaged or no
    picture.
    """
    cv2, shown = opencv(), path.name[:80]
    try:
        with path.open("rb") as file:
            content = file.read(MAX_PICTURE_BYTES + 1)
    except OSError as error:
        raise InputError(
            f"frame '{shown}' cannot be read: {str(error.strerror).lower()}"
        ) from error
    size = picture_size(content)
    if size is None or len(content) > MAX_PICTURE_BYTES:
        raise InputError(
            f"frame '{shown}' is no PNG, TIFF, JPEG or BMP picture or is damaged; export the frames again"
        )
    if not 0 < size[0] * size[1] <= MAX_PIXELS:
        raise InputError(
            f"frame '{shown}' claims {size[1]} x {size[0]} pixels, more than {MAX_PIXELS / 1e6:g} million; cut the picture"
        )
    flags = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_ANYDEPTH | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        picture = cv2.imdecode(np.frombuffer(content, np.uint8), flags)
    except Exception as error:  # cv2.error, which is no class of Python's own
        raise InputError(f"frame '{shown}' is damaged; export the frames again") from error
    if picture is None or picture.ndim != 2:
        raise InputError(f"frame '{shown}' is damaged; export the frames again")
    found: Picture = picture
    return found
