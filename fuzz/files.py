"""Damaged result files: bytes exchanged, cut and spliced, and files that were made to lie."""

from __future__ import annotations

import json
import os
import random
import tempfile
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

from fuzz import values
from valvetrain.solution.atomic import closing_line, digest

#: What is damaged, by kind.
KINDS = ("solution.nc", "solution.csv", "static.nc", "modes.nc", "run.json", "case.toml")


@cache
def whole() -> dict[str, bytes]:
    """One whole file of each kind, of a run made here; and the folder it was made in."""
    from valvetrain.parameters.loading import load_case
    from valvetrain.report.json import study_json
    from valvetrain.report.study import write_study
    from valvetrain.runs.run import run_study
    from valvetrain.runs.saved_runs import collect_inputs, save_run

    when = "2026-01-01T00:00:00+00:00"
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder, "kept")
        case = load_case("job-t", {"spring.options.finite-element.elements_per_coil": 8})
        study = run_study(
            case, spring_models=("massless", "multi-mass"), workers=1, created_at=when
        )
        written = write_study(study, target, page=False).data
        answer = study_json(study) | {
            "created_at": when,
            "files": [path.relative_to(target).as_posix() for path in written],
        }
        save_run(
            target,
            collect_inputs(
                case.name, case.text, target, {"command": "run", "engine_speeds": [8000.0]}
            ),
            answer,
        )
        named = {
            "solution.nc": next(target.glob("multi-mass-*.nc")), "solution.csv": next(target.glob("multi-mass-*.csv")),
            "static.nc": next(target.glob("static-*.nc")), "modes.nc": next(target.glob("modes-*.nc")), "run.json": target / "run.json",
            "case.toml": target / "inputs" / "case.toml",
        }  # fmt: skip
        return {kind: path.read_bytes() for kind, path in named.items()}


def make(rng: random.Random) -> bytes:
    """One damaged file: a line that says kind and manner, then its bytes."""
    kind = rng.choice((*KINDS[:5], *KINDS))
    content, manner = whole()[kind], rng.random()
    if manner < 0.55:
        return f"{kind} damaged\n".encode() + damaged(rng, content)
    if manner < 0.65 and kind.endswith((".nc", ".csv")):
        # as it was before there were checksums
        earlier = content[:-43].replace(b'"checksum": "blake2b"', b'"checksum": ""       ')
        return f"{kind} unmarked\n".encode() + damaged(rng, earlier)
    lie = {"nc": lying_netcdf, "csv": lying_csv, "json": lying_json, "toml": damaged}[
        kind.rpartition(".")[2]
    ]
    return f"{kind} lying\n".encode() + lie(rng, content)


def damaged(rng: random.Random, content: bytes) -> bytes:
    """Bytes exchanged, cut, repeated, zeroed or taken from another file."""
    changed = bytearray(content)
    for _ in range(rng.choice((1, 1, 1, 2, 5))):
        first = rng.randrange(max(1, len(changed)))
        last = min(len(changed), first + rng.choice((1, 1, 4, 64, 4096)))
        action = rng.randrange(7)
        if action <= 1 and changed:
            changed[first] ^= 1 << rng.randrange(8)
        elif action == 2:
            changed[first:last] = bytes(last - first)
        elif action == 3:
            changed[first:last] = rng.randbytes(last - first)
        elif action == 4:
            del changed[first:]
        elif action == 5:
            changed[first:first] = changed[first:last]
        else:
            other = rng.choice(list(whole().values()))
            start = rng.randrange(len(other))
            changed[first:last] = other[start : start + last - first]
    return bytes(changed)


