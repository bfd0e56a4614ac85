"""Property-based: whatever bytes a recording holds, it is read or refused with one sentence;
nothing in it is run or followed.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from valvetrain import registry
from valvetrain.errors import InputError
from valvetrain.rig.channels import RigAnswers
from valvetrain.rig.cycles import cycles_in
from valvetrain.rig.reader import Recording, RigFormat, form_of, read_recording

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from sample_rig import WRITERS, Rig, record  # noqa: E402

#: Damaged files of each form; a whole amount is in the docs.
COUNT = 12


def small():
    def lift(angle):
        return 9e-3 * np.clip(np.cos(angle), 0, None) ** 2

    return record(
        Rig(cycles=2, sampling_rate=5e3, seed=2), lift, lambda angle: 200 + 30e3 * lift(angle)
    )


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    records = small()
    for name, write in WRITERS.items():
        write(folder / name, records)
    return folder


def one_sentence(text):
    return (
        "\n" not in text
        and 10 < len(text) < 710
        and "Traceback" not in text
        and not text.startswith("raised")
    )


def test_damaged_recordings_of_every_form_are_read_or_refused(files):
    command = [sys.executable, str(ROOT / "tests" / "rig_forks.py"), str(files), str(COUNT), "7"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)
    assert set(found) == set(WRITERS)
    for name, outcomes in found.items():
        assert outcomes[0][1].startswith("read"), (name, outcomes[0])
        for what, outcome in outcomes:
            assert outcome.startswith(("read", "ended")) or one_sentence(outcome), (
                name,
                what,
                outcome,
            )
        cut = [outcome for what, outcome in outcomes if what.startswith("cut")]
        assert (
            not cut
            or name.endswith(("csv", "mf4", "tdms"))
            or all(not one.startswith("read") for one in cut)
        ), (name, outcomes)


@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(st.binary(max_size=400))
def test_any_bytes_as_text(tmp_path, content):
    read_any(tmp_path, content)


NUMBERS = st.one_of(
    st.floats(width=32).map(repr),
    st.integers(-400, 400).map(str),
    st.sampled_from(["1,5", ".", "-", "nan", "1e999"]),
)
LINES = st.lists(
    st.lists(NUMBERS, min_size=1, max_size=4).map(";".join) | st.text(max_size=12), max_size=90
).map("\n".join)


@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(LINES)
def test_any_lines(tmp_path, text):
    read_any(tmp_path, text.encode("utf-8", "surrogatepass"))


def read_any(folder, content):
    path = folder / "any"
    path.write_bytes(content)
    if any(
        registry.find("rig_formats", word).isolated
        and registry.find("rig_formats", word).recognise(content, "any")
        for word in registry.names("rig_formats")
    ):
        return
    try:
        found = read_recording(path)
        cycles_in(
            found,
            "any",
            RigAnswers(
                angle_of="cam",
                sampling_rate="1 kHz",
                channels={"strain": found.names[0]},
                encoder=found.names[-1],
            ),
        )
    except InputError as error:
        assert one_sentence(str(error))


def test_a_module_beside_the_recording_is_not_run(tmp_path, monkeypatch, files):
    """Whoever reads a recording in a stranger's folder runs nothing that lies there."""
    for name in ("h5py", "json", "nptdms", "numpy"):
        (tmp_path / f"{name}.py").write_text(
            f"open(r'{tmp_path / 'ran'}', 'w').close()\nraise SystemExit('ran')\n"
        )
    (tmp_path / "rig.tdms").write_bytes((files / "rig.tdms").read_bytes())
    monkeypatch.chdir(tmp_path)
    assert len(read_recording(Path("rig.tdms")).channels) == 5
    assert not (tmp_path / "ran").exists()


def test_other_kinds_of_files_are_refused(tmp_path):
    for content, words in (
        (b"", "is empty"),
        (b"  \n", "is empty"),
        (b"\x00\x01\x02", "is none of MDF, TDMS"),
        (b"hello", "no row of numbers"),
    ):
        (tmp_path / "it").write_bytes(content)
        with pytest.raises(InputError, match=words):
            read_recording(tmp_path / "it")
    for path, words in ((tmp_path, "no regular file"), (tmp_path / "none", "cannot be read")):
        with pytest.raises(InputError, match=words):
            read_recording(path)


