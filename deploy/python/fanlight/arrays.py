# SPDX-License-Identifier: Apache-2.0
"""An array as a recording that the program reads: a MetaImage, and a geometry file."""

from __future__ import annotations

import dataclasses
import pathlib
from typing import Any, Union

import numpy as np
from numpy.typing import NDArray

from .geometry import Fan, Grid

_ELEMENT_TYPES = {"u1": "MET_UCHAR", "u2": "MET_USHORT", "i2": "MET_SHORT"}
_USUAL_RATE_HZ = 30  # a single volume has no need of its times


def write(folder: pathlib.Path, array: NDArray[Any], geometry: Union[Fan, Grid]) -> list[str]:
    """Write the array into the folder; return the arguments for the program. TypeError and ValueError say what an
    array must be like."""
    array = _checked(array)
    if isinstance(geometry, Grid):
        _write_image(folder / "array.mha", array, tuple(reversed(geometry.spacing_mm)))
        return [str(folder / "array.mha")]
    if not isinstance(geometry, Fan):
        raise TypeError(f"geometry is {geometry!r}, expected a Fan or a Grid for an array")
    angles = geometry.angles_deg
    if angles is not None and len(angles) != len(array):
        raise ValueError(f"there are {len(angles)} angles_deg for {len(array)} frames, expected one for each")
    fields = _frame_fields(geometry, len(array))
    geometry = dataclasses.replace(geometry, angles_deg=None, frames_per_sweep=None, frames_per_second=None)
    (folder / "array.toml").write_text(geometry.toml())
    _write_image(folder / "array.igs.mha", array, (1, 1, 1), fields)
    return [str(folder / "array.igs.mha"), "--geometry", str(folder / "array.toml")]


def _frame_fields(geometry: Fan, frames: int) -> str:
    """What each frame is, in the words of PLUS."""
    lines = ["UltrasoundImageOrientation = MF", "UltrasoundImageType = BRIGHTNESS"]
    rate_hz = geometry.frames_per_second or _USUAL_RATE_HZ
    turns = geometry.angles_deg is not None and len(set(np.sign(np.diff(geometry.angles_deg)))) > 1
    # Where the angles turn back and no number of frames is given, the program divides the sweeps there.
    in_sweep = geometry.frames_per_sweep or (None if turns else frames)
    for frame in range(frames):
        name = f"Seq_Frame{frame:04d}_"
        lines += [f"{name}Timestamp = {frame / rate_hz:.9f}", f"{name}ImageStatus = OK"]
        if geometry.angles_deg is not None:
            lines.append(f"{name}MotorAngleDeg = {float(geometry.angles_deg[frame])!r}")
        if in_sweep:
            lines += [f"{name}VolumeIndex = {frame // in_sweep}", f"{name}FrameIndex = {frame % in_sweep}"]
    return "\n".join(lines) + "\n"


def _checked(array: NDArray[Any]) -> NDArray[Any]:
    array = np.asarray(array)
    if array.ndim != 3 or 0 in array.shape:
        raise ValueError(f"the array has the shape {array.shape}, expected (frames, rows, columns)")
    if array.dtype.str[1:] not in _ELEMENT_TYPES:
        raise TypeError(f"the array is of {array.dtype}, expected uint8, uint16 or int16 (log-compressed echoes)")
    return array.astype(array.dtype.newbyteorder("<"), copy=False)


def _write_image(path: pathlib.Path, array: NDArray[Any], spacing: tuple[float, ...], more: str = "") -> None:
    planes, rows, columns = array.shape
    header = (
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = False\n"
        f"DimSize = {columns} {rows} {planes}\nElementSpacing = {' '.join(repr(float(mm)) for mm in spacing)}\n{more}"
        f"ElementType = {_ELEMENT_TYPES[array.dtype.str[1:]]}\nElementDataFile = LOCAL\n"
    )
    with path.open("wb") as file:
        file.write(header.encode())
        for plane in array:  # never a second copy of the whole
            file.write(np.ascontiguousarray(plane).data)
