"""The tree of the site is read from the links of its pages: a page that lists others becomes their parent.

The pages stay plain Markdown that a code host shows as well, and a list for readers cannot differ from the navigation.
"""

from __future__ import annotations

import re
from pathlib import Path, PurePosixPath

from sphinx import addnodes

#: Page -> pages whose place in the tree is below it: those it links to, in the order of the links.
PARENTS = (
    "user-guide",
    "reference",
    "evidence",
    "development",
    "decisions/README",
    "how-to/README",
    "theory/README",
)
#: File of the repository -> its page of the site.
ELSEWHERE = {"CHANGELOG": "changes", "CONTRIBUTING": "contributing"}
#: Page -> pages below it that its list leaves out: written by the build.
ALSO = {"reference": ("commands.rst",)}
#: Pages of the first page, whoever else links to them.
FIRST = ("tutorial.md", "index.md")
LINK = re.compile(r"\]\(([\w./-]+?\.md)(?:#[\w-]*)?\)")


def children(page: str, text: str, docs: Path) -> list[str]:
    """Pages below a page, relative to its folder: those it links to, each once, of a page in a folder those of that folder."""
    found, reach = [], docs / PurePosixPath(page).parent
    for target in dict.fromkeys(LINK.findall(text)):
        path = (reach / target).resolve()
        if (
            path.is_relative_to(reach)
            and path.is_file()
            and path != docs / f"{page}.md"
            and target not in FIRST
        ):
            found.append(target.removesuffix(".md"))
    more = (name for name in ALSO.get(page, ()) if name.endswith(".rst") or (docs / name).is_file())
    return list(dict.fromkeys([*found, *(name.partition(".")[0] for name in more)]))


def extend(app, docname: str, content: list[str]) -> None:
    """Put the tree under a page that lists others."""
    if docname in PARENTS:
        listed = "\n".join(children(docname, content[0], Path(app.srcdir)))
        content[0] += f"\n\n```{{toctree}}\n:hidden:\n\n{listed}\n```\n"


def lead(app, doctree) -> None:
    """Links that leave the site: to the page here that shows that file, or, to another file of the repository, words without a link.

    A link to what is no file of the repository stays as it is, and is a warning of the build.
    """
    docs = Path(app.srcdir)
    for node in list(doctree.findall(addnodes.pending_xref)):
        if node.get("reftype") != "myst":
            continue
        target = node["reftarget"]
        name = PurePosixPath(target).name
        page = ELSEWHERE.get(name.removesuffix(".md"))
        here = (docs / app.env.docname).parent
        places = [
            place / (target.lstrip("/") + ending)
            for place in (here, docs, docs.parent)
            for ending in ("", ".md")
        ]
        if page is not None and not (
            node.get("refdomain") == "doc" and target in app.env.found_docs
        ):
            node["refdomain"], node["reftarget"], node["reftargetid"] = "doc", page, None
        elif node.get("refdomain") != "doc" and any(place.exists() for place in places):
            node.replace_self(node.children)


def setup(app):
    """Read the links when a page is read, and resolve those that leave the site."""
    app.connect("source-read", extend)
    app.connect("doctree-read", lead)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