def lie(rng: random.Random, item: Any, depth: int = 0) -> Any:
    """A JSON tree with one value of it exchanged, removed, added or made deep."""
    if isinstance(item, dict) and item and (depth == 0 or rng.random() < 0.8):
        key = rng.choice(sorted(item))
        action = rng.random()
        if action < 0.15:
            return {name: value for name, value in item.items() if name != key}
        if action < 0.25:
            return item | {rng.choice(values.TEXTS): values.leaf(rng)}
        return item | {key: lie(rng, item[key], depth + 1)}
    if isinstance(item, list) and item and rng.random() < 0.7:
        place = rng.randrange(min(len(item), 30))
        return [*item[:place], lie(rng, item[place], depth + 1), *item[place + 1 :]]
    return rng.choice(
        (
            None,
            True,
            [],
            {},
            "x",
            "",
            0,
            -1,
            10**30,
            1e308,
            float("nan"),
            [[]],
            {"value": []},
            {"value": "7", "unit": 3},
            "\x1b[2J",
            "a\nb",
            values.leaf(rng),
            values.near(rng, item) if not isinstance(item, dict) else {"a": item},
        )
    )


def _text_of(rng: random.Random, text: str) -> str:
    """A JSON text that lies."""
    if rng.random() < 0.1:
        return rng.choice(
            (
                "[" * 100_000,
                '{"a":' * 50_000,
                "null",
                "[]",
                "7",
                '"x"',
                "{}",
                text + text,
                text[: len(text) // 2],
            )
        )
    try:
        return json.dumps(lie(rng, json.loads(text)))
    except (ValueError, RecursionError):
        return "{}"


def lying_json(rng: random.Random, content: bytes) -> bytes:
    """A ``run.json`` that lies, its checksum right, wrong or missing."""
    text = _text_of(rng, content.decode())
    try:
        tree = json.loads(text)
        if isinstance(tree, dict) and rng.random() < 0.8:
            tree.pop("checksum", None)
            if rng.random() < 0.7:
                tree["checksum"] = digest(json.dumps(tree, sort_keys=True).encode())
            text = json.dumps(tree)
    except (ValueError, RecursionError):
        pass
    return text.encode("utf-8", "surrogatepass")


def lying_csv(rng: random.Random, content: bytes) -> bytes:
    """A CSV file whose description or rows lie, its checksum right."""
    lines = content[:-43].decode().split("\n")
    if rng.random() < 0.7:
        lines[1] = "# " + _text_of(rng, lines[1][2:])
    else:
        place = rng.randrange(len(lines))
        lines[place] = rng.choice(
            (
                "",
                "1,2",
                "nan",
                "x,y",
                lines[place] + ",1",
                lines[place][5:],
                "# end of 3 rows",
                "1" * 5000,
            )
        )
    body = "\n".join(lines).encode("utf-8", "surrogatepass")
    return _closed(rng, body)


def _closed(rng: random.Random, body: bytes) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "x")
        path.write_bytes(body)
        if rng.random() < 0.8:
            path.write_bytes(path.read_bytes() + closing_line(path.read_bytes()))
        return path.read_bytes()


def lying_netcdf(rng: random.Random, content: bytes) -> bytes:
    """A NetCDF file that is one, and holds what no result does, its checksum right."""
    import h5py
    import numpy as np

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "x.nc")
        path.write_bytes(content[:-43])
        with h5py.File(path, "r+") as file:
            names = sorted(name for name in file if name != "valvetrain_metadata")
            name, action = rng.choice(names), rng.randrange(12)
            if action <= 3:
                text = file["valvetrain_metadata"][()]
                file["valvetrain_metadata"][()] = _text_of(
                    rng, text.decode() if isinstance(text, bytes) else str(text)
                ).replace("\0", "")
            elif action == 4:
                del file[rng.choice((name, "valvetrain_metadata"))]
            elif action == 5:
                file.move(name, name + "x")
            elif action == 6:
                del file[name]
                file.create_dataset(
                    name,
                    shape=rng.choice(((10**12,), (10**6, 10**6), (2**62,))),
                    chunks=True,
                    dtype="f8",
                )
            elif action == 7:
                del file[name]
                file[name] = rng.choice(
                    (
                        np.array(["a", "b"], dtype="S3"),
                        np.zeros(3),
                        np.float64(1),
                        np.zeros((2, 2, 2)),
                        np.zeros(0),
                    )
                )
            elif action == 8:
                del file[name]
                file[name] = rng.choice(
                    (
                        h5py.SoftLink("/" + name),
                        h5py.ExternalLink("/etc/passwd", "/x"),
                        h5py.SoftLink("/nothing"),
                    )
                )
            elif action == 9:
                file.create_group(f"group{rng.randrange(9)}/a/b")
            elif action == 10:
                file[name].attrs[
                    rng.choice(
                        (
                            "units",
                            "long_name",
                            "coordinates",
                            "_FillValue",
                            "DIMENSION_LIST",
                            "NAME",
                            "CLASS",
                        )
                    )
                ] = rng.choice((1.0, "x", "\x1b[1m", "a" * 5000, np.zeros(3), b"\xff"))
            else:
                for key in rng.sample(sorted(file[name].attrs), min(1, len(file[name].attrs))):
                    del file[name].attrs[key]
        return _closed(rng, path.read_bytes())


