from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonDataModel import vtkImageData


class VtkVolume:
    """Grids of the same shape that take turns as the scalars of one vtkImageData. Copies no voxel."""

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
        """The next grid's voxels, modified, as if they had just come."""
        self._shown = (self._shown + 1) % len(self._scalars)
        scalars = self._scalars[self._shown]
        scalars.Modified()
        self.image.GetPointData().SetScalars(scalars)
        self.image.Modified()
