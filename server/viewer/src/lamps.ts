// SPDX-License-Identifier: Apache-2.0
// The three lights of the scene, by the group of their fields.
export const kLamps = ["light", "fill_light", "back_light"] as const;
export type Lamp = (typeof kLamps)[number];

export const kLampTitles: Readonly<Record<Lamp, string>> = { light: "Key", fill_light: "Fill", back_light: "Back" };
