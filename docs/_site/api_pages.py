"""The pages of the API: one per folder of the package, with the public names that it holds, from their docstrings."""

from __future__ import annotations

import importlib
import inspect
from pathlib import Path

from docutils import nodes
from generated import heading, keep

import valvetrain
from valvetrain.lazy import names_of_stub

#: Folder -> heading of its page, in the order of reading: what one begins with first.
FOLDERS = {
    "api": "Cases, springs and trains as objects",
    "runs": "Runs",
    "parameters": "Springs, materials and cases",
    "springs": "Spring models",
    "solution": "Results",
    "explore": "Studies, searches and identification",
    "compare_test": "Models against tests",
    "spring_card": "Springs from cards and testers",
    "lift": "Measured lifts",
    "rig": "Recordings of test rigs",
    "film": "Films of a spring",
    "scan": "Springs from scans",
    "measured": "Measured data",
    "findings": "Findings and their rules",
    "views": "Tables, figures and pages",
    "quantities": "Quantities of results",
    "system": "The problem that is solved",
    "cam": "Lift laws",
    "contact": "Contact laws",
    "cosserat": "The geometrically exact rod",
    "": "Errors and citations",
}
#: A name that more programs of the gallery use is not illustrated by them.
MAX_SHOWN = 8
INTRODUCTION = """All public names, a page per folder of the package: those of ``import valvetrain as vt`` (:doc:`../python` has them on one page) and
those that a folder has besides (``vt.springs.MultiMassSpring``). Arguments stand singly, with unit and shape.
Numbers without a unit are SI: m, N, s, kg, rad, rad/s, Pa. Wherever a dimension is due, a text with a unit such as ``"3000 rpm"`` or a
quantity of the package pint is as good. What cannot exist is refused by :class:`valvetrain.InputError`, one sentence with the remedy.

"""


def public_homes() -> dict[str, str]:
    """Public dotted name -> module that holds the object: top-level names, then those of each folder."""
    package = Path(valvetrain.__file__)
    found = {
        f"valvetrain.{name}": home
        for name, home in names_of_stub("valvetrain", str(package)).items()
        if home != f"valvetrain.{name}"
    }
    for stub in sorted(package.parent.glob("*/__init__.pyi")):
        folder = f"valvetrain.{stub.parent.name}"
        found |= {
            f"{folder}.{name}": home for name, home in names_of_stub(folder, str(stub)).items()
        }
    return found


HOMES = public_homes()
#: Name without folder -> public dotted name.
PUBLIC = {path.rpartition(".")[2]: path for path in HOMES}


def names_by_folder() -> dict[str, list[str]]:
    """Public dotted names by folder of the package, those of its ``api`` first, then top-level ones."""
    found: dict[str, list[str]] = {}
    for path, home in HOMES.items():
        folder, dot, _ = home.removeprefix("valvetrain.").partition(".")
        found.setdefault(folder if dot else "", []).append(path)
    return {
        folder: sorted(paths, key=lambda path: HOMES[path] != f"valvetrain.{folder}.api")
        for folder, paths in found.items()
    }


def object_of(path: str) -> object:
    """The object of a public dotted name."""
    module, _, name = path.rpartition(".")
    return getattr(importlib.import_module(module), name)


def first_line(name: str) -> str:
    """What a name is, in one line."""
    return " ".join(inspect.getdoc(object_of(name)).split("\n\n")[0].split())


def in_the_gallery(name: str, used: Path) -> str:
    """Pictures of the programs that use a name, where there are some and not most of them."""
    file = used / f"{name}.examples"
    count = (
        file.read_text(encoding="utf-8").count("sphx-glr-thumbcontainer") if file.is_file() else 0
    )
    return (
        f".. rubric:: In the gallery\n\n.. minigallery:: {name}\n\n"
        if 0 < count <= MAX_SHOWN
        else ""
    )