def test_links_and_objects_of_hdf5_are_left_alone(tmp_path):
    import h5py

    secret = tmp_path / "secret.h5"
    with h5py.File(secret, "w") as file:
        file["data"] = np.arange(100.0)
    raw = tmp_path / "secret.bin"
    raw.write_bytes(np.arange(100.0).tobytes())
    with h5py.File(tmp_path / "it.h5", "w") as file:
        file["own"] = np.arange(80.0)
        file["link"] = h5py.ExternalLink(str(secret), "data")
        file["soft"] = h5py.SoftLink("/own")
        file.create_dataset("outside", (100,), "f8", external=[(str(raw), 0, 800)])
        layout = h5py.VirtualLayout((100,), "f8")
        layout[:] = h5py.VirtualSource(str(secret), "data", (100,))
        file.create_virtual_dataset("virtual", layout)
        file["words"] = np.array([b"a", b"b"] * 40, dtype=object).astype("S1")
    found = read_recording(tmp_path / "it.h5")
    assert found.names == ("own",)
    assert sum("no other file is opened" in note for note in found.notes) == 4


def test_an_array_that_claims_more_than_it_holds_is_refused(tmp_path):
    import h5py

    with h5py.File(tmp_path / "it.h5", "w") as file:
        file.create_dataset("huge", (10**12,), "f8", chunks=(1000,))
    with pytest.raises(InputError, match=r"'huge' claims 8e\+12 bytes and holds 0"):
        read_recording(tmp_path / "it.h5")


def test_a_compressed_mat_whose_numbers_are_not_those_of_its_checksum_is_refused(tmp_path):
    """The last four bytes of an element's stream are the checksum of what it holds (RFC 1950)."""
    from scipy import io

    path = tmp_path / "it.mat"
    io.savemat(path, {"data": np.arange(80.0)}, do_compression=True)
    assert read_recording(path).names == ("data",)
    content = bytearray(path.read_bytes())
    content[-1] ^= 1
    path.write_bytes(bytes(content))
    with pytest.raises(InputError, match="damaged"):
        read_recording(path)


def test_mat_objects_and_structures_are_left_alone(tmp_path):
    from scipy import io

    held = {
        "data": np.arange(80.0),
        "struct": {"a": np.arange(9.0)},
        "cell": np.array([1, "x"], dtype=object),
    }
    io.savemat(tmp_path / "it.mat", held)
    found = read_recording(tmp_path / "it.mat")
    assert found.names == ("data",)
    assert len(found.notes) == 2 and all("no array of numbers" in note for note in found.notes)


@pytest.mark.parametrize("version", ["3.30", "4.10"])
def test_a_formula_of_mdf_is_not_evaluated(tmp_path, version):
    from asammdf import MDF, Signal

    times = np.arange(100) * 1e-3
    formula = {"formula": "__import__('os').system('touch ran') + X"}
    signals = [
        Signal(np.arange(100, dtype=np.int16), times, "N", "by formula", conversion=formula),
        Signal(np.arange(100, dtype=np.int16), times, "N", "linear", conversion={"a": 0.5, "b": 3.0}),
        Signal(np.arange(100, dtype=np.int16), times, "N", "words", conversion={"val_0": 0, "text_0": b"zero", "default": b"?"}),
        Signal(np.arange(100, dtype=np.int16), times, "N", "table",
               conversion={"raw_0": 0.0, "phys_0": 0.0, "raw_1": 99.0, "phys_1": 198.0, "interpolation": 1}),
    ]  # fmt: skip
    with MDF(version=version) as file:
        file.append(signals)
        if version > "4":
            file.attach(b"import os", file_name="run.py", embedded=True)
        path = file.save(tmp_path / "it.mf4")
    found = read_recording(Path(path))
    assert sum("is left out: its conversion is" in note for note in found.notes) == 2
    with MDF(path) as file:
        for channel in found.channels:  # the library's own conversion is the oracle
            np.testing.assert_allclose(channel.values, file.get(channel.name).samples)
    values = {channel.name: channel.values for channel in found.channels}
    np.testing.assert_array_equal(values["linear"], 0.5 * np.arange(100) + 3)
    np.testing.assert_allclose(values["table"], 2.0 * np.arange(100))
    assert set(values) == {"linear", "table"} and not list(tmp_path.glob("**/ran"))


