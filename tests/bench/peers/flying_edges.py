# SPDX-License-Identifier: Apache-2.0
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

import shading


def surface_filter(image, level, normals):
    """The filter that computes a mesh at the level; with normals or without, and no other data."""
    edges = vtkFlyingEdges3D()
    edges.SetInputData(image)
    edges.SetValue(0, level)
    edges.SetComputeNormals(normals)
    edges.ComputeGradientsOff()
    edges.ComputeScalarsOff()
    return edges


def drawn(mesh_filter):
    """A vtkActor with the filter's mesh."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(mesh_filter.GetOutputPort())
    mapper.ScalarVisibilityOff()
    actor = vtkActor()
    actor.SetMapper(mapper)
    return actor


class FlyingEdges:
    """Computes a mesh of the surface on the processor, with VTK's default number of threads, and draws it."""

    NAME = "flying-edges"

    def __init__(self, image, level):
        # Shading needs the normals.
        edges = surface_filter(image, level, normals=True)  # a port does not keep its filter alive
        self.prop = drawn(edges)
        self.prop.GetProperty().SetColor(*shading.COLOUR)
        shading.shade(self.prop.GetProperty())
