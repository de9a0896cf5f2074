# SPDX-License-Identifier: Apache-2.0
import vtkmodules.vtkRenderingVolumeOpenGL2 as opengl

from ray_casting import ray_cast


class Gpu:
    """Ray casting in a fragment shader, on Mesa's llvmpipe: Xvfb offers no other OpenGL device."""

    NAME = "gpu"

    def __init__(self, image, level):
        mapper = opengl.vtkOpenGLGPUVolumeRayCastMapper()
        mapper.UseJitteringOff()
        self.prop = ray_cast(mapper, image, level)
