# SPDX-License-Identifier: Apache-2.0
"""Runs the fanlight program: its benchmark and its pictures."""

import json
import subprocess
from dataclasses import dataclass

from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

from failure import Failure

# Options of the paper's method, as the rows of `fanlight bench` use them.
PAPER = (
    "--speckle.size 7 --speckle.noise 0.52 --detector.threshold 20 --detector.window 8 "
    "--detector.place first-crossing --detector.frame_steps kept --filter.kind mean --filter.size 7 --filter.islands 1 "
    "--filter.holes 1 --light.normals three-neighbours --shadow.coefficient 1"
).split()

# The stages used here. new_volume: from the last frame of a volume to its picture; whole_volume: from all frames of a
# volume at once to its picture; camera: from a moved camera to its picture.
STAGES = ("new_volume", "whole_volume", "camera")


@dataclass(frozen=True)
class Row:
    """A row of `fanlight bench`."""

    name: str
    step_mm: float  # distance of samples along a ray
    size: int  # width and height of the picture, pixels

    def settings(self):
        """Options of `fanlight render` for the same picture."""
        return [*PAPER, "--rays.step_mm", str(self.step_mm)]

    def equals(self, spacing_mm):
        """Whether the step equals the spacing of a grid within a tenth."""
        return abs(spacing_mm / self.step_mm - 1) < 0.1


ROWS = (Row("r1/paper", 160 / 512, 512), Row("r1/coarse", 0.66, 256))


@dataclass(frozen=True)
class BenchRun:
    """The medians of one run of a row."""

    ms: dict  # median by stage
    device: str


class Fanlight:
    """The fanlight program. Every method raises Failure if the program fails."""

    def __init__(self, path):
        self._path = str(path)

    def check(self):
        """Raises Failure unless the program starts and has the command bench."""
        try:
            help_run = subprocess.run(
                [self._path, "bench", "--help"], capture_output=True, text=True, check=False
            )
        except OSError as error:
            reason = f"{self._path} does not start ({error.strerror}), expected a built fanlight"
            raise Failure(reason) from error
        # A program without the command prints its general help, which lacks this option.
        if "--only" not in help_run.stdout:
            raise Failure(f"{self._path} has no command bench, expected a fanlight that has")

    def version(self):
        return self._output("--version").strip()

    def bench(self, row, count):
        """Runs the Row once and returns a BenchRun; `count`: how often each stage is measured."""
        text = self._output("bench", "--only", row.name, "--count", str(count), "--json")
        report = json.loads(text)
        # If no row has this name, --only selects the rows whose name contains it.
        found = next((each for each in report["rows"] if each["name"] == row.name), None)
        if found is None:
            raise Failure(f"fanlight bench has no row {row.name}, expected one of that name")
        if found["picture"] != row.size:
            problem = f"fanlight bench's {row.name} makes pictures of {found['picture']} pixels square"
            raise Failure(f"{problem}, expected {row.size}")
        return BenchRun({stage: found["stages_ms"][stage]["p50"] for stage in STAGES}, report["device"])

    def picture(self, recording, camera, size, path, settings=()):
        """Renders the first volume of the recording to a PNG at `path`; returns its pixels as VtkWindow.pixels()."""
        # Without haze, since every pixel that is not black counts as the body's.
        picture = ["--size", f"{size}x{size}", "--light.haze", "0", "--out", str(path)]
        self._output("render", str(recording), *picture, *camera.options(), *settings)
        reader = vtkPNGReader()
        reader.SetFileName(str(path))
        reader.Update()
        image = reader.GetOutput()
        return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(size, size, -1)

    def _output(self, *arguments):
        finished = subprocess.run([self._path, *arguments], capture_output=True, text=True, check=False)
        if finished.returncode != 0:
            raise Failure(f"fanlight {arguments[0]} failed: {finished.stderr.strip()}")
        return finished.stdout
