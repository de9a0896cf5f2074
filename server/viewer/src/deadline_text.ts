// SPDX-License-Identifier: Apache-2.0
// Text of the status line about the rate governor.
import type { Picture } from "../generated/fanlight_pb.js";

/** "level 3: coarse picture, wide step"; empty if the governor is off or takes nothing. */
export function deadlineText({ deadlineLevel, measures }: Pick<Picture, "deadlineLevel" | "measures">): string {
  if (deadlineLevel === 0 && measures.length === 0) return "";
  return `level ${deadlineLevel}: ${measures.join(", ") || "full picture"}`;
}
