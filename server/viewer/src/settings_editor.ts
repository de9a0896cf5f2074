// What is in force at the server, the scene or the probe's settings, and this page's changes on their way to become it.
import type { SceneField } from "../generated/fanlight_pb.js";
import { numberOf, textOf, type Value, type Values } from "./scene";

export interface SettingsEditorEvents {
  /** Hands a change to the server, which answers with the same id. */
  send(requestId: bigint, values: Values): void;
  /** Some shown value is another one now. */
  changed(): void;
  refused(sentence: string): void;
  accepted(): void;
}

/**
 * A change is shown at once and sent when the one before it was answered; meanwhile newer values replace
 * waiting ones, so that a slow server gets the newest of a drag and not all of it.
 */
export class SettingsEditor {
  private choices = new Map<string, readonly string[]>();
  private inForce: Values = new Map();
  private revision = 0n;
  private sent: { id: bigint; values: Values } | undefined;
  private waiting: Values = new Map();
  private lastId = 0n;
  private running = false;

  constructor(private readonly events: SettingsEditorEvents) {}

  /** A session begins: nothing of an earlier one counts, not even its revision. The probe's settings have none: 0. */
  start(fields: readonly SceneField[], revision: bigint, values: Values): void {
    this.forget();
    this.choices = new Map(fields.map((field) => [field.name, field.choices]));
    this.running = true;
    this.revision = revision;
    this.inForce = values;
    this.events.changed();
  }

  /** The session ended: what was not answered is taken back. */
  stop(): void {
    this.forget();
    this.running = false;
    this.events.changed();
  }

  /** The value to show; none before the first session and for a name the server does not have. */
  get(name: string): Value | undefined {
    return this.waiting.get(name) ?? this.sent?.values.get(name) ?? this.inForce.get(name);
  }

  /** The same of a number or a choice's index; NaN where there is none. */
  number(name: string): number {
    return numberOf(this.get(name));
  }

  /** The same of a text; empty where there is none. */
  text(name: string): string {
    return textOf(this.get(name));
  }

  /** The name of the choice; empty where there is none. */
  choice(name: string): string {
    return this.choices.get(name)?.[this.number(name)] ?? "";
  }

  /** Whether some change is not answered yet. */
  isChanging(): boolean {
    return this.sent !== undefined || this.waiting.size > 0;
  }

  /** Whether a picture of that revision shows everything that was asked for. */
  isShownBy(revision: bigint): boolean {
    return !this.isChanging() && revision >= this.revision;
  }

  set(values: Iterable<readonly [string, Value]>): void {
    if (!this.running) return;
    for (const [name, value] of values) {
      if (this.get(name) !== value) this.waiting.set(name, value);
    }
    this.sendWaiting();
    this.events.changed();
  }

  /** What is edited has a count of revisions of its own from now on. */
  beginCount(): void {
    this.revision = 0n;
  }

  /** The server says what is in force. */
  adopt(revision: bigint, values: Values): void {
    if (revision < this.revision) return;
    this.revision = revision;
    this.inForce = values;
    this.events.changed();
  }

  acceptedReply(requestId: bigint, revision: bigint, values: Values): void {
    if (!this.answered(requestId)) return;
    this.events.accepted();
    this.adopt(revision, values);
    this.sendWaiting();
  }

  refusedReply(requestId: bigint, sentence: string): void {
    if (!this.answered(requestId)) return;
    this.events.refused(sentence);
    this.sendWaiting();
    this.events.changed();
  }

  private answered(requestId: bigint): boolean {
    if (this.sent?.id !== requestId) return false;
    this.sent = undefined;
    return true;
  }

  private sendWaiting(): void {
    if (this.sent || this.waiting.size === 0) return;
    this.lastId += 1n;
    this.sent = { id: this.lastId, values: this.waiting };
    this.waiting = new Map();
    this.events.send(this.sent.id, this.sent.values);
  }

  private forget(): void {
    this.sent = undefined;
    this.waiting.clear();
  }
}
