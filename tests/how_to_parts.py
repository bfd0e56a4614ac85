"""The guides of docs/how-to as the tests read them: one command, one picture, and a table of
numbers that the command gives.
"""

from __future__ import annotations

import itertools
import json
import math
import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from valvetrain.cli.main import app
from valvetrain.explore.new_command import write_template
from valvetrain.explore.outputs import Task
from valvetrain.explore.requests import Study
from valvetrain.units import unit_factor

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "how-to"
PAGES = sorted(FOLDER.glob("[0-9][0-9]-*.md"))
#: Words of a page -> state of a train whose modes are told.
STATES = {"valve closed": "closed", "full lift": "full_lift"}
_NUMBER = re.compile(r"^([-−+]?[\d.]+)(?: to ([-−]?[\d.]+))?\s*(.*)$")
#: An engine speed of a study that does not vary it.
SPEED = re.compile(r"[\d.]+ rpm")
_COMMANDS_WITHOUT_PAGE = ("run", "sweep")


@dataclass(frozen=True)
class Row:
    """One number of a guide: ``quantity``, where it is taken, its printed ``value`` and its
    ``unit``.
    """

    quantity: str
    place: tuple[str, ...]
    value: str
    unit: str

    @property
    def decimals(self) -> int:
        """Digits behind the point."""
        return len(self.value.partition(".")[2])

    def agrees(self, computed: float) -> bool:
        """Whether the printed digits are those of a computed value (in the unit of the page)."""
        printed = float(self.value.replace("−", "-"))
        return abs(computed - printed) <= 0.6 * 10.0**-self.decimals + 1e-3 * abs(printed)


@dataclass(frozen=True)
class Guide:
    """A page: its text, its one command, its picture and its numbers."""

    path: Path

    @property
    def text(self) -> str:
        """The whole page."""
        return self.path.read_text(encoding="utf-8")

    @property
    def commands(self) -> list[str]:
        """What stands in the shell blocks, a line each."""
        blocks = re.findall(r"^```sh\n(.*?)^```", self.text, re.MULTILINE | re.DOTALL)
        return [line for block in blocks for line in block.splitlines() if line.strip()]

    @property
    def files(self) -> dict[str, str]:
        """Name of each file that the page says to save -> its text."""
        return dict(
            re.findall(r"^Save this as `([\w.-]+)`:\n\n```\w+\n(.*?)^```", self.text, re.M | re.S)
        )

    @property
    def words(self) -> list[str]:
        """The command in words, without ``valvetrain``."""
        (command,) = self.commands
        return shlex.split(command)[1:]

    @property
    def rows(self) -> list[Row]:
        """The table of numbers."""
        found = []
        for line in self.text.splitlines():
            cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
            if len(cells) == 4 and cells[0].startswith("`") and (given := _NUMBER.match(cells[1])):
                place = tuple(
                    part.strip() for part in cells[2].split(",") if part.strip() not in ("", "–")
                )
                found.append(Row(cells[0].strip("`"), place, given[1], given[3]))
        return found

    def write_files(self) -> None:
        """The files and the template cases that the page names, into the folder that is current."""
        for name, text in self.files.items():
            Path(name).write_text(text, encoding="utf-8")
        for name, kind in re.findall(r"`valvetrain new ([\w-]+) --kind (\w+)`", self.text):
            if not Path(f"{name}.toml").exists():
                write_template(name, kind)

    def answer(self, folder: Path) -> dict[str, Any]:
        """What the command prints with ``--json``."""
        words = [str(ROOT / word) if word.startswith("examples/") else word for word in self.words]
        words += [
            "--json",
            *(("--no-report", "--workers", "1") if words[0] in _COMMANDS_WITHOUT_PAGE else ()),
        ]
        words += [] if words[0] in ("modes", "check") else ["--output", str(folder / "results")]
        result = CliRunner().invoke(app, words)
        assert result.exit_code == 0, result.output
        answer: dict[str, Any] = json.loads(result.stdout)
        return answer


def holds(answer: Mapping[str, Any], row: Row) -> bool:
    """Whether a row is what the command answers. Of a best design the objective is held to a hundredth, what
    is varied to the valley of designs as good, what follows from it to a tenth: the path of a search
    is that of a processor.
    """
    computed = number_of(answer, row)
    if answer["command"] != "optimise" or row.place != ("best",):
        return row.agrees(computed)
    printed = float(row.value.replace("−", "-"))
    valley = answer["designs"][0]["valley"]["values"]
    objective = answer["designs"][0]["trial"]["objectives"][0]
    for one, column in zip(answer["varied"], zip(*valley, strict=True), strict=True):
        if one["label"] == row.quantity and in_unit(objective, row.unit) != computed:
            low, high = (in_unit(end, row.unit) for end in (min(column), max(column)))
            return low - abs(printed) / 100 <= printed <= high + abs(printed) / 100
    share = 0.01 if in_unit(objective, row.unit) == computed else 0.1
    return abs(computed - printed) <= share * abs(printed)


def in_unit(value: float | Mapping[str, Any], unit: str) -> float:
    """A value in SI, or with its unit as ``--json`` prints it, in the unit of the page."""
    if isinstance(value, Mapping):
        value = value["value"]
    return value / unit_factor(unit) if unit not in ("", "1") else value


