"""``valvetrain rig``: recordings of a test rig as cycles over the cam angle."""

from __future__ import annotations

from pathlib import Path

from valvetrain.cli.request import SavedLine, command_of
from valvetrain.rig.request import RigRequest


def rig(request: RigRequest, line: SavedLine, folder: Path) -> None:
    """Recordings of a test rig as cycles over the cam angle, aligned to a case by the lift."""
    from hashlib import file_digest

    from valvetrain.cli.outcome import deliver
    from valvetrain.cli.progress import busy
    from valvetrain.cli.run_answer import SavedRequest, saved_result
    from valvetrain.rig.answer import RigAnswer, data_of
    from valvetrain.rig.cycles import rig_cycles
    from valvetrain.views.files import FreeNames

    file, case = request.file, request.case
    with busy("cutting the recording into cycles"):
        result = rig_cycles(file, request, case)
    name = FreeNames().free(f"rig-{file.stem}")
    # two saved runs are the same where the request and the bytes of the file are
    with file.open("rb") as stream:
        digest = file_digest(stream, "blake2b").hexdigest()[:32]
    deliver(
        saved_result(
            SavedRequest("rig", Path(name), line.output, folder),
            f'name = "{name}"\n' if case is None else case.text,
            data_of(result) | {"case": case.name if case else ""},
            lambda folder: RigAnswer(result, folder=folder),
            RigAnswer(result).write,
            request.given | {"file": file.name, "digest": digest},
            line.open_page,
        )
    )


register = command_of(RigRequest, SavedLine, rig)
