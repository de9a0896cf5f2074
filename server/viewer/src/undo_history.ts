// SPDX-License-Identifier: Apache-2.0
// The last changes of this display, to be taken back and made again.
import type { Value, Values } from "./scene";

const kMost = 20;
const kOneGestureMs = 700; // a key held down or a wheel sends many changes: those of the same fields are one

interface Change {
  before: Values;
  after: Values;
  lastMs: number;
  gesture?: object | undefined;
}

export class UndoHistory {
  private readonly done: Change[] = [];
  private readonly undone: Change[] = [];
  private hand: object | undefined; // the gesture of the hand that is down

  /**
   * `before`: the values that `after` replaces. `gesture`: changes with the same one are one change, however long it
   * takes and also after endGesture(); by default that of the hand that is down.
   */
  add(before: Values, after: Values, nowMs: number, gesture = this.hand): void {
    this.undone.length = 0;
    const last = this.done.at(-1);
    if (last && isOneChange(last, after, nowMs, gesture)) {
      last.before = new Map([...before, ...last.before]);
      last.after = new Map([...last.after, ...after]);
      last.lastMs = nowMs;
      return;
    }
    this.done.push({ before: new Map(before), after: new Map(after), lastMs: nowMs, gesture });
    if (this.done.length > kMost) this.done.shift();
  }

  /** A hand is down: until endGesture() all changes are one, of whatever fields and however long the hand rests. */
  beginGesture(): void {
    this.hand = {};
  }

  /** What comes now is a change of its own, however soon. */
  endGesture(): void {
    this.hand = undefined;
    const last = this.done.at(-1);
    if (last) last.lastMs = -Infinity;
  }

  /** The last change did not come about. Where it is a drag of many, none of them can be undone. */
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

function isOneChange(last: Change, after: Values, nowMs: number, gesture: object | undefined): boolean {
  if (gesture || last.gesture) return gesture === last.gesture;
  return nowMs - last.lastMs < kOneGestureMs && sameNames(last.after, after);
}

function sameNames(a: ReadonlyMap<string, Value>, b: ReadonlyMap<string, Value>): boolean {
  return a.size === b.size && [...a.keys()].every((name) => b.has(name));
}
