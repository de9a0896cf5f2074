import time

from fixed_point import FixedPoint
from flying_edges import FlyingEdges
from gpu import Gpu
from vtk_volume import VtkVolume
from vtk_window import VtkWindow

PIPELINES = {pipeline.NAME: pipeline for pipeline in (FixedPoint, Gpu, FlyingEdges)}

TURN_DEG = 1.0


class Peer:
    """One of VTK's ways to show a surface, timed. Its first picture, the first grid's, has been made."""

    def __init__(self, name, grids, level, camera, size):
        """`grids`: two or more volumes, which take turns; `level`: grey level of the surface;
        `size`: of the square picture, pixels."""
        self.name = name
        self._volume = VtkVolume(grids)
        self._pipeline = PIPELINES[name](self._volume.image, level)
        self.window = VtkWindow(self._pipeline.prop, camera, size)
        self.window.render()  # builds shaders and threads, once

    def turn_ms(self):
        """By stage: from new voxels, in place, or a camera turned by a degree, to the finished picture."""
        return {
            "new_volume": self._picture_ms(self._volume.show_next),
            "camera": self._picture_ms(lambda: self.window.turn(TURN_DEG)),
        }

    def _picture_ms(self, change):
        start_ns = time.perf_counter_ns()
        change()
        self.window.render()
        return (time.perf_counter_ns() - start_ns) * 1e-6
