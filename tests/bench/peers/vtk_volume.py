# SPDX-License-Identifier: Apache-2.0
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData


class VtkVolume:
    """One vtkImageData whose scalars are those of one of several grids of the same shape. Copies no voxel."""

    def __init__(self, grids):
        first = grids[0]
        self.image = vtkImageData()
        self.image.SetDimensions(first.dimensions)
        self.image.SetSpacing([first.spacing_mm] * 3)
        self.image.SetOrigin(first.origin_mm)
        self._scalars = [numpy_to_vtk(grid.levels.ravel()) for grid in grids]
        self._shown = 0
        self.image.GetPointData().SetScalars(self._scalars[0])

    def show_next(self):
        """Shows the voxels of the next grid and marks them as modified, as for a new volume."""
        self._shown = (self._shown + 1) % len(self._scalars)
        scalars = self._scalars[self._shown]
        scalars.Modified()
        self.image.GetPointData().SetScalars(scalars)
        self.image.Modified()