@pytest.mark.parametrize(
    ("form", "library"), [("mdf", "asammdf"), ("tdms", "nptdms"), ("uff58", "pyuff")]
)
def test_a_library_that_is_not_installed_is_named(form, library, monkeypatch, files, tmp_path):
    monkeypatch.setitem(sys.modules, library, None)
    name = {"mdf": "rig.mf4", "tdms": "rig.tdms", "uff58": "rig.uff"}[form]
    reader: RigFormat = registry.find("rig_formats", form)
    with pytest.raises(
        InputError, match=r"install the extra 'measure' \(pip install 'valvetrain\[measure\]'\)"
    ):
        reader.read(files / name, name)


def test_pieces_of_a_file_and_of_the_work_move_no_bit(tmp_path, monkeypatch):
    """Segments of TDMS, and how many angles are filtered at once."""
    from sample_rig import write_tdms

    from valvetrain.rig import cutting as angle_grid

    records = small()
    reader: RigFormat = registry.find("rig_formats", "tdms")
    answers = RigAnswers(angle_of="crank", encoder="Crank angle")
    found = []
    for segments, at_once in ((1, 2_000_000), (7, 2_000_000), (1, 5_000)):
        monkeypatch.setattr(angle_grid, "_AT_ONCE", at_once)
        write_tdms(tmp_path / "rig.tdms", records, segments)
        found.append(cycles_in(reader.read(tmp_path / "rig.tdms", "rig"), "rig", answers))
    for other in found[1:]:
        for one, two in zip(found[0].cycles, other.cycles, strict=True):
            np.testing.assert_array_equal(one.values, two.values)


def test_every_form_says_the_same(files):
    """One recording in eight clothes: the same channels, units and cycles."""
    true = small()
    for name in WRITERS:
        path = files / name
        reader: RigFormat = form_of(path, name)
        found = read_recording(path) if name == "rig.tdms" else reader.read(path, name)
        assert isinstance(found, Recording) and found.synthetic
        channels = {one.name.replace("_", " "): one for one in found.channels}
        assert set(channels) == {
            "Spring force",
            "Valve lift",
            "Crank wheel",
            "Cam pulse",
            "Crank angle",
        }
        assert channels["Spring force"].unit == "kN" and channels["Valve lift"].unit == "mm"
        np.testing.assert_allclose(
            channels["Spring force"].values, 1e-3 * true.force, atol=7e-5
        )  # 16 bit of MDF
        np.testing.assert_allclose(channels["Valve lift"].values, 1e3 * true.lift, atol=1e-6)
        one = channels["Valve lift"]
        times = (
            one.times
            if one.times is not None
            else one.start + one.step * np.arange(len(one.values))
        )
        np.testing.assert_allclose(times, true.times, atol=1e-7)


@pytest.mark.parametrize("version", ["3.30", "4.10"])
def test_times_of_mdf_by_formula_are_not_evaluated(tmp_path, monkeypatch, version):
    """asammdf converts the times of a group whenever they are asked for, by numexpr where the file
    holds a formula.
    """
    from asammdf import MDF, Signal
    from asammdf.blocks import v2_v3_blocks, v4_blocks

    with MDF(version=version) as file:
        file.append([Signal(np.arange(100.0), np.arange(100) * 1e-3, "N", "force")])
        source = Signal(
            np.arange(3.0), np.arange(3.0), "N", "other", conversion={"formula": "X + 1"}
        )
        file.append([source])
        file.groups[0].channels[0].conversion = file.groups[1].channels[1].conversion
        path = file.save(tmp_path / "it.mf4")

    def evaluate(*given, **more):
        raise AssertionError("a formula was evaluated")

    for module in (v2_v3_blocks, v4_blocks):
        monkeypatch.setattr(module, "evaluate", evaluate)
    reader: RigFormat = registry.find("rig_formats", "mdf")
    found = reader.read(Path(path), "it")
    assert not found.channels and sum("formula" in note for note in found.notes) == 2


def test_a_file_beyond_all_bounds_is_not_opened(tmp_path):
    for name, head in (("it.tdms", b"TDSm"), ("it.h5", b"\x89HDF\r\n\x1a\n"), ("it.txt", b"1 2\n")):
        with (tmp_path / name).open("wb") as stream:
            stream.write(head)
            stream.truncate(5_000_000_000)  # a hole, no bytes
        with pytest.raises(InputError, match="is larger than 4 GB; cut the recording"):
            read_recording(tmp_path / name)
