"""Recordings of a test rig as cycles over the cam angle, and runs as a gauge would record them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvetrain.lazy import lazy_names

#: Public name -> module of this package.
_HOMES = {
    "rig_cycles": "cycles",
    "RigAnswers": "channels",
    "RigResult": "result",
    "seen_by_sensor": "gauge",
}

__all__ = ["rig_cycles", "RigAnswers", "RigResult", "seen_by_sensor"]

if TYPE_CHECKING:
    from valvetrain.rig.channels import RigAnswers as RigAnswers
    from valvetrain.rig.cycles import rig_cycles as rig_cycles
    from valvetrain.rig.gauge import seen_by_sensor as seen_by_sensor
    from valvetrain.rig.result import RigResult as RigResult
else:
    __getattr__ = lazy_names(__name__, _HOMES)
