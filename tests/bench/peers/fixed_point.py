# SPDX-License-Identifier: Apache-2.0
from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper

from ray_casting import ray_cast


class FixedPoint:
    """Ray casting on the processor, with VTK's default number of threads."""

    NAME = "fixed-point"

    def __init__(self, image, level):
        self.prop = ray_cast(vtkFixedPointVolumeRayCastMapper(), image, level)
