"""Which kernels still have to be compiled, so that a first run can say why it takes longer."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

#: Kind of work -> a kernel that is compiled last in it, and the seconds that all of its kernels take on one core.
KERNELS: Mapping[str, tuple[str, str, float]] = {
    "statics": ("valvetrain.cosserat.energy_kernels", "bend_terms", 4.0),
    "transient": ("valvetrain.cosserat.time_stepping", "integrate_in_time", 12.0),
    "train": ("valvetrain.integrate.train_kernel", "advance_train", 16.0),
}  # fmt: skip


def seconds_to_compile(*kinds: str) -> float:
    """Seconds of compilation that lie ahead for ``kinds`` of :data:`KERNELS`; 0 when all is there."""
    return sum(seconds for module, name, seconds in map(KERNELS.__getitem__, kinds) if not _compiled(getattr(import_module(module), name)))


def _compiled(kernel: Any) -> bool:
    """Whether ``kernel`` is compiled in this process or has a valid entry in its cache; True where that cannot be told."""
    if getattr(kernel, "signatures", ()):
        return True
    try:
        # Numba keeps its index private; it checks version and age of the source, which a look at file names would not.
        return bool(kernel._cache._cache_file._load_index())
    except AttributeError:
        return True
    except Exception:  # damaged bytes raise whatever they happen to spell; they are compiled anew
        return False
