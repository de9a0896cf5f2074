// SPDX-License-Identifier: Apache-2.0
// Converts a colour between the scene (red, green, blue from 0 to 1, sRGB) and HTML (#rrggbb).

/** NaN counts as 0. */
export function hexOf(parts: readonly number[]): string {
  const level = (part: number) => Math.round(255 * Math.min(1, Math.max(0, part || 0)));
  return `#${parts.map((part) => level(part).toString(16).padStart(2, "0")).join("")}`;
}

/** Rounded to as many digits as hexOf() needs to return the same text. */
export function partsOf(hex: string): number[] {
  return [1, 3, 5].map((at) => Number((parseInt(hex.slice(at, at + 2), 16) / 255).toFixed(3)));
}
