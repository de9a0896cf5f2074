# SPDX-License-Identifier: Apache-2.0
"""Settings that VTK's two ray casters share."""

from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction
from vtkmodules.vtkRenderingCore import vtkColorTransferFunction, vtkVolume, vtkVolumeProperty

import shading

# Width of the opacity ramp, grey levels: a sample is clear at the level of the surface and opaque RAMP above it.
RAMP = 10


def ray_cast(mapper, image, level):
    """A vtkVolume that shows the shaded surface of a vtkImageData at a grey level.

    Casts one ray per pixel; the distance of samples is that of voxels.
    """
    spacing_mm = image.GetSpacing()[0]
    mapper.SetInputData(image)
    # With it on, VTK renders a picture coarser if the previous one was slow.
    mapper.AutoAdjustSampleDistancesOff()
    mapper.SetImageSampleDistance(1)
    mapper.SetSampleDistance(spacing_mm)
    volume = vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(_surface(spacing_mm, level))
    return volume


def _surface(spacing_mm, level):
    """Properties with full opacity shortly above the level, so that rays end at their first samples in tissue."""
    opacity = vtkPiecewiseFunction()
    opacity.AddPoint(level, 0)
    opacity.AddPoint(level + RAMP, 1)
    colour = vtkColorTransferFunction()
    colour.AddRGBPoint(0, *shading.COLOUR)
    properties = vtkVolumeProperty()
    properties.SetScalarOpacity(opacity)
    properties.SetScalarOpacityUnitDistance(spacing_mm)
    properties.SetColor(colour)
    properties.SetInterpolationTypeToLinear()
    properties.ShadeOn()
    shading.shade(properties)
    return properties
