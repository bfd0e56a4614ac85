"""A second run into a folder removes what the first one wrote there, and nothing of anybody else's."""

from __future__ import annotations

from valvetrain.views.files import LIST, remove_earlier


def write(folder, *names):
    for name in names:
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(name)
    return [folder / name for name in names]


def test_only_untouched_files_of_the_last_run_go(tmp_path):
    write(tmp_path, "mine-5000rpm.csv", "notes.txt")
    remove_earlier(
        tmp_path,
        "report",
        write(tmp_path, "rod-4000rpm.nc", "rod-4000rpm.csv", "summary.csv", "figures/a.svg"),
    )
    (tmp_path / "rod-4000rpm.csv").write_text("the user's own marks")
    removed = remove_earlier(tmp_path, "report", write(tmp_path, "rod-4200rpm.nc", "summary.csv"))
    assert {path.name for path in removed} == {"rod-4000rpm.nc", "a.svg"}
    assert {path.name for path in tmp_path.iterdir() if path.is_file()} == {
        "mine-5000rpm.csv",
        "notes.txt",
        "rod-4000rpm.csv",
        "rod-4200rpm.nc",
        "summary.csv",
        LIST,
    }


def test_another_kind_of_run_keeps_its_files(tmp_path):
    remove_earlier(tmp_path, "report", write(tmp_path, "a.csv"))
    assert remove_earlier(tmp_path, "sweep", write(tmp_path, "b.csv")) == ()
    assert (tmp_path / "a.csv").exists()


def test_a_forged_or_broken_list_removes_nothing_outside(tmp_path):
    inside = tmp_path / "results"
    inside.mkdir()
    (outside,) = write(tmp_path, "outside.csv")
    remove_earlier(tmp_path, "report", [outside])
    text = (tmp_path / LIST).read_text().replace("outside.csv", "../outside.csv")
    (inside / LIST).write_text(text)
    assert remove_earlier(inside, "report", []) == () and outside.exists()
    (inside / LIST).write_text("[]")
    assert remove_earlier(inside, "report", []) == ()