def entry(name: str, used: Path) -> str:
    """The full text of one name."""
    thing = object_of(name)
    kind = (
        "autofunction"
        if inspect.isroutine(thing)
        else "autoexception"
        if issubclass(thing, Exception)
        else "autoclass"
    )
    members = "" if kind == "autofunction" else "   :members:\n"
    return (
        heading(name.removeprefix("valvetrain."), "-")
        + f".. {kind}:: {name}\n{members}\n"
        + in_the_gallery(name, used)
    )


def page(folder: str, names: list[str], used: Path) -> str:
    """One page: what the folder is, its names with a line each, then each in full."""
    module = importlib.import_module(f"valvetrain.{folder}" if folder else "valvetrain")
    told = (
        f"{inspect.getdoc(module) or ''}\n\nFolder ``src/valvetrain/{folder}``.\n\n"
        if folder
        else ""
    )
    rows = "".join(f"   * - :obj:`~{name}`\n     - {first_line(name)}\n" for name in names)
    listed = f".. list-table::\n   :widths: 25 75\n   :class: api-names\n\n{rows}\n"
    return (
        heading(FOLDERS[folder], "=") + told + listed + "".join(entry(name, used) for name in names)
    )


def pages(used: Path) -> dict[str, str]:
    """File name -> text of all pages; ``used``: folder in which the gallery says who uses what."""
    found = names_by_folder()
    assert set(found) == set(FOLDERS), (
        f"folders with public names and headings of pages differ: {set(found) ^ set(FOLDERS)}"
    )
    written = {f"{folder or 'errors'}.rst": page(folder, found[folder], used) for folder in FOLDERS}
    tree = ".. toctree::\n   :maxdepth: 1\n\n" + "".join(
        f"   {name.removesuffix('.rst')}\n" for name in written
    )
    return {"index.rst": heading("API", "=") + INTRODUCTION + tree, **written}


def write(app) -> None:
    """Write the pages before the sources are read."""
    docs = Path(app.srcdir)
    keep(docs / "api", pages(docs / "gallery" / "used"))


def resolve(app, env, node, contnode):
    """A name written with the module that holds it, or with the letters ``vt.``, leads to the public name.

    Names of other packages, and of ours that are not public but exist, are shown without a link; one that does not exist is a warning.
    """
    if node.get("refdomain") != "py":
        return None
    target = node["reftarget"]
    public = public_name(target)
    if public is not None and public != target:
        place = env.domains.python_domain.objects.get(public)
        if place:
            link = app.builder.get_relative_uri(node["refdoc"], place.docname) + f"#{place.node_id}"
            return nodes.reference("", "", contnode, refuri=link, internal=True)
    elsewhere = ":" in target or (
        "." in target and target.partition(".")[0] not in ("valvetrain", "vt")
    )
    if elsewhere or exists(target):
        return contnode
    return None


def public_name(target: str) -> str | None:
    """``valvetrain.Name`` or ``valvetrain.Name.member`` of a dotted name of any module of the package; None where it has none."""
    parts = target.removeprefix("vt.").removeprefix("valvetrain.").split(".")
    for place, part in enumerate(parts):
        if part in PUBLIC and (place == 0 or held(".".join(parts[:place]), part)):
            return ".".join([PUBLIC[part], *parts[place + 1 :]])
    return None


def held(module: str, name: str) -> bool:
    """Whether a module of the package has the object of a public name under that name."""
    try:
        module_of_that_name = importlib.import_module(f"valvetrain.{module}")
        return getattr(module_of_that_name, name, None) is object_of(PUBLIC[name])
    except ImportError:
        return False


def exists(target: str) -> bool:
    """Whether a dotted name of the package, public or not, is there."""
    if "." not in target:
        return any(hasattr(importlib.import_module(home), target) for home in set(HOMES.values()))
    parts = target.split(".")
    for split in range(len(parts), 0, -1):
        try:
            thing = importlib.import_module(".".join(parts[:split]))
        except ImportError:
            continue
        for part in parts[split:]:
            if not hasattr(thing, part):
                return False
            thing = getattr(thing, part)
        return True
    return False


def setup(app):
    """Write the pages of a build and resolve its names."""
    app.connect("builder-inited", write)
    app.connect("missing-reference", resolve)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
