"""Stamp of compiled kernels while faults are judged: that of the source without a fault.

The package stamps every kept kernel by the text of all sources of kernels, so that one seeded fault
would compile them all anew. The tool
deletes what a fault can reach (`mutants.copies.drop_kernels`) and puts it back afterwards; all
others are served as they are. The package
knows nothing of it: its module is changed as it is imported, in the tool's processes only.
"""

from __future__ import annotations

import importlib.util
import os
import sys
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

STAMP = "VALVETRAIN_MUTANTS_STAMP"
_MODULE = "valvetrain.compiled"


class HeldStamp:
    """Finder of the module of kernels, once: gives it the stamp that the environment names, for its
    own package.
    """

    def find_spec(
        self, name: str, path: Any = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """The usual module whose ``sources_digest`` answers with the held stamp."""
        if name != _MODULE:
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(name)
        if spec is not None and spec.loader is not None:
            loader, run = spec.loader, spec.loader.exec_module

            def exec_module(module: ModuleType) -> None:
                run(module)
                hold(module)

            loader.exec_module = exec_module  # type: ignore[method-assign]
        return spec


def hold(module: Any) -> None:
    """Gives the held stamp to the module; packages elsewhere (copies that tests make) keep their
    own.
    """
    usual, stamp = module.sources_digest, os.environ[STAMP]

    def sources_digest(package: Any) -> str:
        return stamp if package == module.PACKAGE else str(usual(package))

    sources_digest.cache_clear = usual.cache_clear  # type: ignore[attr-defined]
    module.sources_digest = sources_digest


def install() -> None:
    """For a process whose environment names a stamp."""
    sys.meta_path.insert(0, HeldStamp())
