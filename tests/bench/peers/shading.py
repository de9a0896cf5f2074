# SPDX-License-Identifier: Apache-2.0
"""Light and material of the peers' surfaces: Fanlight's defaults."""

# Default grey level of the surface: 20, Fanlight's default step, above 6, the level of the fluid. The fluid is at most
# 24. With a higher level dark speckle leaves more holes in the tissue, and flying edges makes more triangles of them.
LEVEL = 26

COLOUR = (0.95, 0.78, 0.68)
# Position of the light relative to the target, in picture heights: right, up, towards the viewer.
LIGHT = (-0.42, 0.42, 0.9)


def shade(properties):
    """Sets the reflection coefficients of a vtkProperty or vtkVolumeProperty."""
    properties.SetAmbient(0.2)
    properties.SetDiffuse(0.75)
    properties.SetSpecular(0.25)
    properties.SetSpecularPower(24)
