// What the status line says of the plan that holds the rate of pictures.
import type { Picture } from "../generated/fanlight_pb.js";

/** "level 3: coarse picture, wide step"; empty where the plan is off or the machine keeps up. */
export function deadlineText({ deadlineLevel, measures }: Pick<Picture, "deadlineLevel" | "measures">): string {
  if (deadlineLevel === 0 && measures.length === 0) return "";
  return `level ${deadlineLevel}: ${measures.join(", ") || "full picture"}`;
}
