// SPDX-License-Identifier: Apache-2.0
// The colour maps, as colour_map_points() in renderer/parameters: red, green and blue of four points at equal distances,
// darkest first.
const kColourMaps: Readonly<Record<string, readonly number[]>> = {
  sepia: [0, 0, 0, 0.29, 0.2, 0.13, 0.69, 0.56, 0.4, 1, 0.95, 0.84],
  gold: [0, 0, 0, 0.45, 0.2, 0.02, 0.85, 0.55, 0.12, 1, 0.95, 0.7],
  ice: [0, 0, 0, 0.05, 0.22, 0.45, 0.35, 0.62, 0.85, 0.92, 0.98, 1],
  heat: [0, 0, 0, 0.55, 0, 0, 1, 0.55, 0, 1, 1, 0.85],
};
const kGrey = [0, 0, 0, 1 / 3, 1 / 3, 1 / 3, 2 / 3, 2 / 3, 2 / 3, 1, 1, 1];

/** Without a map, colours are grey. */
export function colourMapPoints(map: string): readonly number[] {
  return kColourMaps[map] ?? kGrey;
}
