# SPDX-License-Identifier: Apache-2.0
"""Where the samples of an array lie: the frames of a swept probe, or a volume on a grid."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from typing import Literal


@dataclasses.dataclass(frozen=True, kw_only=True)
class Fan:
    """The frames of one sweep, or of several: an array of shape (frames, rows, columns).

    Rows go away from the probe, columns to its marked side. With `frame_kind` "convex-lines" or "linear-lines" a
    column is a scan line and a row a sample along it. Each frame has its angle about the sweep axis, which lies
    `motor_radius_mm` behind the face of the probe: give `angles_deg`, one for each frame, or `first_angle_deg` and
    `last_angle_deg`.

    The fields are the keys of a geometry file, which the user guide explains ("Recordings and their geometry"). What is
    None is not written.
    """

    motor_radius_mm: float
    pixel_height_mm: float
    pixel_width_mm: float | None = None
    frame_kind: Literal["cartesian", "linear-lines", "convex-lines"] = "cartesian"
    line_pitch_deg: float | None = None
    face_column: float
    face_row: float
    probe_radius_mm: float | None = None
    sector_half_angle_deg: float | None = None
    sector_reach_mm: float | None = None
    unscanned: Literal["detect", "zero", "none"] | None = None
    angles_deg: Sequence[float] | None = None
    first_angle_deg: float | None = None
    last_angle_deg: float | None = None
    frames_per_sweep: int | None = None
    sweep_order: Literal["one-way", "to-and-fro"] | None = None
    frames_per_second: float | None = None
    window_black: float | None = None
    window_white: float | None = None

    def toml(self) -> str:
        """The text of a geometry file. ValueError for a number that is not finite."""
        lines = []
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if value is not None:
                lines.append(f"{field.name} = {_toml_value(field.name, value)}")
        return "\n".join(lines) + "\n"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Grid:
    """A volume on a Cartesian grid: an array of shape (planes, rows, columns).

    Columns are taken as lateral and rows as the depth, row 0 at the face of the probe. `spacing_mm` is the distance of
    planes, rows and columns, in the order of the array's axes.
    """

    spacing_mm: tuple[float, float, float]

    def __post_init__(self) -> None:
        if len(self.spacing_mm) != 3 or not all(math.isfinite(mm) and mm > 0 for mm in self.spacing_mm):
            raise ValueError(f"spacing_mm is {self.spacing_mm}, expected three positive lengths")


def _toml_value(name: str, value: object) -> str:
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, int):
        return str(value)
    if isinstance(value, Iterable):  # an array of numpy is no Sequence
        return "[" + ", ".join(_toml_value(name, float(each)) for each in value) + "]"
    number = float(value)  # type: ignore[arg-type]
    if not math.isfinite(number):
        raise ValueError(f"{name} is {number}, expected a finite number")
    return repr(number)
