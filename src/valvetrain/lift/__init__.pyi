from valvetrain.lift.band import lift_band_study as lift_band_study
from valvetrain.lift.figures import lift_figures as lift_figures
