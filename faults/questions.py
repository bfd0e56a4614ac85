"""What is asked of the package with a damaged case or measurement. An answer is a word; anything
raised is a finding.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import tempfile
from functools import cache
from pathlib import Path
from random import Random

from faults import inputs
from faults.commands import COMMANDS, write_inputs
from valvetrain.errors import InputError

#: A sentence of a refusal is no longer than this.
LONGEST = 900
#: Estimated time beyond which a case is not run.
BOUND = "4 s"


class Finding(Exception):
    """Something came back that is neither an answer nor one readable sentence."""


def refused(error: InputError | str) -> str:
    """The word for a refusal; a :class:`Finding` where it is no printable line of reasonable length."""
    sentence = str(error).strip()
    if not sentence.isprintable() or not 0 < len(sentence) <= LONGEST:
        raise Finding(f"a sentence that is no line: {sentence[:200]!r}")
    return "refused"


def command(*words: str) -> tuple[int, str, str]:
    """Exit code of a command in this process, and its two streams; an error that is no sentence is
    raised.
    """
    from valvetrain.cli.main import app

    out, said = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(said):
        code = app(list(words), standalone_mode=False)
    lines = said.getvalue()
    if "\x1b" in out.getvalue() + lines:
        raise Finding(f"a control sequence reaches the terminal: {lines[:300]!r}")
    if "Warning: " in lines:
        raise Finding(f"a warning of a library: {lines[:300]!r}")
    return code or 0, out.getvalue(), lines


def case(content: bytes) -> str:
    """Read and build everything that ``run`` builds."""
    Path("case.toml").write_bytes(content)
    code, _, said = command("check", "case.toml", "--quiet")
    if code not in (0, 2):
        raise Finding(f"exit code {code}: {said[-300:]}")
    return refused(said.strip().rpartition("\n")[2]) if code else "answered"


def run_mutant(chance: Random) -> bytes:
    """A mutant of a short case, near enough to what it was that most can be built."""
    tree = inputs.short_cases()[chance.choice(sorted(inputs.short_cases()))]
    return inputs.case_text(inputs.mutated(chance, tree, mild=0.9))


def run(content: bytes) -> str:
    """``check`` and ``run``: they refuse alike, and what is not refused is run, saved and shown."""
    Path("case.toml").write_bytes(content)
    report = "--report" if len(content) % 2 else "--no-report"
    checked, _, reason = command("check", "case.toml", "--quiet")
    words = ("--model", "massless", "--workers", "1", "--limit", BOUND, "--output", "out", report)
    ran, _, said = command("run", "case.toml", "--quiet", *words)
    if "beyond the bound" in said or "names no engine speed" in said:
        return "refused"  # by the bound of this question, or for what the command line gives
    answer = Path("out", "run.json")
    runs = json.loads(answer.read_text("utf-8"))["runs"] if answer.exists() else []
    if checked not in (0, 2) or ran not in (0, 1, 2):
        raise Finding(f"exit codes {checked} {ran}: {reason[-200:]} {said[-200:]}")
    integrated = ran != 2 and not (runs and all(one["status"]["code"] == "refused" for one in runs))
    # of a spring that cannot be compressed to its installed height, `run` shows the curve
    stuck = checked == 2 and ran == 1 and not runs
    if (checked == 0) != integrated and not stuck:
        raise Finding(f"check gives {checked} ({reason[-250:]}), run gives {ran} ({said[-250:]})")
    return ("answered", "failed" if integrated else "refused", "refused")[ran]


#: Commands that read a file of measurements, and that file.
MEASURED = {
    "lift": "lobe.csv", "compare-test": "cycles.csv", "scan": "scan.ply", "rig": "rig.csv", "film": "film", "identify": "identify.toml",
    "study": "study.toml", "optimise": "search.toml", "spring-card": "table.csv", "rig-tdms": "rig.tdms", "rig-mat": "rig.mat",
}  # fmt: skip
#: A measured spring: heights (mm) and forces (N).
TABLE = "height [mm],force [N]\n" + "\n".join(
    f"{height},{32 * (48 - height) + 0.4 * (48 - height) ** 2:.1f}" for height in range(46, 25, -1)
)


@cache
def measured_files() -> Path:
    """The folder of the whole files; it stays as long as this process."""
    _kept.append(tempfile.TemporaryDirectory(prefix="valvetrain-faults-"))
    folder = write_inputs(Path(_kept[0].name))
    (folder / "table.csv").write_text(TABLE)
    return folder


_kept: list[tempfile.TemporaryDirectory[str]] = []


def measured_mutant(chance: Random) -> bytes:
    """A line that names the command, and the damaged file."""
    name = chance.choice(sorted(MEASURED))
    path = measured_files() / MEASURED[name]
    if path.is_dir():  # one picture of a film
        path = path / "frame-00007.png"
    content, text = path.read_bytes(), path.suffix in (".csv", ".toml")
    change = inputs.damaged_text if text and chance.random() < 0.8 else inputs.damaged
    return name.encode() + b"\n" + change(chance, content)


def measured(content: bytes) -> str:
    """The command on the damaged file: an answer that is JSON without NaN, or one sentence."""
    head, _, body = content.partition(b"\n")
    name = head.decode()
    for path in measured_files().iterdir():
        if path.is_dir():
            os.mkdir(path.name)
            for picture in sorted(path.iterdir())[:60]:
                os.symlink(picture, f"{path.name}/{picture.name}")
        elif path.name != MEASURED[name]:
            os.symlink(path, path.name)
    target = Path(MEASURED[name]) / "frame-00007.png" if name == "film" else Path(MEASURED[name])
    target.unlink(missing_ok=True)
    target.write_bytes(body)
    words = COMMANDS[name.partition("-")[0] if name.startswith("rig") else name]
    if name == "spring-card":
        words = ("spring-card", "table.csv", "--wire-diameter", "3.8 mm", "--outer-diameter", "29 mm", "--installed-height", "38 mm")  # fmt: skip
    plain = [MEASURED[name] if word == "rig.csv" else word for word in words]
    limit = ("--limit", BOUND) if name in ("study", "optimise", "identify") else ()
    code, out, said = command(*plain, *limit, "--json", "--output", "out")
    if code not in (0, 1, 2):
        raise Finding(f"exit code {code}: {said[-300:]}")

    def no_number(word: str) -> None:
        raise Finding(f"{word} in the answer")

    answer = json.loads(out, parse_constant=no_number)
    if code == 2:
        refused(answer["error"]["message"])
    return ("answered", "failed", "refused")[code]
