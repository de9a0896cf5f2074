# SPDX-License-Identifier: Apache-2.0
"""A picture with its depths and its place in space."""

from __future__ import annotations

import dataclasses
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image


@dataclasses.dataclass(frozen=True)
class View:
    """Where the pixels of a picture lie, in the transducer frame: x to the marked side, y into the body, z along the
    sweep, mm, from the centre of the probe's face.

    The point at depth d of pixel (column, row) is origin + d forward + (mm_per_pixel + d mm_per_pixel_per_mm)
    ((column - middle_column) right + (row - middle_row) down).
    """

    matrix: NDArray[np.float64]
    """4 x 4: the columns are right, down, forward and the origin."""
    mm_per_pixel: float
    """In the view plane."""
    mm_per_pixel_per_mm: float
    """0 in a parallel projection."""
    middle_column: float
    middle_row: float

    @property
    def right(self) -> NDArray[np.float64]:
        return self.matrix[:3, 0]

    @property
    def down(self) -> NDArray[np.float64]:
        return self.matrix[:3, 1]

    @property
    def forward(self) -> NDArray[np.float64]:
        return self.matrix[:3, 2]

    @property
    def origin_mm(self) -> NDArray[np.float64]:
        return self.matrix[:3, 3]

    def points_mm(self, depth_mm: NDArray[np.floating[Any]]) -> NDArray[np.float64]:
        """The points of a depth map of shape (height, width): (height, width, 3), NaN where there is no surface."""
        rows, columns = np.indices(depth_mm.shape, dtype=np.float64)
        depth = np.asarray(depth_mm, dtype=np.float64)[..., None]
        scale = self.mm_per_pixel + depth * self.mm_per_pixel_per_mm
        right = (columns - self.middle_column)[..., None] * self.right
        down = (rows - self.middle_row)[..., None] * self.down
        points: NDArray[np.float64] = self.origin_mm + depth * self.forward + scale * (right + down)
        return points


@dataclasses.dataclass(frozen=True)
class Picture:
    """A rendered picture. Arrays are read-only."""

    rgb: NDArray[np.uint8]
    """(height, width, 3), top row first, sRGB."""
    depth_mm: NDArray[np.float32] | None
    """(height, width): distance from the view plane along the view, NaN where there is no surface. None where it was
    not asked for. Its pixels lie as `depth_view` says."""
    view: View
    """Where the pixels of `rgb` lie."""
    depth_view: View
    """Where the pixels of `depth_mm` lie; the same, unless the server was asked for a smaller picture."""
    volume_id: int
    picture_id: int = 0
    scene_revision: int = 0
    """Of the scene that it shows."""
    private_view: bool = False
    """It shows this client's own view."""
    capture_time_ns: int = 0
    """Of the last frame of its volume, on the clock of the server."""
    age_s: float | None = None
    """From that time to its arrival; None where the clocks are not compared yet, or for a file."""
    state: str = ""
    """"live", "delayed", "not live", "replay", "frozen", "resting" or "waiting"; empty for a file."""
    origin: str = ""
    """Where the frames come from: "probe", "unknown", "simulated" or "recording"; empty for a file."""
    frames_missing: int = 0
    """Frames of the volume that were lost and are interpolated."""
    surface_share: float = 0
    """Of the pixels, those with a surface."""
    uncertain_share: float = 0
    """Of these, those whose surface is uncertain and dimmed."""
    warnings: tuple[str, ...] = ()
    """What looks wrong in the frames, a sentence each."""
    notes: tuple[str, ...] = ()
    """What is assumed of the source, a sentence each."""
    report: dict[str, Any] = dataclasses.field(default_factory=dict, repr=False)
    """Of render(): the report of the program; empty for a display."""

    @property
    def points_mm(self) -> NDArray[np.float64]:
        """The surface as points, (height, width, 3), NaN where there is none."""
        if self.depth_mm is None:
            raise ValueError("the picture has no depths, expected it to be asked for with depth=True")
        return self.depth_view.points_mm(self.depth_mm)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write `rgb` to a file, in the format of its ending."""
        Image.fromarray(self.rgb).save(os.fspath(path))

    def _repr_png_(self) -> bytes:
        """What a notebook shows."""
        import io

        file = io.BytesIO()
        Image.fromarray(self.rgb).save(file, "PNG")
        return file.getvalue()
