// A colour as the scene has it, red, green and blue from 0 to 1 as displayed, and as pages write it.

/** What is no number is 0. */
export function hexOf(parts: readonly number[]): string {
  const level = (part: number) => Math.round(255 * Math.min(1, Math.max(0, part || 0)));
  return `#${parts.map((part) => level(part).toString(16).padStart(2, "0")).join("")}`;
}

/** As many digits as bring back the same hexOf(). */
export function partsOf(hex: string): number[] {
  return [1, 3, 5].map((at) => Number((parseInt(hex.slice(at, at + 2), 16) / 255).toFixed(3)));
}
