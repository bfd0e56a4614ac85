"""``valvetrain film``: a high-speed film of a valve spring in; motion of its coils, peaks, surge
lines and damping out.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from valvetrain.cli.request import SavedLine, command_of
from valvetrain.film.setup import FilmRequest

if TYPE_CHECKING:
    from valvetrain.film.cycles import Lift
    from valvetrain.parameters.case import Case


def film(request: FilmRequest, line: SavedLine, folder: Path) -> None:
    """High-speed film of a valve spring: coil motion over the cam angle, peaks, surge frequencies
    with damping; compared with a model.
    """
    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import announce_compilation, busy
    from valvetrain.cli.run_answer import SavedRequest, saved_result
    from valvetrain.film.answer import FilmAnswer, film_json
    from valvetrain.film.model import film_over_model
    from valvetrain.film.motion import coil_motion

    case, model, synthetic = request.case, None, request.synthetic
    lift = _lift(request.lift_table, case)
    with busy("following the coils"):
        motion = coil_motion(request.film, request, lift, synthetic)
    if case is not None:
        announce_compilation("train" if case.train is not None else "transient")
        with busy(f"running {case.name} at the speed of the film"):
            model = film_over_model(
                motion, case, request.models, request.spring, request.first_turn
            )
    name = Path(
        f"film-{request.film.resolve().stem}"[:80]
    )  # what is not a case is saved by its name
    deliver(
        saved_result(
            SavedRequest("film", case or name, line.output, folder),
            'name = "film"\ntitle = "Film of a valve spring"\n'
            if case is None
            else case.record().text,
            film_json(motion, model) | {"synthetic": synthetic},
            lambda folder: FilmAnswer(motion, model, synthetic, folder),
            FilmAnswer(motion, model).write,
            request.given,
            line.open_page,
        )
    )


register = command_of(FilmRequest, SavedLine, film)


def _lift(table: Path | None, case: Case | None) -> Lift | None:
    """Lift over the cam angle, from a table or the case."""
    import numpy as np

    from valvetrain.measured.lift_file import chosen_lobe, read_lift
    from valvetrain.measured.lift_smoothing import smooth_lift
    from valvetrain.system.build import valve_lift_of

    if table is None:
        return None if case is None else valve_lift_of(case)
    lobe = chosen_lobe(read_lift(table), "", table.name)
    law = smooth_lift(lobe.cam_angles, lobe.lifts)
    # A table may begin at any angle, below zero too.
    return lambda cam_angle: law.lift(law.event[0] + np.mod(cam_angle - law.event[0], 2 * np.pi))
