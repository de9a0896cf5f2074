// SPDX-License-Identifier: Apache-2.0
// Depth of a pixel of a turned surface that the view which was cast has not seen.
#ifndef FANLIGHT_SHADERS_WEB_TURNED_SURFACE_H
#define FANLIGHT_SHADERS_WEB_TURNED_SURFACE_H

const float kHole = -2.0;

#endif