def ask(content: bytes) -> str:
    """Read a damaged file by the reader of its kind: it refuses in a sentence, or gives what a
    whole one gives, or what the file says.
    """
    from fuzz.questions import Finding, sentence
    from valvetrain.errors import InputError

    head, _, body = content.partition(b"\n")
    kind, manner = head.decode().split()
    with tempfile.TemporaryDirectory() as folder:
        if kind in ("run.json", "case.toml"):
            return _ask_folder(Path(folder), kind, manner, body)
        found = []
        for name, part in (("whole", whole()[kind]), ("damaged", body)):
            path = Path(folder, f"{name}.{kind.rpartition('.')[2]}")
            path.write_bytes(part)
            try:
                found.append(_load(kind, path))
            except InputError as error:
                return sentence(error)
        if manner == "damaged" and not _same(*found):
            raise Finding("damage was read as data")
        repr(found[1])
        if kind.startswith("solution"):
            found[1].to_pandas()
    return "read"


def _load(kind: str, path: Path) -> Any:
    from valvetrain.solution import netcdf, read_apart

    load = {
        "solution.nc": netcdf.load_netcdf,
        "static.nc": netcdf.load_static_curve,
        "modes.nc": netcdf.load_modal_result,
    }
    # A fork of this process has the libraries already: a hundredth of the time of a new one.
    with mock.patch.object(read_apart, "in_a_new_process", lambda *_: "not asked"):
        return load[kind](path)


def _same(one: Any, other: Any) -> bool:
    import numpy as np

    if hasattr(one, "identical"):
        return bool(one.identical(other))
    pairs = [(getattr(one, name), getattr(other, name)) for name in one.__dataclass_fields__]
    return all(
        np.array_equal(a, b, equal_nan=True) if isinstance(a, np.ndarray) else a == b
        for a, b in pairs
    )


def _ask_folder(folder: Path, kind: str, manner: str, body: bytes) -> str:
    """Two kept runs, one damaged: listed, compared and repeated."""
    from fuzz.questions import Finding, command

    for name in ("whole", "damaged"):
        (folder / "runs" / "job-t" / name / "inputs").mkdir(parents=True)
        (folder / "runs" / "job-t" / name / "run.json").write_bytes(whole()["run.json"])
        (folder / "runs" / "job-t" / name / "inputs" / "case.toml").write_bytes(
            whole()["case.toml"]
        )
    place = folder / "runs" / "job-t" / "damaged"
    (place / "run.json" if kind == "run.json" else place / "inputs" / "case.toml").write_bytes(body)
    before = os.getcwd()
    os.chdir(folder)
    try:
        codes = [command("runs")[0], command("check", str(place))[0]]
        code, said = command("compare-runs", "runs/job-t/whole", str(place))
    finally:
        os.chdir(before)
    if any(one not in (0, 2) for one in (*codes, code)):
        raise Finding(f"exit codes {codes} {code}: {said[-200:]}")
    if (
        manner == "damaged"
        and code == 0
        and not ("the inputs are the same" in said and "the results are the same" in said)
    ):
        raise Finding(f"damage was taken for a difference: {said[:300]}")
    return "read" if code == 0 else "refused"
