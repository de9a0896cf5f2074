# SPDX-License-Identifier: Apache-2.0
import time

from fixed_point import FixedPoint
from flying_edges import FlyingEdges
from gpu import Gpu
from vtk_volume import VtkVolume
from vtk_window import VtkWindow

PIPELINES = {pipeline.NAME: pipeline for pipeline in (FixedPoint, Gpu, FlyingEdges)}

CAMERA_STEP_DEG = 1.0


class Peer:
    """A VTK pipeline that shows a surface, and its measurement. The constructor renders the first grid."""

    def __init__(self, name, grids, level, camera, size):
        """`name`: a key of PIPELINES; `grids`: two or more volumes, shown alternately; `level`: grey level of the
        surface; `size`: width and height of the picture, pixels."""
        self.name = name
        self._volume = VtkVolume(grids)
        self._pipeline = PIPELINES[name](self._volume.image, level)
        self.window = VtkWindow(self._pipeline.prop, camera, size)
        self.window.render()  # builds the shaders and starts the threads

    def measure_ms(self):
        """One time of each stage, ms, from the change to the finished picture.

        new_volume: the voxels are replaced; camera: the camera is turned by CAMERA_STEP_DEG.
        """
        return {
            "new_volume": self._picture_ms(self._volume.show_next),
            "camera": self._picture_ms(lambda: self.window.turn(CAMERA_STEP_DEG)),
        }

    def _picture_ms(self, change):
        start_ns = time.perf_counter_ns()
        change()
        self.window.render()
        return (time.perf_counter_ns() - start_ns) * 1e-6
