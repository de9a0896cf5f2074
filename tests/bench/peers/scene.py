# SPDX-License-Identifier: Apache-2.0
import subprocess
from functools import lru_cache

from camera import ParallelCamera
from failure import Failure
from recording import read_recording
from scan_conversion import scan_converted


class Scene:
    """The scene that Fanlight and the peers show: two volumes of the moving phantom, seen from the probe face."""

    def __init__(self, fanlight, recorder, folder, level, pictures=None):
        """Records the volumes. `recorder`: path of the program phantom_recording; `folder`: for temporary files;
        `level`: grey level of the peers' surface; `pictures`: folder for pictures to keep, or None."""
        self._fanlight = fanlight
        self._path = folder / "phantom.igs.mha"
        _record(recorder, self._path)
        self._fan, self._sweeps = read_recording(self._path)
        self._folder = pictures or folder
        self.camera = ParallelCamera.of_whole_fan(self._fan, self._sweeps[0])
        self.level = level
        self.pictures = pictures
        # The grids of one spacing only: at 0.33 mm they take 320 MB.
        self.grids = lru_cache(maxsize=1)(self._grids)
        self.reference_picture = lru_cache(maxsize=None)(self._reference_picture)

    def _grids(self, spacing_mm):
        """A Grid for each volume. Cached until it is called with another spacing."""
        return [scan_converted(self._fan, sweep, spacing_mm) for sweep in self._sweeps]

    def _reference_picture(self, size):
        """The first volume in Fanlight's default scene, pixels as VtkWindow.pixels(). The error of its surface
        against the truth is known (renderer/RESULTS.md)."""
        path = self._folder / f"fanlight_default_{size}.png"
        return self._fanlight.picture(self._path, self.camera, size, path)

    def row_picture(self, row, size):
        """The first volume as the Row of the bench renders it, pixels as VtkWindow.pixels()."""
        path = self._folder / f"fanlight_{row.step_mm:g}mm_{size}.png"
        return self._fanlight.picture(self._path, self.camera, size, path, row.settings())


def _record(recorder, path):
    # As the rows of `fanlight bench`: the fixed numbers of the paper's method belong to linear grey levels.
    command = [recorder, path, "--volumes", "2", "--phantom", "compression=linear"]
    try:
        finished = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        raise Failure(
            f"{recorder} does not start ({error.strerror}), expected what "
            "`cmake --build --preset release --target phantom_recording` builds with FANLIGHT_TESTS=ON"
        ) from error
    if finished.returncode != 0:
        raise Failure(f"the phantom was not recorded: {finished.stderr.strip()}")
