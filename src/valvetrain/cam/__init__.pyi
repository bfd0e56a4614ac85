from valvetrain.cam.build import build_lift_law as build_lift_law
from valvetrain.cam.contract import LiftLaw as LiftLaw
