# SPDX-License-Identifier: Apache-2.0
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

import shading


class FlyingEdges:
    """Computes a mesh of the surface on the processor, with VTK's default number of threads, and draws it."""

    NAME = "flying-edges"

    def __init__(self, image, level):
        edges = vtkFlyingEdges3D()
        edges.SetInputData(image)
        edges.SetValue(0, level)
        # Shading needs only the normals.
        edges.ComputeNormalsOn()
        edges.ComputeGradientsOff()
        edges.ComputeScalarsOff()
        mapper = vtkPolyDataMapper()
        mapper.SetInputConnection(edges.GetOutputPort())
        mapper.ScalarVisibilityOff()
        self.prop = vtkActor()
        self.prop.SetMapper(mapper)
        self.prop.GetProperty().SetColor(*shading.COLOUR)
        shading.shade(self.prop.GetProperty())
