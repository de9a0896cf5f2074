# SPDX-License-Identifier: Apache-2.0
"""Reads a recording of a swept probe (.igs.mha, as phantom_recording writes it): geometry, angles and frames."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Sweep:
    """One volume. Its frames are in ascending order of angle."""

    angles_rad: np.ndarray  # (frames,), float64
    frames: np.ndarray  # (frames, rows, columns), uint8; row 0 nearest the probe, columns towards +x


@dataclass(frozen=True)
class Fan:
    """Geometry of a Cartesian frame; members as of FanGeometry in proto/model/fan_geometry.hpp."""

    columns: int
    rows: int
    pixel_width_mm: float
    pixel_height_mm: float
    face_column: float
    face_row: float
    motor_radius_mm: float

    @property
    def depth_mm(self):
        """In-plane depth of the last row."""
        return (self.rows - 1 - self.face_row) * self.pixel_height_mm

    @property
    def left_mm(self):
        return -self.face_column * self.pixel_width_mm

    @property
    def right_mm(self):
        return (self.columns - 1 - self.face_column) * self.pixel_width_mm


def read_recording(path):
    """Returns the Fan and a list of Sweeps, in order of VolumeIndex, of an uncompressed 8-bit recording."""
    with open(path, "rb") as file:
        fields = _header(file)
        columns, rows, count = (int(number) for number in fields["DimSize"].split())
        pixels = np.frombuffer(file.read(), np.uint8).reshape(count, rows, columns)
    fan = Fan(
        columns=columns,
        rows=rows,
        **{
            name: float(fields[f"Fanlight{name.title().replace('_', '')}"])
            for name in ("pixel_width_mm", "pixel_height_mm", "face_column", "face_row", "motor_radius_mm")
        },
    )
    angles_rad = np.radians([float(fields[f"Seq_Frame{i:04}_MotorAngleDeg"]) for i in range(count)])
    volumes = np.array([int(fields[f"Seq_Frame{i:04}_VolumeIndex"]) for i in range(count)])
    members = [np.flatnonzero(volumes == volume) for volume in np.unique(volumes)]
    return fan, [_sweep(pixels, angles_rad, frames) for frames in members]


def _header(file):
    """Reads the lines `name = value`; the file position is then at the first pixel. Returns values by name."""
    fields = {}
    while fields.get("ElementDataFile") != "LOCAL":
        name, _, value = file.readline().decode("ascii").partition(" = ")
        fields[name] = value.strip()
    return fields


def _sweep(pixels, angles_rad, members):
    ascending = members[np.argsort(angles_rad[members])]
    return Sweep(angles_rad=angles_rad[ascending], frames=pixels[ascending])
