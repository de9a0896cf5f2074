# SPDX-License-Identifier: Apache-2.0
"""Writes depth maps of surfaces that VTK finds, for picture_quality --depths, and runs it."""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # importing it registers VTK's OpenGL classes
import vtkmodules.vtkRenderingVolumeOpenGL2
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction
from vtkmodules.vtkFiltersCore import vtkWindowedSincPolyDataFilter
from vtkmodules.vtkImagingGeneral import vtkImageGaussianSmooth
from vtkmodules.vtkRenderingCore import (
    vtkRenderer,
    vtkRenderWindow,
    vtkVolume,
    vtkVolumeProperty,
    vtkWindowToImageFilter,
)
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper

from camera import ParallelCamera
from flying_edges import drawn, surface_filter
from recording import read_recording
from scan_conversion import scan_converted
from vtk_volume import VtkVolume

# The view from the front of picture_quality.cpp.
CAMERA = ParallelCamera(target_mm=(0.0, 80.0, 2.0), field_mm=130.0)
VIEW_PLANE_Y_MM = -20.0
SIZE = 320
NEAREST_Y_MM, FARTHEST_Y_MM = -20.0, 200.0  # picture_quality's rays end at 220 mm below the view plane
WORKS = [(scene, probe) for scene in ("face", "relief") for probe in ("r1", "r2")]


def main():
    options = _options()
    build = options.build.resolve()
    with tempfile.TemporaryDirectory() as temporary:
        folder = (options.depths or Path(temporary)).resolve()
        folder.mkdir(exist_ok=True)
        for scene, probe in WORKS:
            if options.only in f"{scene}/{probe}":
                _write_depths(build, Path(temporary), folder, scene, probe, options.spacing)
        command = [build / "tests/accuracy/picture_quality", "--depths", folder]
        command += ["--rows", f"^(?=.*{options.only})(face|relief)/.*/(default|vtk.*)/front"]
        if options.pictures:
            command += ["--pictures", options.pictures]
        sys.exit(subprocess.run(command, check=False).returncode)


def _options():
    parser = argparse.ArgumentParser(prog="likeness", description=__doc__)
    build = Path(__file__).resolve().parents[3] / "build/release"
    parser.add_argument("--build", type=Path, default=build, help="build folder with the programs")
    parser.add_argument("--only", default="", help="works whose name holds this, such as face/r1")
    parser.add_argument("--spacing", type=float, default=0.5, help="of the resampled grid, mm")
    parser.add_argument("--depths", type=Path, help="folder to keep the depth maps in")
    parser.add_argument("--pictures", type=Path, help="folder to write the pictures to")
    return parser.parse_args()


def _write_depths(build, temporary, folder, scene, probe, spacing_mm):
    """Writes SCENE_PROBE_METHOD.f32 for each method and level: height x width floats, top row first, mm below the
    view plane, negative without a surface."""
    path = temporary / f"{scene}_{probe}.igs.mha"
    phantom = f"probe={probe},scene={scene},moving=off,seed=1,scan=cartesian"
    recorder = build / "tests/bench/phantom_recording"
    subprocess.run([recorder, path, "--volumes", "1", "--phantom", phantom], check=True)
    fan, sweeps = read_recording(path)
    volume = VtkVolume([scan_converted(fan, sweeps[0], spacing_mm)])
    for sigma_mm in (0, 1.5):
        image = _smoothed(volume.image, sigma_mm, spacing_mm)
        for level in (60, 80, 100, 120, 140):
            found = {"mesh": _mesh_depths(_mesh(image, level)), "rays": _ray_depths(_ray_caster(image, level))}
            for name, depths in found.items():
                _depths_mm(depths).tofile(folder / f"{scene}_{probe}_vtk-{name}-{sigma_mm}mm-{level}.f32")


def _smoothed(image, sigma_mm, spacing_mm):
    """The volume after a Gaussian filter, or as it is for 0."""
    if sigma_mm == 0:
        return image
    smooth = vtkImageGaussianSmooth()
    smooth.SetInputData(image)
    smooth.SetStandardDeviation(sigma_mm / spacing_mm)
    smooth.SetRadiusFactor(2)
    smooth.Update()
    return smooth.GetOutput()


def _mesh(image, level):
    """Flying edges, then windowed-sinc smoothing."""
    edges = surface_filter(image, level, normals=False)  # a port does not keep its filter alive
    smooth = vtkWindowedSincPolyDataFilter()
    smooth.SetInputConnection(edges.GetOutputPort())
    smooth.SetNumberOfIterations(20)
    smooth.SetPassBand(0.02)
    smooth.NormalizeCoordinatesOn()
    smooth.FeatureEdgeSmoothingOff()
    return drawn(smooth)


def _ray_caster(image, level):
    """The GPU's ray caster with a step of opacity at the level, which keeps where it becomes opaque."""
    mapper = vtkGPUVolumeRayCastMapper()
    mapper.SetInputData(image)
    mapper.SetBlendModeToComposite()
    mapper.UseJitteringOff()
    mapper.AutoAdjustSampleDistancesOff()
    mapper.SetSampleDistance(0.25)
    mapper.RenderToImageOn()
    opacity = vtkPiecewiseFunction()
    opacity.AddPoint(level - 1, 0)
    opacity.AddPoint(level, 1)
    properties = vtkVolumeProperty()
    properties.SetInterpolationTypeToLinear()
    properties.SetScalarOpacity(opacity)
    volume = vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(properties)
    return volume


def _drawn(prop):
    """A window that shows `prop` from the front."""
    renderer = vtkRenderer()
    renderer.AddViewProp(prop)
    camera = renderer.GetActiveCamera()
    x_mm, y_mm, z_mm = CAMERA.target_mm
    camera.ParallelProjectionOn()
    camera.SetParallelScale(CAMERA.field_mm / 2)
    camera.SetFocalPoint(x_mm, y_mm, z_mm)
    camera.SetPosition(x_mm, NEAREST_Y_MM - 10, z_mm)
    camera.SetViewUp(0, 0, 1)
    camera.SetClippingRange(10, FARTHEST_Y_MM - NEAREST_Y_MM + 10)
    window = vtkRenderWindow()
    window.OffScreenRenderingOn()
    window.SetMultiSamples(0)
    window.SetSize(SIZE, SIZE)
    window.AddRenderer(renderer)
    window.Render()
    return window


def _mesh_depths(mesh):
    """The depth buffer of OpenGL: 0 at the near plane, 1 at the far one."""
    capture = vtkWindowToImageFilter()
    capture.SetInput(_drawn(mesh))
    capture.SetInputBufferTypeToZBuffer()
    capture.Update()
    return _copied(capture.GetOutput())


def _ray_depths(volume):
    """As _mesh_depths()."""
    window = _drawn(volume)  # holds the mapper's textures
    image = vtkImageData()
    volume.GetMapper().GetDepthImage(image)
    del window
    return _copied(image)


def _copied(image):
    """The values of an image, which outlive it."""
    return np.array(vtk_to_numpy(image.GetPointData().GetScalars()))


def _depths_mm(depths):
    """(rows, columns), float32, top row first: mm below the view plane, -1 where the depth buffer is at its end.
    `depths`: 0 at NEAREST_Y_MM, 1 at FARTHEST_Y_MM, bottom row first."""
    rows = depths.reshape(SIZE, SIZE)[::-1]
    from_plane_mm = NEAREST_Y_MM - VIEW_PLANE_Y_MM + rows * (FARTHEST_Y_MM - NEAREST_Y_MM)
    return np.where(rows < 1, from_plane_mm, -1).astype(np.float32)


if __name__ == "__main__":
    main()
