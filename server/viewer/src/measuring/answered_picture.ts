// SPDX-License-Identifier: Apache-2.0
// Whether points that the server read in its newest picture are those that were clicked in the picture on show. A fine
// picture follows a coarse one of the same surface, and may reach the server's answers before it reaches the page.
import type { Picture } from "../../generated/fanlight_pb.js";

export type PictureStamp = Pick<Picture, "pictureId" | "volumeId" | "sceneRevision" | "privateView">;

/** Whether both pictures show the same surface from the same side. */
export function showsSame(one: PictureStamp, other: PictureStamp): boolean {
  return (["volumeId", "sceneRevision", "privateView"] as const).every((name) => one[name] === other[name]);
}

/**
 * `answeredId`: of the picture that the server looked in. `clicked`, `shown`: the picture when the points were clicked, and
 * now. "awaited": the answer is for a picture that has not arrived yet; ask once more when it has.
 */
export function fitOf(answeredId: bigint, clicked: PictureStamp, shown: PictureStamp): "fits" | "awaited" | "changed" {
  if (answeredId === clicked.pictureId) return "fits";
  if (!showsSame(clicked, shown)) return "changed";
  if (answeredId === shown.pictureId) return "fits";
  return answeredId > shown.pictureId ? "awaited" : "changed";
}
