// SPDX-License-Identifier: Apache-2.0
import type { SweepWarning } from "../generated/fanlight_pb.js";

/** A warning stays in sight for this long, so that it can be read where only some of the sweeps have it. */
const kHeldMs = 5000;

/** The warnings of the sweeps of the last seconds. */
export class RecentWarnings {
  private readonly seen = new Map<string, { warning: SweepWarning; atMs: number }>();

  /** Takes those of a picture, and returns all that are recent. */
  take(warnings: SweepWarning[], nowMs: number): SweepWarning[] {
    for (const warning of warnings) this.seen.set(warning.name, { warning, atMs: nowMs });
    for (const [name, { atMs }] of this.seen) if (nowMs - atMs > kHeldMs) this.seen.delete(name);
    return [...this.seen.values()].map(({ warning }) => warning);
  }
}
