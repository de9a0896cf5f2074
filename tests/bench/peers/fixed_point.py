from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper

from ray_casting import ray_cast


class FixedPoint:
    """Ray casting on the processor, with as many threads as VTK takes by itself."""

    NAME = "fixed-point"

    def __init__(self, image, level):
        self.prop = ray_cast(vtkFixedPointVolumeRayCastMapper(), image, level)
