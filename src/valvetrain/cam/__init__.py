"""Lift laws and cam profiles. Names load on first use."""

from __future__ import annotations

from typing import Any


def __getattr__(name: str) -> Any:
    if name == "build_lift_law":
        from valvetrain.cam.build import build_lift_law

        return build_lift_law
    if name in ("PeriodicPieces", "tabulate"):
        from valvetrain.cam import pieces

        return getattr(pieces, name)
    if name == "LiftLaw":
        from valvetrain.cam.contract import LiftLaw

        return LiftLaw
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
