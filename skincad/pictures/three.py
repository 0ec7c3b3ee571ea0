"""The drawing library of `view.html`: three.js, which trimesh carries for its own viewer in a notebook."""

from __future__ import annotations

from skincad.base.errors import RefusedError

VIEWER_START = "var camera,controls,scene,renderer"  # so begins trimesh's own viewer, behind the libraries


def three_js() -> str:
    """Return three.js with its TrackballControls, a script that defines THREE; MIT, its notice in it.

    Raises RefusedError where the trimesh that is installed carries it no longer.
    """
    from trimesh import resources, util

    packed = util.decompress(resources.get_bytes("templates/viewer.zip"), file_type="zip")
    page = packed["viewer.html.template"].read().decode("utf-8")
    script = page.partition("<script>")[2].partition(VIEWER_START)
    if not script[1] or "TrackballControls" not in script[0]:
        raise RefusedError("this trimesh carries no three.js for view.html; install trimesh 5.2")
    return str(script[0])
