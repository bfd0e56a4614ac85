from valvetrain.cam.contract import LiftLaw as LiftLaw
from valvetrain.cam.contract import build_lift_law as build_lift_law
