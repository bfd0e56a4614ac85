"""``valvetrain rig`` without a file: the forces of a case as a gauge records them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from valvetrain.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from valvetrain.measurements.sensor import Sensor

#: Words of --sensor -> what they are.
_WORDS = (
    "bandwidth", "order", "filter", "zero_phase", "natural_frequency", "mounting_stiffness", "moved_mass", "damping_ratio", "sampling_rate",
    "resolution",
)  # fmt: skip


def seen(
    case: str, settings: Sequence[str] | None, engine_speeds: tuple[float, ...] | None, spring_models: tuple[str, ...],
    gauge: tuple[str | None, str | None, str | None], deliver: Callable[..., None],
) -> None:  # fmt: skip
    """Run the case and tell true and recorded peaks; ``gauge``: --bandwidth, --sensor, --sampling-rate."""
    from valvetrain.cli.case_choice import choose_case, folder_of
    from valvetrain.cli.progress import busy
    from valvetrain.report.seen_page import data_of, seen_page, sensor_words
    from valvetrain.report.seen_page import write_seen as write
    from valvetrain.studies.seen import seen_in_case

    sensor = read_sensor(*gauge)
    chosen = choose_case(case, list(settings or ()))
    with busy("running the case for the gauge"):
        found = seen_in_case(chosen, sensor, engine_speeds or (), spring_models)
    data = data_of(found, sensor, chosen.name)
    page = seen_page(chosen.name, found, sensor)

    def files(folder: Path) -> list[Path]:
        return write(found, folder)

    def show(console: Console) -> None:
        from valvetrain.cli.tables import plain_table
        from valvetrain.report.seen_page import HEAD, notes_of, seen_rows

        console.print(f"Gauge: {sensor_words(sensor)}", soft_wrap=True)
        console.print()
        console.print(plain_table(HEAD, seen_rows(found), right=(2, 3, 4, 6)))
        for sentence in notes_of(found):
            console.print(f"{sentence}.", soft_wrap=True)

    asked = {"gauge": sensor_words(sensor), "speeds": str(engine_speeds or ""), "models": ", ".join(spring_models)}
    deliver(chosen.name, chosen.text, page, data, files, show, asked, folder_of(case))


def read_sensor(bandwidth: str | None, words: str | None, sampling_rate: str | None) -> Sensor:
    """The gauge of ``--bandwidth``, ``--sampling-rate`` and ``--sensor 'KEY=VALUE, ...'``. Raises :class:`InputError` for other words."""
    from valvetrain.measurements.sensor import Sensor

    given: dict[str, Any] = {}
    for part in (words or "").split(","):
        if not part.strip():
            continue
        key, sign, value = (one.strip() for one in part.partition("="))
        key = key.replace("-", "_").replace(" ", "_")
        if key not in _WORDS or not sign or not value:
            raise InputError(f"'{part.strip()[:40]}' is no property of a gauge; use KEY=VALUE with {', '.join(_WORDS)}", "--sensor")
        given[key] = _value(key, value)
    for key, text in (("bandwidth", bandwidth), ("sampling_rate", sampling_rate)):
        if text is not None:
            if key in given:
                raise InputError(f"{key} is given twice; give it once", "--sensor")
            given[key] = text
    return Sensor(**given)


def _value(key: str, value: str) -> Any:
    if key == "zero_phase":
        if value.lower() not in ("yes", "no", "true", "false"):
            raise InputError(f"zero_phase is yes or no, not '{value[:20]}'", "--sensor")
        return value.lower() in ("yes", "true")
    if key in ("order", "damping_ratio", "resolution"):
        try:
            return int(value) if key == "order" else float(value)
        except ValueError as error:
            raise InputError(f"{key} is a number, not '{value[:20]}'; correct it", "--sensor") from error
    return value
