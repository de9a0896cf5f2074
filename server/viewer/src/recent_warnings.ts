// SPDX-License-Identifier: Apache-2.0
import type { SweepWarning } from "../generated/fanlight_pb.js";

/** A warning stays in sight for this long, so that it can be read where only some of the sweeps have it. */
const kHeldMs = 5000;

/** The warnings of the volume that is shown, and of those of the last seconds. */
export class RecentWarnings {
  private shown: SweepWarning[] = [];
  private readonly seen = new Map<string, { warning: SweepWarning; atMs: number }>();

  /** Takes those of a picture. */
  take(warnings: SweepWarning[], nowMs: number): void {
    this.shown = warnings;
    for (const warning of warnings) this.seen.set(warning.name, { warning, atMs: nowMs });
  }

  recent(nowMs: number): SweepWarning[] {
    const isShown = (name: string) => this.shown.some((each) => each.name === name);
    for (const [name, { atMs }] of this.seen) if (nowMs - atMs > kHeldMs && !isShown(name)) this.seen.delete(name);
    return [...this.seen.values()].map(({ warning }) => warning);
  }
}
