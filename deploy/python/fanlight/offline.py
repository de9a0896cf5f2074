# SPDX-License-Identifier: Apache-2.0
"""render(): an array or a recording to a picture, by the program `fanlight`."""

from __future__ import annotations

import json
import os
import pathlib
import shutil
import subprocess
import tempfile
from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from . import arrays, scene as scenes
from .errors import ProgramMissing, RenderFailed, TimedOut, ValueNotAllowed
from .geometry import Fan, Grid
from .picture import Picture, View

_WRONG_OPTION = 2  # exit code
Source = Union[str, "os.PathLike[str]", NDArray[Any]]


def render(
    source: Source,
    geometry: Optional[Union[Fan, Grid, str, "os.PathLike[str]"]] = None,
    *,
    volume: Optional[int] = None,
    size: tuple[int, int] = (512, 512),
    preset: Optional[str] = None,
    look: Optional[str] = None,
    auto: Optional[bool] = None,
    program: Optional[str] = None,
    timeout_s: Optional[float] = 300,
    **scene: Any,
) -> Picture:
    """Render a volume, and wait for the picture.

    source: a recording's path or any other INPUT of `fanlight render`, such as "phantom:"; or an array of uint8, uint16
        or int16 of shape (frames, rows, columns), of a Grid (planes, rows, columns).
    geometry: of an array a Fan or a Grid; of a recording the path of a geometry file, where it has none of its own.
    volume: its number in the recording; None: the first that can be rendered.
    size: width and height of the picture in pixels.
    preset, look: names, as of --preset and --look.
    auto: whether camera, rays, detector and light are chosen for the surface that is found; None: where the scene sets
        none of the first three.
    program: the program; None: $FANLIGHT, or `fanlight` of the PATH.
    timeout_s: None waits without end.
    scene: groups of fields, camera={"yaw_deg": 20}, mode="slice". `fanlight render --help-all` lists them.

    Raises ProgramMissing, ValueNotAllowed for a field of the scene, RenderFailed with the sentence of the program,
    TimedOut; TypeError and ValueError for an array or a geometry that cannot be written.
    """
    with tempfile.TemporaryDirectory(prefix="fanlight-") as name:  # for this user alone: it may show a patient
        folder = pathlib.Path(name)
        arguments = _input(folder, source, geometry)
        arguments += ["--out", str(folder / "x.png"), "--depth", str(folder / "z.tif"), "--json"]
        arguments += ["--size", f"{size[0]}x{size[1]}"]
        for option, value in (("--volume", volume), ("--preset", preset), ("--look", look)):
            if value is not None:
                arguments += [option, str(value)]
        if auto is not None:
            arguments.append("--auto" if auto else "--no-auto")
        report = _run(program, ["render", *arguments, *scenes.options(scene)], list(scenes.flat(scene)), timeout_s)
        return _picture(folder, report)


def _input(folder: pathlib.Path, source: Source, geometry: Any) -> list[str]:
    if not isinstance(source, (str, os.PathLike)):
        if geometry is None:
            raise TypeError("an array has no geometry of its own, expected geometry=Fan(...) or Grid(...)")
        return arrays.write(folder, source, geometry)
    text = os.fspath(source)
    if isinstance(geometry, Fan):
        (folder / "geometry.toml").write_text(geometry.toml())
        return [text, "--geometry", str(folder / "geometry.toml")]
    if isinstance(geometry, Grid):
        raise TypeError("a Grid is for an array: a file has its spacing")
    return [text] if geometry is None else [text, "--geometry", os.fspath(geometry)]


def _run(
    program: Optional[str], arguments: list[str], fields: list[str], timeout_s: Optional[float]
) -> dict[str, Any]:
    """The report of the program. `fields`: names of the scene's fields among the arguments."""
    path = program or os.environ.get("FANLIGHT") or shutil.which("fanlight")
    if path is None:
        raise ProgramMissing("the program fanlight was not found, expected it in the PATH or its path in FANLIGHT")
    try:
        done = subprocess.run([path, *arguments], capture_output=True, text=True, timeout=timeout_s)
    except OSError as failure:
        raise ProgramMissing(f"{path} could not be started: {failure.strerror}") from failure
    except subprocess.TimeoutExpired as late:
        raise TimedOut(f"the program did not end within {timeout_s} s") from late
    if done.returncode != 0:
        sentence = done.stderr.strip().removeprefix("fanlight render: ") or f"{path} ended with {done.returncode}"
        if "fanlight-images" in sentence:
            raise ProgramMissing(sentence)
        named = [field for field in fields if field in sentence]
        if done.returncode == _WRONG_OPTION and named:
            raise ValueNotAllowed(sentence, named[0])
        raise RenderFailed(sentence, done.returncode)
    report: dict[str, Any] = json.loads(done.stdout)
    return report


def _picture(folder: pathlib.Path, report: dict[str, Any]) -> Picture:
    with Image.open(folder / "x.png") as image:
        rgb = np.asarray(image.convert("RGB"))
    with Image.open(folder / "z.tif") as image:
        depth = np.asarray(image, dtype=np.float32).copy()
    depth[depth < 0] = np.nan  # no surface
    depth.flags.writeable = False
    view = _view(report["view"])
    return Picture(
        rgb=rgb,
        depth_mm=depth,
        view=view,
        depth_view=view,
        volume_id=report["volume"],
        surface_share=report["surface_share"],
        uncertain_share=report["uncertain_share"],
        warnings=tuple(each["sentence"] for each in report["warnings"]),
        notes=tuple(report["notes"]),
        report=report,
    )


def _view(view: dict[str, Any]) -> View:
    matrix = np.eye(4)
    for column, name in enumerate(("right", "down", "forward", "origin_mm")):
        matrix[:3, column] = view[name]
    scalars = {name: view[name] for name in ("mm_per_pixel", "mm_per_pixel_per_mm", "middle_column", "middle_row")}
    return View(matrix=matrix, **scalars)
