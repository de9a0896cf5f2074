"""What VTK's two ray casters have in common."""

from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction
from vtkmodules.vtkRenderingCore import vtkColorTransferFunction, vtkVolume, vtkVolumeProperty

import look

# Grey levels above the surface's over which a sample turns from clear to opaque.
RAMP = 10


def ray_cast(mapper, image, level):
    """A vtkVolume that shows a shaded surface of a vtkImageData at that grey level.

    A ray a pixel, with samples as far apart as voxels.
    """
    spacing_mm = image.GetSpacing()[0]
    mapper.SetInputData(image)
    # Otherwise a slow picture makes the next one coarser.
    mapper.AutoAdjustSampleDistancesOff()
    mapper.SetImageSampleDistance(1)
    mapper.SetSampleDistance(spacing_mm)
    volume = vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(_surface(spacing_mm, level))
    return volume


def _surface(spacing_mm, level):
    """Clear up to the level and soon opaque above it, so that rays end at their first samples in tissue."""
    opacity = vtkPiecewiseFunction()
    opacity.AddPoint(level, 0)
    opacity.AddPoint(level + RAMP, 1)
    colour = vtkColorTransferFunction()
    colour.AddRGBPoint(0, *look.COLOUR)
    properties = vtkVolumeProperty()
    properties.SetScalarOpacity(opacity)
    properties.SetScalarOpacityUnitDistance(spacing_mm)
    properties.SetColor(colour)
    properties.SetInterpolationTypeToLinear()
    properties.ShadeOn()
    look.shade(properties)
    return properties
