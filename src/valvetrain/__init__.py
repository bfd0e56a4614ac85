"""case file -> parameters -> Problem -> System -> integrate -> Solution -> quantities -> report

Dynamics of valve springs and valvetrains. The names below load their packages on first use, so that
``import valvetrain`` itself costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

__version__ = "0.1.0"

#: Public name -> module that holds it. A new name is a line here and one in the block for type
#: checkers below; a test compares them.
_HOMES = {
    # the spring and its case
    "SpringDefinition": "parameters.spring",
    "EndCoil": "parameters.spring",
    "Guide": "parameters.installed_spring",
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
    "Case": "api.case",
    "Spring": "api.parts",
    "Train": "api.parts",
    "load": "api.files",
    "save": "api.files",
    "diff": "api.files",
    "map": "api.files",
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
    # measured lifts
    "read_lift": "measured.lift_file",
    "LiftAnswers": "measured.lift_file",
    "MeasuredLift": "measured.lift_file",
    "smooth_lift": "measured.lift_smoothing",
    "SmoothedLift": "measured.lift_smoothing",
    "lift_figures": "lift.figures",
    "lift_band_study": "lift.band",
    # films of a spring
    "coil_motion": "film.motion",
    "CoilMotion": "film.result",
    "FilmSetup": "film.setup",
    "film_over_model": "film.model",
    "FilmedModel": "film.model",
    # identification
    "identify": "explore.identify",
    "Identified": "explore.identified",
    "Prior": "explore.space",
    "Datum": "explore.posterior",
    "Search": "explore.identification_file",
    # springs from cards and from a spring tester
    "SpringLoad": "spring_card.card",
    "CatalogueCard": "spring_card.card",
    "spring_from_card": "spring_card.fit",
    "SpringFit": "spring_card.fit",
    "read_force_height": "measured.force_height",
    "ForceHeight": "measured.force_height",
    "card_from_table": "spring_card.tester",
    "spring_from_tester": "spring_card.tester",
    "TesterFit": "spring_card.tester",
    # recordings of a test rig
    "rig_cycles": "rig.cycles",
    "RigAnswers": "rig.channels",
    "RigResult": "rig.result",
    "MeasuredCycles": "measured.cycles",
    "read_cycles": "measured.cycles",
    "write_cycles": "measured.cycles",
    "Sensor": "measured.sensor",
    "sensor_response": "rig.gauge",
    # springs from scans
    "spring_from_scan": "scan.reconstruct",
    "ScannedSpring": "scan.result",
    "compare_scan": "scan.compare",
    "ScanComparison": "scan.compare",
    # model against test
    "compare_with_test": "compare_test.compare",
    "ModelAgainstTest": "compare_test.compare",
    "AdequacyTest": "compare_test.adequacy",
    "adequacy_test": "compare_test.adequacy",
    "read_value_table": "measured.value_table",
    "ValueTable": "measured.value_table",
    # studies
    "build": "system.build",
    "Problem": "system.problem",
    "simulate": "runs.api",
    "compare": "runs.api",
    "sweep": "runs.api",
    "fidelity": "runs.fidelity",
    "FidelityMap": "solution.fidelity",
    "critical_speeds": "runs.api",
    "static_curve": "runs.api",
    "refine": "runs.refine",
    "buckling_compression": "quantities.statics",
    "Study": "solution.study",
    "simulate_batch": "cosserat.batch",
    "RodBatch": "cosserat.batch",
    "map_cases": "runs.workers",
    "Uniform": "explore.space",
    "Normal": "explore.space",
    "LogNormal": "explore.space",
    "Values": "explore.space",
    "Space": "explore.space",
    "Outputs": "explore.outputs",
    "Experiment": "explore.experiment",
    "study": "explore.study",
    "StudyTable": "explore.table",
    "optimise": "explore.optimise",
    "Optimum": "explore.optimum",
    "run_up": "runs.run_up",
    "train_modes": "runs.train_runs",
    # results
    "Solution": "solution.result",
    "CriticalSpeeds": "solution.critical",
    "Event": "solution.status",
    "Status": "solution.status",
    "StaticCurve": "solution.static",
    "ModalResult": "solution.modes",
    "TrainModes": "solution.modes",
    "Comparison": "solution.comparison",
    "Quantity": "solution.quantity",
    "Quantities": "solution.quantity",
    "save_netcdf": "solution.netcdf",
    "load_netcdf": "solution.netcdf",
    "save_csv": "solution.textfile",
    "load_csv": "solution.textfile",
    "write_study": "report.study",
    "study_page": "report.study",
    "study_json": "report.json",
    "cite": "citations",
    "bibtex": "citations",
    "InputError": "errors",
    "ValvetrainError": "errors",
}

__all__ = ["__version__", *_HOMES]

#: Earlier public names, answered by the new ones with a warning.
_RENAMED = {"seen_by_sensor": "sensor_response", "card_of_table": "card_from_table"}

if TYPE_CHECKING:
    from valvetrain.api.case import Case as Case
    from valvetrain.api.files import diff as diff
    from valvetrain.api.files import load as load
    from valvetrain.api.files import map as map
    from valvetrain.api.files import save as save
    from valvetrain.api.parts import Spring as Spring
    from valvetrain.api.parts import Train as Train
    from valvetrain.cam.build import build_lift_law as build_lift_law
    from valvetrain.cam.contract import LiftLaw as LiftLaw
    from valvetrain.citations import bibtex as bibtex
    from valvetrain.citations import cite as cite
    from valvetrain.compare_test.adequacy import AdequacyTest as AdequacyTest
    from valvetrain.compare_test.adequacy import adequacy_test as adequacy_test
    from valvetrain.compare_test.compare import ModelAgainstTest as ModelAgainstTest
    from valvetrain.compare_test.compare import compare_with_test as compare_with_test
    from valvetrain.contact.law import ContactLaw as ContactLaw
    from valvetrain.contact.library import build_contact_law as build_contact_law
    from valvetrain.cosserat.batch import RodBatch as RodBatch
    from valvetrain.cosserat.batch import simulate_batch as simulate_batch
    from valvetrain.errors import InputError as InputError
    from valvetrain.errors import ValvetrainError as ValvetrainError
    from valvetrain.explore.experiment import Experiment as Experiment
    from valvetrain.explore.identification_file import Search as Search
    from valvetrain.explore.identified import Identified as Identified
    from valvetrain.explore.identify import identify as identify
    from valvetrain.explore.optimise import optimise as optimise
    from valvetrain.explore.optimum import Optimum as Optimum
    from valvetrain.explore.outputs import Outputs as Outputs
    from valvetrain.explore.posterior import Datum as Datum
    from valvetrain.explore.space import LogNormal as LogNormal
    from valvetrain.explore.space import Normal as Normal
    from valvetrain.explore.space import Prior as Prior
    from valvetrain.explore.space import Space as Space
    from valvetrain.explore.space import Uniform as Uniform
    from valvetrain.explore.space import Values as Values
    from valvetrain.explore.study import study as study
    from valvetrain.explore.table import StudyTable as StudyTable
    from valvetrain.film.model import FilmedModel as FilmedModel
    from valvetrain.film.model import film_over_model as film_over_model
    from valvetrain.film.motion import coil_motion as coil_motion
    from valvetrain.film.result import CoilMotion as CoilMotion
    from valvetrain.film.setup import FilmSetup as FilmSetup
    from valvetrain.lift.band import lift_band_study as lift_band_study
    from valvetrain.lift.figures import lift_figures as lift_figures
    from valvetrain.measured.cycles import MeasuredCycles as MeasuredCycles
    from valvetrain.measured.cycles import read_cycles as read_cycles
    from valvetrain.measured.cycles import write_cycles as write_cycles
    from valvetrain.measured.force_height import ForceHeight as ForceHeight
    from valvetrain.measured.force_height import read_force_height as read_force_height
    from valvetrain.measured.lift_file import LiftAnswers as LiftAnswers
    from valvetrain.measured.lift_file import MeasuredLift as MeasuredLift
    from valvetrain.measured.lift_file import read_lift as read_lift
    from valvetrain.measured.lift_smoothing import SmoothedLift as SmoothedLift
    from valvetrain.measured.lift_smoothing import smooth_lift as smooth_lift
    from valvetrain.measured.sensor import Sensor as Sensor
    from valvetrain.measured.value_table import ValueTable as ValueTable
    from valvetrain.measured.value_table import read_value_table as read_value_table
    from valvetrain.parameters.constructors import barrel as barrel
    from valvetrain.parameters.constructors import beehive as beehive
    from valvetrain.parameters.constructors import conical as conical
    from valvetrain.parameters.constructors import cylindrical as cylindrical
    from valvetrain.parameters.constructors import hourglass as hourglass
    from valvetrain.parameters.constructors import variable_pitch as variable_pitch
    from valvetrain.parameters.curves import Constant as Constant
    from valvetrain.parameters.curves import FunctionCurve as FunctionCurve
    from valvetrain.parameters.curves import PiecewiseLinear as PiecewiseLinear
    from valvetrain.parameters.curves import Table as Table
    from valvetrain.parameters.installed_spring import Guide as Guide
    from valvetrain.parameters.loading import list_cases as list_cases
    from valvetrain.parameters.loading import load_case as load_case
    from valvetrain.parameters.material import Material as Material
    from valvetrain.parameters.spring import EndCoil as EndCoil
    from valvetrain.parameters.spring import SpringDefinition as SpringDefinition
    from valvetrain.quantities.statics import buckling_compression as buckling_compression
    from valvetrain.report.json import study_json as study_json
    from valvetrain.report.study import study_page as study_page
    from valvetrain.report.study import write_study as write_study
    from valvetrain.rig.channels import RigAnswers as RigAnswers
    from valvetrain.rig.cycles import rig_cycles as rig_cycles
    from valvetrain.rig.gauge import sensor_response as sensor_response
    from valvetrain.rig.result import RigResult as RigResult
    from valvetrain.runs.api import compare as compare
    from valvetrain.runs.api import critical_speeds as critical_speeds
    from valvetrain.runs.api import simulate as simulate
    from valvetrain.runs.api import static_curve as static_curve
    from valvetrain.runs.api import sweep as sweep
    from valvetrain.runs.fidelity import fidelity as fidelity
    from valvetrain.runs.refine import refine as refine
    from valvetrain.runs.run_up import run_up as run_up
    from valvetrain.runs.train_runs import train_modes as train_modes
    from valvetrain.runs.workers import map_cases as map_cases
    from valvetrain.scan.compare import ScanComparison as ScanComparison
    from valvetrain.scan.compare import compare_scan as compare_scan
    from valvetrain.scan.reconstruct import spring_from_scan as spring_from_scan
    from valvetrain.scan.result import ScannedSpring as ScannedSpring
    from valvetrain.solution.comparison import Comparison as Comparison
    from valvetrain.solution.critical import CriticalSpeeds as CriticalSpeeds
    from valvetrain.solution.fidelity import FidelityMap as FidelityMap
    from valvetrain.solution.modes import ModalResult as ModalResult
    from valvetrain.solution.modes import TrainModes as TrainModes
    from valvetrain.solution.netcdf import load_netcdf as load_netcdf
    from valvetrain.solution.netcdf import save_netcdf as save_netcdf
    from valvetrain.solution.quantity import Quantities as Quantities
    from valvetrain.solution.quantity import Quantity as Quantity
    from valvetrain.solution.result import Solution as Solution
    from valvetrain.solution.static import StaticCurve as StaticCurve
    from valvetrain.solution.status import Event as Event
    from valvetrain.solution.status import Status as Status
    from valvetrain.solution.study import Study as Study
    from valvetrain.solution.textfile import load_csv as load_csv
    from valvetrain.solution.textfile import save_csv as save_csv
    from valvetrain.spring_card.card import CatalogueCard as CatalogueCard
    from valvetrain.spring_card.card import SpringLoad as SpringLoad
    from valvetrain.spring_card.fit import SpringFit as SpringFit
    from valvetrain.spring_card.fit import spring_from_card as spring_from_card
    from valvetrain.spring_card.tester import TesterFit as TesterFit
    from valvetrain.spring_card.tester import card_from_table as card_from_table
    from valvetrain.spring_card.tester import spring_from_tester as spring_from_tester
    from valvetrain.springs.contract import SpringModel as SpringModel
    from valvetrain.springs.equivalent import EquivalentSpring as EquivalentSpring
    from valvetrain.springs.finite_element import FiniteElementRod as FiniteElementRod
    from valvetrain.springs.massless import MasslessSpring as MasslessSpring
    from valvetrain.springs.massless import MasslessTable as MasslessTable
    from valvetrain.springs.modal_uniform import ModalUniform as ModalUniform
    from valvetrain.springs.modal_varied import ModalVaried as ModalVaried
    from valvetrain.springs.multi_mass import MultiMassSpring as MultiMassSpring
    from valvetrain.springs.nested import NestedSprings as NestedSprings
    from valvetrain.springs.solid.jobs import SolidSpring as SolidSpring
    from valvetrain.springs.wave_rod import WaveRod as WaveRod
    from valvetrain.springs.wave_rod_clash import WaveRodWithClash as WaveRodWithClash
    from valvetrain.system.build import build as build
    from valvetrain.system.problem import Problem as Problem
else:  # a type checker that saw this would take any name for granted

    def __getattr__(name: str) -> object:
        if name in _RENAMED:
            import warnings

            message = f"valvetrain.{name} is named valvetrain.{_RENAMED[name]} now"
            warnings.warn(message, DeprecationWarning, stacklevel=2)
            return __getattr__(_RENAMED[name])
        home = _HOMES.get(name)
        if home is None:
            raise AttributeError(
                f"module 'valvetrain' has no name '{name}'; see valvetrain.__all__"
            )
        value = getattr(import_module(f"valvetrain.{home}"), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted(__all__)
