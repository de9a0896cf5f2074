// SPDX-License-Identifier: Apache-2.0
// Where the changes of this page go: to the main view, to this display's own view at the server, or, of the light of an
// own view, nowhere, since this display lights the surface itself. And the answers to them.
import type { SceneReply, ViewReply } from "../generated/fanlight_pb.js";
import type { Connection } from "./connection";
import { kLitHere, type OwnView } from "./own_view";
import { sceneOf, valuesOf, type Values } from "./scene";
import type { SettingsEditor } from "./settings_editor";

/** The server and other displays learn of a moved light no more often. */
const kLightMs = 100;
/** The request that gives an own light to the server; changes count from 1. */
const kHandedOver = 0n;

export class SceneChanges {
  constructor(
    private readonly connection: Pick<Connection, "send">,
    private readonly from: {
      ownView(): OwnView;
      /** Whether this display draws all of the picture on show. */
      lightsHere(): boolean;
      editor(): SettingsEditor;
      failed(sentence: string): void;
    },
  ) {}

  send(requestId: bigint, values: Values): void {
    const ownView = this.from.ownView();
    if (!ownView.wanted)
      return this.connection.send({ case: "sceneChange", value: { requestId, scene: sceneOf(values) } });
    const forServer = this.from.lightsHere() ? ownView.keep(values) : values;
    if (forServer.size === 0) return queueMicrotask(() => this.from.editor().keptHere(requestId));
    this.connection.send({ case: "view", value: { requestId, scene: sceneOf(forServer) } });
  }

  /** How long to wait from the last change to one of these settings. */
  paceMs(names: readonly string[]): number {
    const light = names.every((name) => kLitHere.includes(name.split(".")[0]!));
    return light && this.from.lightsHere() && !this.from.ownView().wanted ? kLightMs : 0;
  }

  settle({ requestId, outcome }: SceneReply): void {
    const editor = this.from.editor();
    if (outcome.case === "refused") return editor.refusedReply(requestId, outcome.value.message);
    if (outcome.case !== "inForce" || !outcome.value.scene) return;
    this.from.ownView().mainIs(outcome.value);
    editor.acceptedReply(requestId, outcome.value.revision, valuesOf(outcome.value.scene));
  }

  settleView({ requestId, outcome }: ViewReply): void {
    const [editor, ownView] = [this.from.editor(), this.from.ownView()];
    if (outcome.case === "refused") {
      if (requestId !== kHandedOver) return editor.refusedReply(requestId, outcome.value.message);
      ownView.end();
      return this.from.failed(`Your own view has ended: ${outcome.value.message}`);
    }
    if (outcome.case !== "inForce") return;
    if (!ownView.wanted) return void ownView.tell(outcome.value); // the reply to a change from before the view was left
    // A private view has revisions of its own.
    if (!ownView.isOpen) editor.beginCount();
    ownView.tell(outcome.value);
    if (!outcome.value.scene) return;
    editor.acceptedReply(requestId, outcome.value.revision, ownView.over(valuesOf(outcome.value.scene)));
  }

  /** Where the server has drawn the picture on show, it has to know the own light. */
  pictureShown(): void {
    if (this.from.lightsHere()) return;
    const kept = this.from.ownView().giveBack();
    if (kept.size > 0) this.connection.send({ case: "view", value: { requestId: kHandedOver, scene: sceneOf(kept) } });
  }
}
