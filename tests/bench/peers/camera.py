"""The camera from which ours and the peers look."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ParallelCamera:
    """Looks along +y with +x to the right and +z up, from a view plane in the probe face."""

    target_mm: tuple  # x, y, z; in the middle of the picture
    field_mm: float  # height of the square picture in the body

    @staticmethod
    def of_whole_fan(fan, sweep):
        """Fanlight's own for a sweep that is as wide to either side: proto/scene.cpp, scene_for()."""
        middle_mm = fan.depth_mm / 2
        half_rad = (sweep.angles_rad[-1] - sweep.angles_rad[0]) / 2
        height_mm = 2 * (fan.motor_radius_mm + middle_mm) * np.sin(half_rad)
        return ParallelCamera(
            target_mm=((fan.left_mm + fan.right_mm) / 2, middle_mm, 0.0),
            field_mm=float(max(fan.right_mm - fan.left_mm, height_mm)),
        )

    def options(self):
        """The same for `fanlight render`."""
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
