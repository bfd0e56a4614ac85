"""case file -> parameters -> parts (cam, mechanism, contacts, springs) -> System -> integrate -> Solution -> analysis -> report

Dynamics of valve springs and valvetrains. The names below load their rooms on first use, so that
``import valvetrain`` itself costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

#: Public name -> module that holds it.
_HOMES = {
    "SpringDefinition": "parameters.spring",
    "EndCoil": "parameters.spring",
    "Material": "parameters.material",
    "Constant": "parameters.curves",
    "PiecewiseLinear": "parameters.curves",
    "Table": "parameters.curves",
    "FunctionCurve": "parameters.curves",
    "cylindrical": "parameters.constructors",
    "conical": "parameters.constructors",
    "barrel": "parameters.constructors",
    "hourglass": "parameters.constructors",
    "beehive": "parameters.constructors",
    "variable_pitch": "parameters.constructors",
    "Case": "parameters.case",
    "load_case": "parameters.loading",
    "list_cases": "parameters.loading",
    "Solution": "solution.result",
    "Event": "solution.event",
    "Status": "solution.status",
    "StaticCurve": "solution.static",
    "ModalResult": "solution.modal",
    "cite": "citations",
    "bibtex": "citations",
    "InputError": "errors",
    "ValvetrainError": "errors",
}

__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module 'valvetrain' has no name '{name}'; see valvetrain.__all__")
    value = getattr(import_module(f"valvetrain.{home}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
