# SPDX-License-Identifier: Apache-2.0
"""The camera that Fanlight and the peers use."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ParallelCamera:
    """Parallel projection along +y, with +x to the right and +z up. The view plane lies in the probe face."""

    target_mm: tuple  # x, y, z; centre of the picture
    field_mm: float  # width and height of the square picture in the body

    @staticmethod
    def of_whole_fan(fan, sweep):
        """Fanlight's default camera for a sweep that is symmetric about 0: scene_for() of proto/model/scene.cpp."""
        middle_mm = fan.depth_mm / 2
        half_rad = (sweep.angles_rad[-1] - sweep.angles_rad[0]) / 2
        height_mm = 2 * (fan.motor_radius_mm + middle_mm) * np.sin(half_rad)
        return ParallelCamera(
            target_mm=((fan.left_mm + fan.right_mm) / 2, middle_mm, 0.0),
            field_mm=float(max(fan.right_mm - fan.left_mm, height_mm)),
        )

    def options(self):
        """The command line options of `fanlight render` for this camera."""
        x_mm, y_mm, z_mm = self.target_mm
        values = {
            "target_x_mm": x_mm,
            "target_y_mm": y_mm,
            "target_z_mm": z_mm,
            "distance_mm": y_mm,
            "field_mm": self.field_mm,
            "yaw_deg": 0,
            "pitch_deg": 0,
        }
        return [text for name, value in values.items() for text in (f"--camera.{name}", str(value))]
