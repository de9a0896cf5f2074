# SPDX-License-Identifier: Apache-2.0
"""One benchmark case: Fanlight and its peers in turn, at one grid spacing of the peers and one picture size."""

from dataclasses import dataclass, field
from statistics import median

import numpy as np

from failure import Failure
from peer import Peer

# Number of times that one run of `fanlight bench` measures each stage.
BENCH_COUNT = 3
# Grey level, 0 to 255. A pixel is lit if one of its channels is brighter; otherwise it is background.
LIT_LEVEL = 8
# Two pictures of the same head from the same camera have a larger overlap; exchanged axes, another scale or a black
# picture give a smaller one. A mirrored picture is not detected, because the outline of the head is nearly symmetric:
# check that by eye.
LEAST_OVERLAP = 0.9


class StageTimes:
    """Measured times by stage, ms, in the order of measurement."""

    def __init__(self):
        self.ms = {}

    def add(self, run_ms):
        """`run_ms`: one time for each stage."""
        for stage, ms in run_ms.items():
            self.ms.setdefault(stage, []).append(ms)

    def median_ms(self, stage):
        return median(self.ms[stage])


@dataclass
class BenchCase:
    """The parameters of a case and, after run(), its results."""

    row: object  # fanlight.Row
    spacing_mm: float  # of the grids for VTK
    size: int  # width and height of the pictures for the overlap and of VTK's timed pictures, pixels
    dimensions: tuple = ()  # voxels along x, y, z
    fanlight_times: StageTimes = field(default_factory=StageTimes)
    peer_times: dict = field(default_factory=dict)  # StageTimes by name of the peer
    fanlight_overlap: float = 0.0  # _overlap() of Fanlight's picture by the row with the reference picture
    peer_overlaps: dict = field(default_factory=dict)  # the same by name of the peer
    device: str = ""  # Fanlight's
    opengl: str = ""  # VTK's

    @property
    def equal_resolution(self):
        """Whether Fanlight and the peers have the same sample distance (within a tenth) and picture size."""
        return self.row.equals(self.spacing_mm) and self.row.size == self.size

    def run(self, fanlight, scene, peer_names, rounds):
        """Renders every picture, checks the overlaps, and measures. Raises Failure where an overlap is too small.

        `fanlight`: a Fanlight; `scene`: the Scene that all of them show; `peer_names`: keys of peer.PIPELINES.
        """
        grids = scene.grids(self.spacing_mm)
        self.dimensions = grids[0].dimensions
        peers = [Peer(name, grids, scene.level, scene.camera, self.size) for name in peer_names]
        self.opengl = peers[0].window.renderer_name()
        reference = scene.reference_picture(self.size)
        self.fanlight_overlap = _overlap(reference, scene.row_picture(self.row, self.size))
        for peer in peers:
            if scene.pictures:
                peer.window.save(scene.pictures / f"{peer.name}_{self.spacing_mm:g}mm_{self.size}.png")
            self.peer_overlaps[peer.name] = _overlap(reference, peer.window.pixels())
            self.peer_times[peer.name] = StageTimes()
        self._check_overlaps()
        for _ in range(rounds):
            for peer in peers:
                self._measure(fanlight, peer)

    def _check_overlaps(self):
        for name, overlap in self.peer_overlaps.items():
            if not overlap >= LEAST_OVERLAP:
                raise Failure(
                    f"{name} at {self.spacing_mm} mm has {overlap:.2f} of its lit pixels in common with "
                    f"fanlight, expected {LEAST_OVERLAP} at least"
                )

    def _measure(self, fanlight, peer):
        """Measures Fanlight directly before each peer, so that a disturbance of the machine affects both."""
        fanlight_run = fanlight.bench(self.row, BENCH_COUNT)
        self.device = fanlight_run.device
        self.fanlight_times.add(fanlight_run.ms)
        self.peer_times[peer.name].add(peer.measure_ms())


def _overlap(reference, picture):
    """Number of pixels lit in both pictures over the number lit in either; 0 if none is lit.

    Pictures are (row, column, channel), uint8.
    """
    reference_lit, lit = (each[:, :, :3].max(axis=2) > LIT_LEVEL for each in (reference, picture))
    either = np.count_nonzero(reference_lit | lit)
    return np.count_nonzero(reference_lit & lit) / either if either else 0.0
