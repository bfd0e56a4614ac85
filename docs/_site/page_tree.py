"""The tree of the site is read from the links of its pages: a page that lists others becomes their parent.

The pages stay plain Markdown that a code host shows as well, and a list for readers cannot differ from the navigation.
"""

from __future__ import annotations

import re
from pathlib import Path, PurePosixPath

from docutils import nodes

#: Page -> pages whose place in the tree is below it: those it links to, in the order of the links.
PARENTS = ("user-guide", "reference", "evidence", "development", "decisions/README", "how-to/README", "theory/README")
#: File of the repository -> its page of the site.
ELSEWHERE = {"CHANGELOG.md": "changes", "CONTRIBUTING.md": "contributing", "README.md": "index"}
LINK = re.compile(r"\]\(([\w./-]+?\.md)(?:#[\w-]*)?\)")


def children(page: str, text: str, docs: Path) -> list[str]:
    """Pages that a page links to and that stand in ``docs``, relative to its folder, each once; not itself, no other parent's pages."""
    found = []
    for target in dict.fromkeys(LINK.findall(text)):
        path = (docs / PurePosixPath(page).parent / target).resolve()
        if path.is_relative_to(docs) and path.is_file() and path != docs / f"{page}.md":
            found.append(target.removesuffix(".md"))
    return found


def extend(app, docname: str, content: list[str]) -> None:
    """Put the tree under a page that lists others."""
    if docname in PARENTS:
        listed = "\n".join(children(docname, content[0], Path(app.srcdir)))
        more = "\ncommands" if docname == "reference" else ""
        content[0] += f"\n\n```{{toctree}}\n:hidden:\n\n{listed}{more}\n```\n"


def resolve(app, env, node, contnode):
    """A link from a page that stands outside of the site, or to a folder: to its page here, or shown without a link.

    What is no file of the repository stays a warning.
    """
    if node.get("reftype") != "myst":
        return None
    target = node["reftarget"].partition("#")[0]
    page = ELSEWHERE.get(PurePosixPath(target).name)
    if page is not None:
        return nodes.reference("", "", contnode, refuri=app.builder.get_relative_uri(node["refdoc"], page), internal=True)
    docs = Path(app.srcdir)
    places = ((docs / node["refdoc"]).parent / target, docs.parent / target)
    return contnode if any(place.exists() for place in places) else None


def setup(app):
    """Read the links when a page is read, and resolve those that leave the site."""
    app.connect("source-read", extend)
    app.connect("missing-reference", resolve)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
