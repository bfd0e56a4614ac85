"""The script of the moving picture as one text: three.js (MIT, see static/three.LICENSE.txt) and
motion.js, no module, no network.
"""

from __future__ import annotations

import re
from functools import cache
from importlib import resources

#: The one list of names that the module of three.js ends with.
_EXPORT = re.compile(r"export\s*\{([^{}]*)\}\s*;?\s*$")
#: What motion.js takes of three.js.
USED = (
    "AmbientLight", "BufferAttribute", "BufferGeometry", "DirectionalLight", "DoubleSide", "DynamicDrawUsage", "ExtrudeGeometry", "Group",
    "HemisphereLight", "LatheGeometry", "Mesh", "MeshLambertMaterial", "OrthographicCamera", "Scene", "Shape", "Vector2", "Vector3",
    "WebGLRenderer",
)  # fmt: skip


@cache
def motion_script() -> str:
    """Text of a classic script that sets ``valvetrainMotion.mount(element, data)``; safe inside a
    script element.

    three.js comes as a module, which an inline script cannot import by name under a strict policy:
    it is put into a function and the names
    that are used are handed on.
    """
    source = _static("three.module.min.js")
    found = _EXPORT.search(source)
    if found is None:
        raise RuntimeError(
            "three.module.min.js does not end with its list of names; vendor an unchanged file"
        )
    inner = dict(_name(entry) for entry in found[1].split(","))
    names = ",".join(f"{name}:{inner[name]}" for name in USED)
    library = f"{source[: found.start()]}\nreturn {{{names}}};"
    text = f'(function(){{"use strict";\nconst THREE=(function(){{{library}\n}})();\n{_static("motion.js")}\n}})();'
    return text.replace("</script", "<\\/script")


def _name(entry: str) -> tuple[str, str]:
    """Public and inner name of ``inner as Public``."""
    inner, _, public = entry.strip().partition(" as ")
    return (public or inner).strip(), inner.strip()


def _static(name: str) -> str:
    return resources.files("valvetrain.report").joinpath("static", name).read_text(encoding="utf-8")
