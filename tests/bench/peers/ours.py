"""Fanlight's own figures and picture, from its command line."""

import json
import subprocess
from dataclasses import dataclass

from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

from failure import Failure

# The paper's method, as the rows have it.
PAPER = (
    "--detector.window 8 --detector.place first-crossing --filter.kind mean --filter.size 7 "
    "--filter.islands 1 --filter.holes 1 --light.normals three-neighbours --shadow.coefficient 1"
).split()

# What is taken of a row: a volume's last frame to its picture, all of a volume at once to its picture, and a
# moved camera to its picture.
STAGES = ("new_volume", "whole_volume", "camera")


@dataclass(frozen=True)
class Row:
    """A row of `fanlight bench` and what it renders."""

    name: str
    step_mm: float  # distance of samples along a ray
    size: int  # of the square picture, pixels

    def settings(self):
        """Of its picture, for `fanlight render`."""
        return [*PAPER, "--rays.step_mm", str(self.step_mm)]

    def equals(self, spacing_mm):
        """Whether samples are as dense as in a grid of that spacing, within a tenth."""
        return abs(spacing_mm / self.step_mm - 1) < 0.1


ROWS = (Row("r1/paper", 160 / 512, 512), Row("r1/coarse", 0.66, 256))


@dataclass(frozen=True)
class Turn:
    """The medians of one run of a row."""

    ms: dict  # by stage
    device: str


class Fanlight:
    def __init__(self, path):
        self._path = str(path)

    def check(self):
        """A Failure unless the program is there and can bench."""
        try:
            asked = subprocess.run(
                [self._path, "bench", "--help"], capture_output=True, text=True, check=False
            )
        except OSError as error:
            why = f"{self._path} does not start ({error.strerror}), expected a built fanlight"
            raise Failure(why) from error
        # One without the command tells of itself, and of no such option.
        if "--only" not in asked.stdout:
            raise Failure(f"{self._path} has no command bench, expected a fanlight that has")

    def version(self):
        return self._output("--version").strip()

    def bench(self, row, count):
        """One run of that Row, as a Turn; `count`: how often each stage is timed."""
        text = self._output("bench", "--only", row.name, "--count", str(count), "--json")
        report = json.loads(text)
        # Others have names that begin like it.
        found = next((each for each in report["rows"] if each["name"] == row.name), None)
        if found is None:
            raise Failure(f"fanlight bench has no row {row.name}, expected one of that name")
        if found["picture"] != row.size:
            made = f"fanlight bench's {row.name} makes pictures of {found['picture']} pixels square"
            raise Failure(f"{made}, expected {row.size}")
        return Turn({stage: found["stages_ms"][stage]["p50"] for stage in STAGES}, report["device"])

    def picture(self, recording, camera, size, path, settings=()):
        """The recording's first volume, as a PNG at `path` and as pixels: see VtkWindow.pixels()."""
        picture = ["--size", f"{size}x{size}", "--out", str(path)]
        self._output("render", str(recording), *picture, *camera.options(), *settings)
        reader = vtkPNGReader()
        reader.SetFileName(str(path))
        reader.Update()
        image = reader.GetOutput()
        return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(size, size, -1)

    def _output(self, *arguments):
        done = subprocess.run([self._path, *arguments], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise Failure(f"fanlight {arguments[0]} failed: {done.stderr.strip()}")
        return done.stdout
