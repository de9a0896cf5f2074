"""A sweep brought to a Cartesian grid, as programs need it that know no fans."""

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
class _Places:
    """Between which samples of an axis points lie: lower + share, with lower + 1 inside the axis too."""

    lower: np.ndarray  # int
    share: np.ndarray  # float32, 0 to 1
    inside: np.ndarray  # bool

    @staticmethod
    def of(places, samples):
        """`places`: in samples, fractional, of any shape; `samples`: how many the axis has."""
        lower = np.clip(np.floor(places), 0, samples - 2).astype(np.intp)
        inside = (places >= 0) & (places <= samples - 1)
        return _Places(lower, (places - lower).astype(np.float32), inside)


def scan_converted(fan, sweep, spacing_mm):
    """The Grid that just holds the sweep, trilinear in column, row and angle; 0 outside the fan."""
    x_mm, y_mm, z_mm = _axes_mm(fan, sweep, spacing_mm)
    column = _Places.of(x_mm / fan.pixel_width_mm + fan.face_column, fan.columns)
    stretched = _resampled_columns(sweep.frames, column)
    levels = np.zeros((len(z_mm), len(y_mm), len(x_mm)), np.uint8)
    for plane, at_mm in zip(levels, z_mm):
        _fill_plane(plane, fan, sweep, stretched, y_mm, at_mm)
    levels[:, :, ~column.inside] = 0
    return Grid(spacing_mm, (x_mm[0], y_mm[0], z_mm[0]), levels)


def _axes_mm(fan, sweep, spacing_mm):
    """The grid's places along x, y and z, symmetric about the middle of what the fan covers."""
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
    """(frames, rows, x), float32. Once a sweep: columns lie alike in every frame."""
    left = frames[:, :, column.lower].astype(np.float32)
    return left + column.share * (frames[:, :, column.lower + 1] - left)


def _fill_plane(plane, fan, sweep, stretched, y_mm, z_mm):
    """One plane of equal z, (y, x). phi = atan2(z, y + Rm), rho = hypot(z, y + Rm) - Rm."""
    from_axis_mm = y_mm + fan.motor_radius_mm
    angle_rad = np.arctan2(z_mm, from_axis_mm)
    depth_mm = np.hypot(z_mm, from_axis_mm) - fan.motor_radius_mm
    row = _Places.of(depth_mm / fan.pixel_height_mm + fan.face_row, fan.rows)
    # Angles need not be evenly spaced.
    count = len(sweep.angles_rad)
    frame = _Places.of(np.interp(angle_rad, sweep.angles_rad, np.arange(count), left=-1, right=count), count)
    inside = row.inside & frame.inside & (depth_mm >= 0)
    near, far = [
        _mixed(stretched[at, row.lower[inside]], stretched[at, row.lower[inside] + 1], row.share[inside])
        for at in (frame.lower[inside], frame.lower[inside] + 1)
    ]
    plane[inside] = _mixed(near, far, frame.share[inside]) + 0.5


def _mixed(first, second, share):
    return first + share[:, None] * (second - first)
