// The blocks of a frame whose grey levels are bounded together, FANLIGHT_BLOCK pixels each way, and a bound in a word.
// blocks_across, blocks_down: of a frame.
#ifndef FANLIGHT_SHADERS_BLOCKS_H
#define FANLIGHT_SHADERS_BLOCKS_H

int blocks_along(uint pixels) { return int(pixels + uint(FANLIGHT_BLOCK - 1)) / FANLIGHT_BLOCK; }

uint word_of_bound(uint least, uint greatest) { return least | greatest << 8; }
uint least_of(uint bound) { return bound & 0xFFu; }
uint greatest_of(uint bound) { return bound >> 8; }

#endif
