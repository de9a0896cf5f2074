// SPDX-License-Identifier: Apache-2.0
// The values in force at the server (scene or probe settings), and the changes of this page that are not answered yet.
import type { SceneField } from "../generated/fanlight_pb.js";
import { numberOf, textOf, type Value, type Values } from "./scene";

export interface SettingsEditorEvents {
  /** Sends a change to the server, which replies with the same id. */
  send(requestId: bigint, values: Values): void;
  /** A shown value may have changed. */
  changed(): void;
  refused(sentence: string): void;
  accepted(): void;
  /** The user has changed values: those before, and those set. `gesture`: as given to set(). */
  edited?(before: Values, after: Values, gesture?: object): void;
  /** How long to wait from the last change to one of these settings, ms. */
  paceMs?(names: readonly string[]): number;
}

/**
 * A change is shown at once. It is sent when the change before it is answered; until then newer values replace the
 * waiting ones, so that a slow server gets the newest value of a drag and not every value.
 */
export class SettingsEditor {
  private castFields: readonly string[] = [];
  private castText = "";
  private castRevision = 0n; // from which on it is in force
  private choices = new Map<string, readonly string[]>();
  private inForce: Values = new Map();
  private revision = 0n;
  private sent: { id: bigint; values: Values } | undefined;
  private waiting: Values = new Map();
  private lastId = 0n;
  private running = false;
  private sentMs = -Infinity;
  private paceTimer: ReturnType<typeof setTimeout> | 0 = 0;

  constructor(private readonly events: SettingsEditorEvents) {}

  /** Call at the start of a session; forgets everything of the last one. `revision` is 0 for probe settings. */
  start(fields: readonly SceneField[], revision: bigint, values: Values): void {
    this.forget();
    this.choices = new Map(fields.map((field) => [field.name, field.choices]));
    // As glass the server sends pictures; a surface that was kept is opaque.
    const makesDepths = ({ name, castsRays }: SceneField) => castsRays || /^(filter|glass)\./.test(name);
    this.castFields = fields.filter(makesDepths).map(({ name }) => name);
    this.castFields = this.castFields.filter((name) => !name.startsWith("camera."));
    this.running = true;
    this.revision = revision;
    this.inForce = values;
    this.castRevision = 0n;
    this.castText = this.castTextNow();
    this.events.changed();
  }

  /** Call at the end of a session; drops unanswered changes. */
  stop(): void {
    this.forget();
    this.running = false;
    this.events.changed();
  }

  /** The value to show; undefined before the first session, and for a name that the server does not have. */
  get(name: string): Value | undefined {
    return this.waiting.get(name) ?? this.sent?.values.get(name) ?? this.inForce.get(name);
  }

  /** The value as a number or index of a choice; NaN if there is none. */
  number(name: string): number {
    return numberOf(this.get(name));
  }

  /** The value as a text; empty if there is none. */
  text(name: string): string {
    return textOf(this.get(name));
  }

  /** The name of the choice; empty if there is none. */
  choice(name: string): string {
    return this.choices.get(name)?.[this.number(name)] ?? "";
  }

  /** The names of the field's choices; empty if it has none. */
  choicesOf(name: string): readonly string[] {
    return this.choices.get(name) ?? [];
  }

  /** Of the settings in force that a depth map depends on, but for the camera; see ShownScene. */
  castKey(sceneRevision: bigint): string | undefined {
    return sceneRevision < this.castRevision ? undefined : this.castText;
  }

  /** Whether any change is waiting or unanswered. */
  isChanging(): boolean {
    return this.sent !== undefined || this.waiting.size > 0;
  }

  /** Whether a picture of that revision shows all changes of this page. */
  isShownBy(revision: bigint): boolean {
    return !this.isChanging() && revision >= this.revision;
  }

  /** `gesture`: changes with the same one are undone together. */
  set(values: Iterable<readonly [string, Value]>, gesture?: object): void {
    if (!this.running) return;
    const wanted = new Map(values);
    this.noteEdit(wanted, gesture);
    this.restore(wanted);
  }

  /** The same, for values that were in force before: edited() is not called. */
  restore(wanted: Values): void {
    if (!this.running) return;
    const differs = (name: string) => wanted.has(name) && this.get(name) !== wanted.get(name);
    const changed = [...wanted.keys()].filter((name) => differs(name) || differs(name.replace(/_mm$/, "")));
    // A window in samples or pixels sets the one in mm to 0 at the server, unless that is sent as well.
    for (const name of changed) this.waiting.set(name, wanted.get(name)!);
    this.sendWaiting();
    this.events.changed();
  }

  /** The target of the edits now counts its own revisions, from 0 (a private view). */
  beginCount(): void {
    this.revision = 0n;
  }

  /** Takes values in force from the server; older revisions are ignored. */
  adopt(revision: bigint, values: Values): void {
    if (revision < this.revision) return;
    this.revision = revision;
    this.inForce = values;
    const castText = this.castTextNow();
    if (castText !== this.castText) this.castRevision = revision;
    this.castText = castText;
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

  private noteEdit(wanted: Values, gesture: object | undefined): void {
    const changed = [...wanted].filter(([name, value]) => this.get(name) !== value && this.get(name) !== undefined);
    if (changed.length === 0) return;
    // With a size in samples the one in mm changes at the server, and the other way round.
    const names = changed.flatMap(([name]) => [name, `${name}_mm`, name.replace(/_mm$/, "")]);
    const before = [...new Set(names)].flatMap((name) => {
      const value = this.get(name);
      return value === undefined ? [] : [[name, value] as const];
    });
    this.events.edited?.(new Map(before), new Map(changed), gesture);
  }

  private answered(requestId: bigint): boolean {
    if (this.sent?.id !== requestId) return false;
    this.sent = undefined;
    return true;
  }

  /** This display has carried out the change itself. */
  keptHere(requestId: bigint): void {
    const values = this.sent?.values;
    if (!values || !this.answered(requestId)) return;
    this.inForce = new Map([...this.inForce, ...values]);
    this.events.accepted();
    this.sendWaiting();
    this.events.changed();
  }

  private sendWaiting(): void {
    if (this.sent || this.waiting.size === 0 || this.paceTimer !== 0) return;
    const paceMs = this.events.paceMs?.([...this.waiting.keys()]) ?? 0;
    const leftMs = this.sentMs + paceMs - performance.now();
    if (paceMs > 0 && leftMs > 0) {
      this.paceTimer = setTimeout(() => {
        this.paceTimer = 0;
        this.sendWaiting();
      }, leftMs);
      return;
    }
    this.sentMs = performance.now();
    this.lastId += 1n;
    this.sent = { id: this.lastId, values: this.waiting };
    this.waiting = new Map();
    this.events.send(this.sent.id, this.sent.values);
  }

  private castTextNow(): string {
    return JSON.stringify(this.castFields.map((name) => this.inForce.get(name)));
  }

  private forget(): void {
    this.sent = undefined;
    this.waiting.clear();
    clearTimeout(this.paceTimer);
    this.paceTimer = 0;
  }
}
