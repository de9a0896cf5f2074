// A pixel of pass 2's picture as it is stored: four halves.
#ifndef FANLIGHT_SHADERS_LIT_PICTURE_H
#define FANLIGHT_SHADERS_LIT_PICTURE_H

vec3 unpacked(uvec2 halves) { return vec3(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y).x); }
uvec2 packed(vec3 colour) { return uvec2(packHalf2x16(colour.rg), packHalf2x16(vec2(colour.b, 1.0))); }

// Of a colour as displayed (Rec. 709).
float brightness(vec3 colour) { return dot(colour, vec3(0.2126, 0.7152, 0.0722)); }

#endif
