"""Compiled kernels: numba's ``njit`` with a cache on disk that never serves old code, mends itself
and finds a place of its own.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import re
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numba
import numpy as np
from numba import njit as compile_kernel
from numba.core.caching import FunctionCache, IndexDataCacheFile

from valvetrain.session import announce_compilation

PACKAGE = Path(__file__).parent
_IMPORT = re.compile(
    rb"^\s*from valvetrain\.([\w.]+) import|^\s*import valvetrain\.([\w.]+)", re.MULTILINE
)


def njit(*given: Any, **options: Any) -> Any:
    """``numba.njit`` whose option ``cache`` stores the machine code by :class:`KernelCache`; to be
    used as a decorator, as numba's is.
    """
    cached = options.pop("cache", False)
    if given:
        return compile_kernel(*given, **options)

    def decorate(function: Callable[..., Any]) -> Any:
        kernel = compile_kernel(**options)(function)
        if cached:
            try:
                kernel._cache = _cache_of(kernel.py_func)
            except (AttributeError, OSError, RuntimeError, TypeError) as reason:
                _tell_once(
                    f"compiled kernels cannot be stored ({reason}); each run compiles them again"
                )
        return kernel

    return decorate


class CheckedFile(IndexDataCacheFile):
    """Numba's files of one kernel with a digest at their end: machine code with one wrong bit would
    be run, perhaps without an error.
    """

    def _dump(self, obj: Any) -> bytes:
        content: bytes = super()._dump(obj)  # type: ignore[no-untyped-call]
        return content + _digest(content)

    def _load_index(self) -> Any:
        with suppress(FileNotFoundError), open(self._index_path, "rb") as file:
            if pickle.load(file) == self._version:
                _checked(file.read())
        return super()._load_index()  # type: ignore[no-untyped-call]

    def _load_data(self, name: str) -> Any:
        return pickle.loads(_checked(Path(self._data_path(name)).read_bytes()))  # type: ignore[no-untyped-call]


def _digest(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=16).digest()


def _checked(content: bytes) -> bytes:
    """Content without the digest at its end. Raises :class:`ValueError` where the two do not fit."""
    if _digest(content[:-16]) != content[-16:]:
        raise ValueError("the digest differs")
    return content[:-16]


class KernelCache(FunctionCache):
    """Numba's cache of one kernel, valid for all sources that kernels are made of, not for the
    kernel's own file alone.

    A kernel holds the code of those it calls and the constants of other files, which numba does not
    look at. An entry that cannot be read is dropped and compiled again; one that cannot be written is
    left out.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        stamp = (self._impl.locator.get_source_stamp(), sources_digest(PACKAGE))
        self._cache_file = CheckedFile(
            self._cache_path, f"{self._impl.filename_base}.checked", stamp
        )  # type: ignore[no-untyped-call]

    @property
    def _place(self) -> Path:
        """One folder for all kernels of a package, so that one sentence speaks of all of them."""
        folder = Path(self._cache_path)
        return PACKAGE if PACKAGE in folder.parents else folder.parent

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Stored machine code for a signature, None where there is none that can be read and it is
        compiled next.
        """
        try:
            found = super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
            if found is None:
                announce_compilation(self._py_func.__name__)
            return found
        except Exception as reason:  # damaged bytes raise whatever they happen to spell
            _tell_once(
                f"compiled kernels in {self._place} are damaged ({type(reason).__name__}); they are compiled again"
            )
            try:
                self.flush()  # type: ignore[no-untyped-call]
            except OSError:
                self.disable()  # type: ignore[no-untyped-call]
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Store machine code for a signature, if the disk allows it."""
        try:
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]
        except OSError as reason:
            self.disable()  # type: ignore[no-untyped-call]
            _tell_once(
                f"compiled kernels cannot be stored in {self._place} ({reason.strerror or reason}); runs compile them again"
            )


def _cache_of(function: Callable[..., Any]) -> KernelCache:
    """Cache next to the source or in the user's own folder; where neither can be written, in a
    private one for temporary files.
    """
    try:
        return KernelCache(function)
    except RuntimeError:
        cache_folder = numba.config.CACHE_DIR  # type: ignore[attr-defined]
        if cache_folder:
            raise
        numba.config.CACHE_DIR = str(_private_folder())  # type: ignore[attr-defined]
        try:
            return KernelCache(function)
        finally:
            numba.config.CACHE_DIR = cache_folder  # type: ignore[attr-defined]


def _private_folder() -> Path:
    """Folder for temporary files that only this user can write: stored code is executed, so it must be this
    user's own.
    """
    owner = os.getuid() if hasattr(os, "getuid") else 0
    folder = Path(tempfile.gettempdir()) / f"valvetrain-kernels-{owner}"
    folder.mkdir(mode=0o700, exist_ok=True)
    facts = folder.lstat()
    if hasattr(os, "getuid") and (
        folder.is_symlink() or facts.st_uid != owner or facts.st_mode & 0o077
    ):
        raise OSError(f"{folder} belongs to others")
    return folder


@cache
def sources_digest(package: Path) -> str:
    """Digest of what kernels in ``package`` are made of."""
    digest = hashlib.blake2b(digest_size=16)
    for name, text in sorted(kernel_sources(package).items()):
        digest.update(name.encode() + b"\0" + text + b"\0")
    return digest.hexdigest()


@cache
def program_digest(*folders: str) -> str:
    """Digest of what numbers that are stored follow from: kernels, the files of ``folders`` (patterns
    within the package), and how the linear algebra of this processor rounds.
    """
    digest = hashlib.blake2b(sources_digest(PACKAGE).encode(), digest_size=16)
    for path in sorted({path for one in folders for path in PACKAGE.glob(one)}):
        digest.update(path.read_bytes())
    sample = np.sin(np.arange(37.0 * 23.0)).reshape(37, 23)
    for numbers in (np.linalg.lstsq(sample, sample[:, 0] ** 2)[0], sample.T @ sample):
        digest.update(numbers.tobytes())
    return digest.hexdigest() + np.__version__


def kernel_sources(package: Path) -> dict[str, bytes]:
    """File -> text of the files with kernels and of those that they import, by name from the folder
    ``package`` on.
    """
    texts = {
        path.relative_to(package).as_posix(): path.read_bytes() for path in package.rglob("*.py")
    }
    made_here = [name for name, text in texts.items() if b"@njit(" in text]
    modules = {
        (found[1] or found[2]).decode().replace(".", "/")
        for name in made_here
        for found in _IMPORT.finditer(texts[name])
    }
    named = {file for module in modules for file in (f"{module}.py", f"{module}/__init__.py")}
    return {name: texts[name] for name in texts.keys() & {*made_here, *named}}


@cache
def _tell_once(sentence: str) -> None:
    print(f"valvetrain: {sentence}", file=sys.stderr)
