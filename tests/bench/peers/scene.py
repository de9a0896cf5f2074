import subprocess
from functools import lru_cache

from camera import ParallelCamera
from failure import Failure
from recording import read_recording
from scan_conversion import scan_converted


class Scene:
    """What everybody shows: two volumes of the moving simulated probe, seen from its face."""

    def __init__(self, fanlight, recorder, folder, level, pictures=None):
        """`recorder`: the program phantom_recording; `folder`: for files of this run; `level`: grey level of
        the peers' surface; `pictures`: a folder for pictures to keep, or None."""
        self._fanlight = fanlight
        self._path = folder / "phantom.igs.mha"
        _record(recorder, self._path)
        self._fan, self._sweeps = read_recording(self._path)
        self._folder = pictures or folder
        self.camera = ParallelCamera.of_whole_fan(self._fan, self._sweeps[0])
        self.level = level
        self.pictures = pictures
        # At 0.33 mm they take 320 MB.
        self.grids = lru_cache(maxsize=1)(self._grids)
        self.true_picture = lru_cache(maxsize=None)(self._true_picture)

    def _grids(self, spacing_mm):
        """One for each volume; kept until another spacing is asked for."""
        return [scan_converted(self._fan, sweep, spacing_mm) for sweep in self._sweeps]

    def _true_picture(self, size):
        """The first volume by Fanlight's default scene, whose surface is measured against the truth
        (renderer/README.md); pixels as of VtkWindow.pixels()."""
        path = self._folder / f"fanlight_default_{size}.png"
        return self._fanlight.picture(self._path, self.camera, size, path)

    def our_picture(self, row, size):
        """The first volume as that Row of the bench makes it."""
        path = self._folder / f"fanlight_{row.step_mm:g}mm_{size}.png"
        return self._fanlight.picture(self._path, self.camera, size, path, row.settings())


def _record(recorder, path):
    try:
        done = subprocess.run([recorder, path, "--volumes", "2"], capture_output=True, text=True, check=False)
    except OSError as error:
        raise Failure(
            f"{recorder} does not start ({error.strerror}), expected what "
            "`cmake --build --preset release --target phantom_recording` builds with FANLIGHT_TESTS=ON"
        ) from error
    if done.returncode != 0:
        raise Failure(f"the phantom was not recorded: {done.stderr.strip()}")
