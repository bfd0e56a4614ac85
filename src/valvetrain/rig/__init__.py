"""``valvetrain rig``: recordings of a test rig as cycles over the cam angle, and runs as a gauge
records them.

``cycles.py`` has the steps from file to result (begin there), each in a file of its own: ``reader.py`` with the
formats, ``channels.py``, ``shaft.py``, ``cutting.py``, ``alignment.py``; ``gauge.py`` has the gauge.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from valvetrain.lazy import lazy_names

#: Public name -> module of this package.
_HOMES = {
    "rig_cycles": "cycles",
    "RigAnswers": "channels",
    "RigResult": "result",
    "sensor_response": "gauge",
}

__all__ = ["rig_cycles", "RigAnswers", "RigResult", "sensor_response"]

if TYPE_CHECKING:
    from valvetrain.rig.channels import RigAnswers as RigAnswers
    from valvetrain.rig.cycles import rig_cycles as rig_cycles
    from valvetrain.rig.gauge import sensor_response as sensor_response
    from valvetrain.rig.result import RigResult as RigResult
else:
    __getattr__ = lazy_names(__name__, _HOMES)
