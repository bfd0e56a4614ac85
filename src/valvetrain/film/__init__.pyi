from valvetrain.film.model import FilmedModel as FilmedModel
from valvetrain.film.model import film_over_model as film_over_model
from valvetrain.film.motion import coil_motion as coil_motion
from valvetrain.film.result import CoilMotion as CoilMotion
from valvetrain.film.setup import FilmSetup as FilmSetup
