// SPDX-License-Identifier: Apache-2.0
// The last changes of this display, to be taken back and made again.
import type { Value, Values } from "./scene";

const kMost = 20;
const kOneGestureMs = 700; // a drag sends many changes: those of the same fields within this time are one

interface Change {
  before: Values;
  after: Values;
  lastMs: number;
  gesture?: object | undefined;
}

export class UndoHistory {
  private readonly done: Change[] = [];
  private readonly undone: Change[] = [];

  /**
   * `before`: the values that `after` replaces. `gesture`: changes with the same one are one change, however long it
   * takes and also after endGesture().
   */
  add(before: Values, after: Values, nowMs: number, gesture?: object): void {
    this.undone.length = 0;
    const last = this.done.at(-1);
    if (last && sameNames(last.after, after) && isOneChange(last, nowMs, gesture)) {
      last.after = new Map(after);
      last.lastMs = nowMs;
      return;
    }
    this.done.push({ before: new Map(before), after: new Map(after), lastMs: nowMs, gesture });
    if (this.done.length > kMost) this.done.shift();
  }

  /** What comes now is a change of its own, however soon. */
  endGesture(): void {
    const last = this.done.at(-1);
    if (last) last.lastMs = -Infinity;
  }

  /** The last change did not come about. */
  drop(): void {
    this.done.pop();
  }

  clear(): void {
    this.done.length = this.undone.length = 0;
  }

  get canUndo(): boolean {
    return this.done.length > 0;
  }
  get canRedo(): boolean {
    return this.undone.length > 0;
  }

  /** What undo() would take back. */
  get last(): Values | undefined {
    return this.done.at(-1)?.after;
  }

  /** The values to set; undefined where nothing is left. */
  undo(): Values | undefined {
    const change = this.done.pop();
    if (change) this.undone.push(change);
    return change?.before;
  }

  redo(): Values | undefined {
    const change = this.undone.pop();
    if (change) this.done.push({ ...change, lastMs: -Infinity });
    return change?.after;
  }
}

function isOneChange(last: Change, nowMs: number, gesture: object | undefined): boolean {
  return gesture || last.gesture ? gesture === last.gesture : nowMs - last.lastMs < kOneGestureMs;
}

function sameNames(a: ReadonlyMap<string, Value>, b: ReadonlyMap<string, Value>): boolean {
  return a.size === b.size && [...a.keys()].every((name) => b.has(name));
}
