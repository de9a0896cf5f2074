// SPDX-License-Identifier: Apache-2.0
// The depth map of a turned surface, and its certainty (turn.vert).
in highp vec2 surface;
out vec4 turned;

void main() {
  turned = vec4(surface, 0.0, 1.0);
}
