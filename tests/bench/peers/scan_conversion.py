# SPDX-License-Identifier: Apache-2.0
"""Resamples a sweep to a Cartesian grid, for programs that do not support the fan geometry."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Grid:
    """A Cartesian volume in the transducer frame: x lateral, y into the body, z elevation, mm."""

    spacing_mm: float
    origin_mm: tuple  # x, y, z of the first voxel's centre
    levels: np.ndarray  # (z, y, x), uint8, C order: x runs fastest, as in vtkImageData

    @property
    def dimensions(self):
        """Voxels along x, y and z."""
        return self.levels.shape[::-1]


@dataclass(frozen=True)
class _Interpolation:
    """Linear interpolation along an axis: between the samples `lower` and `lower` + 1, both on the axis."""

    lower: np.ndarray  # int, index of a sample
    weight: np.ndarray  # float32, of sample `lower` + 1; 0 to 1 where `inside`
    inside: np.ndarray  # bool, whether the position lies on the axis

    @staticmethod
    def at(positions, sample_count):
        """`positions`: fractional sample indices, any shape; `sample_count`: length of the axis."""
        lower = np.clip(np.floor(positions), 0, sample_count - 2).astype(np.intp)
        inside = (positions >= 0) & (positions <= sample_count - 1)
        return _Interpolation(lower, (positions - lower).astype(np.float32), inside)


def scan_converted(fan, sweep, spacing_mm):
    """The smallest Grid that contains the sweep. Trilinear in column, row and angle; 0 outside the fan."""
    x_mm, y_mm, z_mm = _axes_mm(fan, sweep, spacing_mm)
    column = _Interpolation.at(x_mm / fan.pixel_width_mm + fan.face_column, fan.columns)
    resampled = _resampled_columns(sweep.frames, column)
    levels = np.zeros((len(z_mm), len(y_mm), len(x_mm)), np.uint8)
    for plane, plane_z_mm in zip(levels, z_mm):
        _fill_plane(plane, fan, sweep, resampled, y_mm, plane_z_mm)
    levels[:, :, ~column.inside] = 0
    return Grid(spacing_mm, (x_mm[0], y_mm[0], z_mm[0]), levels)


def _axes_mm(fan, sweep, spacing_mm):
    """Positions of the voxels along x, y and z, mm, symmetric about the centre of the fan's bounding box."""
    from_axis_mm = fan.motor_radius_mm + np.array([0.0, fan.depth_mm])[:, None]
    angles_rad = np.concatenate([sweep.angles_rad, [np.clip(0, *sweep.angles_rad[[0, -1]])]])
    y_mm = from_axis_mm * np.cos(angles_rad) - fan.motor_radius_mm
    z_mm = from_axis_mm * np.sin(angles_rad)
    bounds_mm = [(fan.left_mm, fan.right_mm), (y_mm.min(), y_mm.max()), (z_mm.min(), z_mm.max())]
    return [_axis_mm(lowest, highest, spacing_mm) for lowest, highest in bounds_mm]


def _axis_mm(lowest_mm, highest_mm, spacing_mm):
    steps = np.ceil((highest_mm - lowest_mm) / spacing_mm)
    return (lowest_mm + highest_mm) / 2 + spacing_mm * (np.arange(steps + 1) - steps / 2)


def _resampled_columns(frames, column):
    """The frames resampled along x: (frames, rows, x), float32. The columns are the same in every frame."""
    left = frames[:, :, column.lower].astype(np.float32)
    return left + column.weight * (frames[:, :, column.lower + 1] - left)


def _fill_plane(plane, fan, sweep, resampled, y_mm, z_mm):
    """Fills one plane of equal z, (y, x), in place. phi = atan2(z, y + Rm), rho = hypot(z, y + Rm) - Rm."""
    from_axis_mm = y_mm + fan.motor_radius_mm
    angle_rad = np.arctan2(z_mm, from_axis_mm)
    depth_mm = np.hypot(z_mm, from_axis_mm) - fan.motor_radius_mm
    row = _Interpolation.at(depth_mm / fan.pixel_height_mm + fan.face_row, fan.rows)
    # np.interp, because the angles may be unevenly spaced.
    count = len(sweep.angles_rad)
    frame = _Interpolation.at(
        np.interp(angle_rad, sweep.angles_rad, np.arange(count), left=-1, right=count), count
    )
    inside = row.inside & frame.inside & (depth_mm >= 0)
    near, far = [
        _interpolated(resampled[index, row.lower[inside]], resampled[index, row.lower[inside] + 1], row.weight[inside])
        for index in (frame.lower[inside], frame.lower[inside] + 1)
    ]
    plane[inside] = _interpolated(near, far, frame.weight[inside]) + 0.5


def _interpolated(first, second, weight):
    return first + weight[:, None] * (second - first)