def number_of(answer: Mapping[str, Any], row: Row) -> float:
    """The number of a row in what its command answered, in the unit of the page."""
    command = answer["command"]
    if command == "study":
        return _of_study(answer, row)
    if command == "optimise":
        return _of_search(answer, row)
    if command == "identify":
        name, _, which = row.quantity.partition(".")
        return in_unit(answer["branches"][0]["quantities"][name][which], row.unit)
    if command == "lift":
        return _of_lift(answer, row)
    if row.quantity in ("contact-loss", "float"):
        (found,) = [one for one in answer["critical_speeds"] if one["kind"] == row.quantity]
        return float(found["engine_speed"]["value"])
    return _of_runs(answer, row)


def _of_runs(answer: Mapping[str, Any], row: Row) -> float:
    if row.place and row.place[0] in STATES:
        state = STATES[row.place[0]]
        (train,) = [one for one in answer["train_modes"] if one["state"] == state]
        number = int(row.quantity.rpartition("_")[2])
        return in_unit(train["modes"][number - 1]["natural_frequency"]["value"], row.unit)
    runs = [run for run in answer["runs"] if all(_is_at(run, place) for place in row.place)]
    event, _, detail = row.quantity.partition(".")
    if detail:
        happened = [one for run in runs for one in run["events"] if one["kind"] == event]
        largest = max(happened, key=lambda one: one["size"]["value"])
        chosen = largest[detail] if detail in largest else largest["details"][detail]
        turned = (
            chosen["value"] % (2 * math.pi) if detail.endswith("cam_angle") else chosen["value"]
        )
        return in_unit(turned, row.unit)
    tables = [
        *(run["quantities"] for run in runs),
        answer["quantities"],
        *answer["quantities_by_label"].values(),
    ]
    found = [table[row.quantity] for table in tables if row.quantity in table]
    assert found, f"{row.quantity} at {row.place}"
    return in_unit(found[0]["value"], row.unit)


def _is_at(run: Mapping[str, Any], place: str) -> bool:
    if place.endswith("rpm"):
        return bool(abs(run["engine_speed"]["value"] - float(place.split()[0])) < 0.5)
    return place in (run["label"], run["model"], run["spring_set"])


def _inputs(row: Row) -> dict[str, tuple[float, str]]:
    """Key -> value and unit of what a row of a study was computed at."""
    found = {}
    for place in (one for one in row.place if not SPEED.fullmatch(one)):
        key, _, rest = place.partition(" ")
        given = _NUMBER.match(rest)
        assert given is not None, place
        found[key.strip("`")] = float(given[1]), given[3]
    return found


def _of_study(answer: Mapping[str, Any], row: Row) -> float:
    wanted = _inputs(row)
    speeds = [float(one.split()[0]) for one in row.place if SPEED.fullmatch(one)]
    for one in answer["rows"]:
        own = one.get("engine_speed") or math.pi / 30 * (one.get("speed") or 0.0)
        if speeds and not math.isclose(own, speeds[0] * math.pi / 30, rel_tol=1e-6):
            continue
        given = {
            each["key"]: in_unit(one[each["name"]], wanted[each["key"]][1])
            for each in answer["varied"]
            if each["key"] in wanted
        }
        if all(
            abs(given[key] - value) <= 1e-6 * max(abs(value), 1e-9)
            for key, (value, _) in wanted.items()
        ):
            return in_unit(one[row.quantity], row.unit)
    raise AssertionError(f"no row of the study at {row.place}")


def rows_of_study(guide: Guide) -> dict[str, Any]:
    """Those points of a study that its page prints, computed and shaped as the command's answer."""
    plan = Study.read({"file": guide.words[1]}).plan
    draws = plan.sampler.draw(plan.varied, plan.options)
    varied = [{"name": one.name, "key": one.key} for one in plan.varied]
    answer: dict[str, Any] = {"command": "study", "varied": varied, "rows": []}
    for draw, run in itertools.product(draws, plan.runs):
        point = {"engine_speed": run[0], **dict(zip(plan.varied.names, draw, strict=True))}
        nothing = point | dict.fromkeys(plan.outputs, 0.0)
        if any(_stands({**answer, "rows": [nothing]}, row) for row in guide.rows):
            outcome = plan.experiment.evaluate(draw, Task(run, plan.experiment.outputs.request))
            assert outcome.status.completed, outcome.status.sentence()
            answer["rows"].append(point | dict(outcome.values))
    return answer


def _stands(answer: Mapping[str, Any], row: Row) -> bool:
    try:
        _of_study(answer, row)
    except AssertionError:
        return False
    return True


def _of_search(answer: Mapping[str, Any], row: Row) -> float:
    trial = answer["of_case"] if row.place == ("case",) else answer["designs"][0]["trial"]
    named = dict(zip((one["label"] for one in answer["varied"]), trial["values"], strict=True))
    named |= dict(
        zip(
            (one["measure"]["quantity"] for one in answer["objectives"]),
            trial["objectives"],
            strict=True,
        )
    )
    named |= dict(
        zip(
            (one["measure"]["quantity"] for one in answer["constraints"]),
            trial["constraints"],
            strict=True,
        )
    )
    return in_unit(named[row.quantity], row.unit)


def _of_lift(answer: Mapping[str, Any], row: Row) -> float:
    (lobe,) = answer["lobes"]
    if row.quantity == "noise":
        return in_unit(lobe["noise"], row.unit)
    name, _, half = row.quantity.partition(" ")
    one = lobe["figures"][name]
    value: float = 1.959963984540054 * one["standard_deviation"] if half else one["value"]
    if row.unit == "µm/deg²":
        return value * 1e6 * math.radians(1) ** 2
    return in_unit(value, row.unit)
