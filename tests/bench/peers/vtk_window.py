# SPDX-License-Identifier: Apache-2.0
import vtkmodules.vtkRenderingOpenGL2  # importing it registers VTK's OpenGL classes
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import vtkLight, vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter

import shading


class VtkWindow:
    """A square off-screen window that shows one vtkProp."""

    def __init__(self, prop, camera, size):
        """`camera`: a ParallelCamera; `size`: width and height of the picture, pixels."""
        self._renderer = vtkRenderer()
        self._renderer.AddViewProp(prop)
        self._renderer.AutomaticLightCreationOff()
        self._renderer.AddLight(_light(camera))
        self._set_camera(camera)
        self._window = vtkRenderWindow()
        self._window.OffScreenRenderingOn()
        self._window.SetMultiSamples(0)
        self._window.SetSize(size, size)
        self._window.AddRenderer(self._renderer)

    def _set_camera(self, camera):
        x_mm, y_mm, z_mm = camera.target_mm
        vtk_camera = self._renderer.GetActiveCamera()
        vtk_camera.ParallelProjectionOn()
        vtk_camera.SetParallelScale(camera.field_mm / 2)
        vtk_camera.SetFocalPoint(x_mm, y_mm, z_mm)
        # The picture of a parallel camera does not depend on its distance. _light() uses the distance as its unit.
        vtk_camera.SetPosition(x_mm, y_mm - 2 * camera.field_mm, z_mm)
        vtk_camera.SetViewUp(0, 0, 1)

    def render(self):
        """Renders. Blocks until OpenGL has finished the picture."""
        self._renderer.ResetCameraClippingRange()
        self._window.Render()
        self._window.WaitForCompletion()

    def turn(self, angle_deg):
        """Rotates the camera around its target, about the elevation axis (z)."""
        self._renderer.GetActiveCamera().Azimuth(angle_deg)

    def pixels(self):
        """The picture last rendered: (row, column, channel), uint8; row 0 at the bottom."""
        image = self._captured().GetOutput()
        columns, rows, _ = image.GetDimensions()
        return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(rows, columns, -1)

    def save(self, path):
        writer = vtkPNGWriter()
        # Passes the image instead of an output port, because a port does not keep its filter alive.
        writer.SetInputData(self._captured().GetOutput())
        writer.SetFileName(str(path))
        writer.Write()

    def renderer_name(self):
        """The renderer and the version that OpenGL reports."""
        lines = self._window.ReportCapabilities().splitlines()
        wanted = ("OpenGL renderer string:", "OpenGL version string:")
        return ", ".join(line.partition(":")[2].strip() for line in lines if line.startswith(wanted))

    def _captured(self):
        capture = vtkWindowToImageFilter()
        capture.SetInput(self._window)
        capture.SetInputBufferTypeToRGB()
        capture.ReadFrontBufferOff()
        capture.Update()
        return capture


def _light(camera):
    """A directional light that moves with the camera."""
    light = vtkLight()
    light.SetLightTypeToCameraLight()
    # Positions of a camera light are in units of the camera's distance, which is two picture heights.
    light.SetPosition(*(component / 2 for component in shading.LIGHT))
    light.SetFocalPoint(0, 0, 0)
    return light
