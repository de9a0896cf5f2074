"""What a surface looks like in the peers' pictures: Fanlight's default light and material."""

# Grey level of the surface unless asked otherwise: Fanlight's default step of 20 above the fluid's 6. No
# fluid is that bright (24 at most). The higher it is, the more holes dark speckle leaves in the tissue, and
# the more triangles flying edges makes of them.
LEVEL = 26

COLOUR = (0.95, 0.78, 0.68)
# In heights of the picture: right of the target, above it, and towards the viewer.
LIGHT = (-0.42, 0.42, 0.9)


def shade(properties):
    """Sets the reflection of a vtkProperty or vtkVolumeProperty."""
    properties.SetAmbient(0.2)
    properties.SetDiffuse(0.75)
    properties.SetSpecular(0.25)
    properties.SetSpecularPower(24)
