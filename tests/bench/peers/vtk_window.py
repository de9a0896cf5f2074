import vtkmodules.vtkRenderingOpenGL2  # its import lets VTK find its OpenGL classes
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import vtkLight, vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter

import look


class VtkWindow:
    """A square window off the screen that shows one vtkProp."""

    def __init__(self, prop, camera, size):
        """`camera`: a ParallelCamera; `size`: of the picture, pixels."""
        self._renderer = vtkRenderer()
        self._renderer.AddViewProp(prop)
        self._renderer.AutomaticLightCreationOff()
        self._renderer.AddLight(_light(camera))
        self._aim(camera)
        self._window = vtkRenderWindow()
        self._window.OffScreenRenderingOn()
        self._window.SetMultiSamples(0)
        self._window.SetSize(size, size)
        self._window.AddRenderer(self._renderer)

    def _aim(self, camera):
        x_mm, y_mm, z_mm = camera.target_mm
        aimed = self._renderer.GetActiveCamera()
        aimed.ParallelProjectionOn()
        aimed.SetParallelScale(camera.field_mm / 2)
        aimed.SetFocalPoint(x_mm, y_mm, z_mm)
        # A parallel camera shows the same from everywhere on its axis. Its light is told in this distance.
        aimed.SetPosition(x_mm, y_mm - 2 * camera.field_mm, z_mm)
        aimed.SetViewUp(0, 0, 1)

    def render(self):
        """Returns when the picture is finished, not merely asked for."""
        self._renderer.ResetCameraClippingRange()
        self._window.Render()
        self._window.WaitForCompletion()

    def turn(self, angle_deg):
        """Moves the camera about elevation, around its target."""
        self._renderer.GetActiveCamera().Azimuth(angle_deg)

    def pixels(self):
        """The picture last rendered: (row, column, channel), uint8; row 0 at the bottom."""
        image = self._grabbed().GetOutput()
        columns, rows, _ = image.GetDimensions()
        return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(rows, columns, -1)

    def save(self, path):
        writer = vtkPNGWriter()
        # The image, for an output port does not keep its filter alive.
        writer.SetInputData(self._grabbed().GetOutput())
        writer.SetFileName(str(path))
        writer.Write()

    def renderer_name(self):
        """What OpenGL says of itself: its renderer and its version."""
        lines = self._window.ReportCapabilities().splitlines()
        wanted = ("OpenGL renderer string:", "OpenGL version string:")
        return ", ".join(line.partition(":")[2].strip() for line in lines if line.startswith(wanted))

    def _grabbed(self):
        grabbed = vtkWindowToImageFilter()
        grabbed.SetInput(self._window)
        grabbed.SetInputBufferTypeToRGB()
        grabbed.ReadFrontBufferOff()
        grabbed.Update()
        return grabbed


def _light(camera):
    """One directional light that goes with the camera."""
    light = vtkLight()
    light.SetLightTypeToCameraLight()
    # The camera's distance is 1 there.
    light.SetPosition(*(heights / 2 for heights in look.LIGHT))
    light.SetFocalPoint(0, 0, 0)
    return light
