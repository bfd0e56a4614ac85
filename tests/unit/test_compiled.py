"""Kernels kept on disk: never older than what they are made of, mended where damaged, left out
where they cannot be kept.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys

import numba
import pytest

from valvetrain import compiled
from valvetrain.compiled import KernelCache, kernel_sources, sources_digest

SOURCE = """
from valvetrain.compiled import njit


@njit(cache=True)
def doubled(value):
    return 2.0 * value
"""


@pytest.fixture
def load(tmp_path):
    """Loads the module of one kernel as a new process would; its cache lies beside it."""
    path = tmp_path / "own_kernel.py"
    path.write_text(SOURCE, encoding="utf-8")

    def loaded():
        compiled._tell_once.cache_clear()
        spec = importlib.util.spec_from_file_location("own_kernel", path)
        module = importlib.util.module_from_spec(spec)
        sys.modules["own_kernel"] = module
        spec.loader.exec_module(module)
        return module.doubled

    yield loaded
    sys.modules.pop("own_kernel", None)


def kept(tmp_path, ending):
    return sorted(tmp_path.rglob(f"*.{ending}"))


def test_a_kernel_is_kept_and_found_again(load, tmp_path):
    assert load()(1.5) == 3.0 and len(kept(tmp_path, "nbc")) == 1
    again = load()
    assert again(1.5) == 3.0 and sum(again.stats.cache_hits.values()) == 1


def test_a_kernel_is_compiled_anew_when_any_source_of_kernels_changes(load, monkeypatch):
    load()(1.5)
    monkeypatch.setattr(compiled, "sources_digest", lambda package: "another")
    changed = load()
    assert (
        changed(1.5) == 3.0
        and not changed.stats.cache_hits
        and sum(changed.stats.cache_misses.values()) == 1
    )


def test_the_digest_follows_kernels_and_what_they_import(tmp_path):
    package = tmp_path / "valvetrain"
    shutil.copytree(
        compiled.PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__", "library", "report")
    )
    first = sources_digest(package)
    assert {"cosserat/layout.py", "cosserat/step_kernels.py", "compiled.py"} <= set(
        kernel_sources(package)
    )
    for name, text in (
        ("cosserat/layout.py", "\n#: One more.\nONE_MORE = 1\n"),
        ("contact/kernels.py", "\n"),
    ):
        with (package / name).open("a", encoding="utf-8") as file:
            file.write(text)
        sources_digest.cache_clear()
        changed = sources_digest(package)
        assert changed != first
        first = changed
    with (package / "cli" / "main.py").open("a", encoding="utf-8") as file:
        file.write("\n")
    sources_digest.cache_clear()
    assert sources_digest(package) == first


@pytest.mark.parametrize("ending", ["nbi", "nbc"])
@pytest.mark.parametrize("damage", ["empty", "half", "words", "short", "bit", "longer"])
def test_damaged_kernels_are_told_and_compiled_anew(load, tmp_path, capsys, ending, damage):
    load()(1.5)
    (file,) = kept(tmp_path, ending)
    whole = file.read_bytes()
    middle = len(whole) // 2
    file.write_bytes(
        {
            "empty": b"",
            "half": whole[:middle],
            "words": b"not a kernel at all",
            "short": whole[:-1],
            "longer": whole + b"0",
            "bit": whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :],
        }[damage]
    )
    assert load()(1.5) == 3.0
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "are damaged" in said and "compiled again" in said
    mended = load()
    assert (
        mended(1.5) == 3.0
        and sum(mended.stats.cache_hits.values()) == 1
        and not capsys.readouterr().err
    )


def test_a_full_disk_costs_the_cache_and_no_run(load, monkeypatch, capsys):
    def full(self, name, data):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("numba.core.caching.IndexDataCacheFile._save_data", full)
    assert load()(1.5) == 3.0
    assert "No space left on device" in capsys.readouterr().err


def test_without_a_folder_of_its_own_a_kernel_goes_to_a_private_one(load, monkeypatch, tmp_path):
    """A read-only installation without a home: numba finds no place and says so by RuntimeError."""
    usual, tried = KernelCache.__init__, []

    def no_place(self, function):
        tried.append(numba.config.CACHE_DIR)
        if not numba.config.CACHE_DIR:
            raise RuntimeError("cannot cache function: no locator available")
        usual(self, function)

    monkeypatch.setattr(KernelCache, "__init__", no_place)
    monkeypatch.setattr(compiled.tempfile, "gettempdir", lambda: str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    assert load()(1.5) == 3.0 and len(kept(tmp_path / "temporary", "nbc")) == 1
    assert tried[0] == "" and not numba.config.CACHE_DIR
    (folder,) = (tmp_path / "temporary").iterdir()
    assert folder.stat().st_mode & 0o077 == 0


def test_a_folder_that_others_can_write_is_not_trusted(load, monkeypatch, tmp_path, capsys):
    def no_place(self, function):
        raise RuntimeError("cannot cache function: no locator available")

    monkeypatch.setattr(KernelCache, "__init__", no_place)
    monkeypatch.setattr(compiled.tempfile, "gettempdir", lambda: str(tmp_path))
    folder = tmp_path / f"valvetrain-kernels-{compiled.os.getuid()}"
    folder.mkdir()
    folder.chmod(0o777)
    assert load()(1.5) == 3.0
    said = capsys.readouterr().err
    assert (
        "belongs to others" in said and "compiles them again" in said and not kept(tmp_path, "nbc")
    )


def test_stored_numbers_are_of_one_rounding():
    """Contract: where another processor's linear algebra rounds a fit otherwise, its stored numbers have
    another key, and the same one where it rounds alike.
    """
    program = (
        "import numpy as np; from valvetrain.compiled import program_digest; "
        "sample = np.sin(np.arange(37.0 * 23.0)).reshape(37, 23); "
        "print(program_digest(), np.linalg.lstsq(sample, sample[:, 0] ** 2)[0].tobytes().hex())"
    )
    found = [
        subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, **more},
            capture_output=True,
            text=True,
            check=True,
        ).stdout.split()
        for more in ({}, {}, {"OPENBLAS_CORETYPE": "Prescott"})
    ]
    (here, bits), repeated, (other, other_bits) = found
    assert repeated == [here, bits]
    assert (other == here) == (other_bits == bits)
