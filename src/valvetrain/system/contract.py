"""What every system answers: springs between a seat and a retainer, and what moves the retainer."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from valvetrain.springs.contract import SpringModel

#: Words of the systems, as results name them.
PRESCRIBED, TRAIN = "prescribed-spring", "train"


@runtime_checkable
class System(Protocol):
    """One thing that can be integrated in time; frozen, its state travels apart. Integrators say
    which systems they serve.
    """

    @property
    def name(self) -> str: ...

    @property
    def kind(self) -> str:
        """``prescribed-spring`` or ``train``."""
        ...

    @property
    def springs(self) -> tuple[SpringModel, ...]:
        """Spring models in the slot, outer first."""
        ...

    @property
    def spring_names(self) -> tuple[str, ...]:
        """``("spring",)``, or ``("outer", "inner")`` of a nested pair; they come before the
        channels of a pair.
        """
        ...
