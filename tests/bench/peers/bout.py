"""Ours and the peers in turn, at one spacing of the peers' grid and one size of the picture."""

from dataclasses import dataclass, field
from statistics import median

import numpy as np

from failure import Failure
from peer import Peer

# How often `fanlight bench` times each stage in a turn.
TURN_COUNT = 3
# Of a channel, in grey levels: what is darker is background.
LIT = 8
# Two pictures of the same head from the same camera share more than that; exchanged axes, another scale or
# a black picture, less. The head is too even for its outline to tell which way round it is: look at it.
LEAST_OVERLAP = 0.9


class Times:
    """What was timed, ms, by stage and in order."""

    def __init__(self):
        self.ms = {}

    def add(self, turn_ms):
        """`turn_ms`: one time of each stage."""
        for stage, ms in turn_ms.items():
            self.ms.setdefault(stage, []).append(ms)

    def median_ms(self, stage):
        return median(self.ms[stage])


@dataclass
class Bout:
    """Of which row, spacing and size, and what came of it."""

    row: object  # ours.Row
    spacing_mm: float
    size: int  # of all pictures, pixels
    dimensions: tuple = ()  # voxels along x, y, z
    ours: Times = field(default_factory=Times)
    peers: dict = field(default_factory=dict)  # Times by name
    our_overlap: float = 0.0  # how much of the lit pixels is common with the true picture
    overlaps: dict = field(default_factory=dict)  # the same by peer
    device: str = ""  # Fanlight's
    opengl: str = ""  # VTK's

    @property
    def equal_resolution(self):
        return self.row.equals(self.spacing_mm) and self.row.size == self.size

    def run(self, fanlight, scene, peer_names, rounds):
        """Fills in the rest. `scene`: what everybody shows, a Scene."""
        grids = scene.grids(self.spacing_mm)
        self.dimensions = grids[0].dimensions
        peers = [Peer(name, grids, scene.level, scene.camera, self.size) for name in peer_names]
        self.opengl = peers[0].window.renderer_name()
        truth = scene.true_picture(self.size)
        self.our_overlap = _overlap(truth, scene.our_picture(self.row, self.size))
        for peer in peers:
            if scene.pictures:
                peer.window.save(scene.pictures / f"{peer.name}_{self.spacing_mm:g}mm_{self.size}.png")
            self.overlaps[peer.name] = _overlap(truth, peer.window.pixels())
            self.peers[peer.name] = Times()
        self._check_overlaps()
        for _ in range(rounds):
            for peer in peers:
                self._turn(fanlight, peer)

    def _check_overlaps(self):
        for name, overlap in self.overlaps.items():
            if not overlap >= LEAST_OVERLAP:
                raise Failure(
                    f"{name} at {self.spacing_mm} mm has {overlap:.2f} of its lit pixels in common with "
                    f"fanlight, expected {LEAST_OVERLAP} at least"
                )

    def _turn(self, fanlight, peer):
        """Ours goes before each peer, so that what else the machine does disturbs all alike."""
        ours = fanlight.bench(self.row, TURN_COUNT)
        self.device = ours.device
        self.ours.add(ours.ms)
        self.peers[peer.name].add(peer.turn_ms())


def _overlap(truth, picture):
    """Of two pictures (row, column, channel): pixels lit in both over pixels lit in either; 0 without any."""
    true_lit, lit = (each[:, :, :3].max(axis=2) > LIT for each in (truth, picture))
    either = np.count_nonzero(true_lit | lit)
    return np.count_nonzero(true_lit & lit) / either if either else 0.0
