"""case file -> parameters -> Problem (parts, built once) -> System -> integrate -> Solution -> quantities -> report

Dynamics of valve springs and valvetrains. The names below load their rooms on first use, so that
``import valvetrain`` itself costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

#: Public name -> module that holds it.
_HOMES = {
    # the spring and its case
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
    # parts
    "LiftLaw": "cam.contract",
    "build_lift_law": "cam.build",
    "ContactLaw": "contact.law",
    "build_contact_law": "contact.library",
    "SpringModel": "springs.contract",
    "EquivalentSpring": "springs.equivalent",
    "MasslessSpring": "springs.massless",
    "MasslessTable": "springs.massless",
    "MultiMassSpring": "springs.multi_mass",
    "ModalUniform": "springs.modal_uniform",
    "ModalVaried": "springs.modal_varied",
    "WaveRod": "springs.wave_rod",
    "WaveRodWithClash": "springs.wave_rod_clash",
    "NestedSprings": "springs.nested",
    "FiniteElementRod": "springs.finite_element",
    "SolidSpring": "springs.solid.jobs",
    # studies
    "run_spring_study": "studies.spring_study",
    "SpringStudy": "quantities.study",
    "run_train": "studies.train_study",
    "run_train_study": "studies.train_study",
    "TrainRun": "quantities.valvetrain_study",
    "TrainStudy": "quantities.valvetrain_study",
    "run_sweep": "studies.sweep",
    "TrainSweep": "studies.sweep",
    "run_solid_comparison": "studies.solid_comparison",
    "SolidChoice": "studies.solid_comparison",
    "SpringComparison": "quantities.spring_comparison",
    "simulate_batch": "cosserat.batch",
    "RodBatch": "cosserat.batch",
    "map_cases": "studies.batch",
    # results
    "Solution": "solution.result",
    "Event": "solution.event",
    "Status": "solution.status",
    "StaticCurve": "solution.static",
    "ModalResult": "solution.modal",
    "Comparison": "solution.comparison",
    "Quantity": "solution.quantity",
    "save_netcdf": "solution.netcdf",
    "load_netcdf": "solution.netcdf",
    "save_csv": "solution.textfile",
    "load_csv": "solution.textfile",
    "write_study": "report.write",
    "study_page": "report.build",
    "study_json": "report.json",
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
