from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

import look


class FlyingEdges:
    """A mesh of the surface, made by the processor with as many threads as VTK takes by itself, and drawn."""

    NAME = "flying-edges"

    def __init__(self, image, level):
        edges = vtkFlyingEdges3D()
        edges.SetInputData(image)
        edges.SetValue(0, level)
        # Normals are all that shading needs.
        edges.ComputeNormalsOn()
        edges.ComputeGradientsOff()
        edges.ComputeScalarsOff()
        mapper = vtkPolyDataMapper()
        mapper.SetInputConnection(edges.GetOutputPort())
        mapper.ScalarVisibilityOff()
        self.prop = vtkActor()
        self.prop.SetMapper(mapper)
        self.prop.GetProperty().SetColor(*look.COLOUR)
        look.shade(self.prop.GetProperty())
