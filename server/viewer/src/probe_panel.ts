// SPDX-License-Identifier: Apache-2.0
// The settings of the probe, and the answers of the server to their changes.
import type { ProbeReply, ProbeStatus } from "../generated/fanlight_pb.js";
import type { Connection } from "./connection";
import { ProbeGroup } from "./probe_group";
import { probeChange, probeValues } from "./probe_settings";
import { SettingsEditor } from "./settings_editor";

export class ProbePanel {
  readonly group: ProbeGroup;
  private readonly editor: SettingsEditor;

  constructor(connection: Pick<Connection, "send">, events: { refused(sentence: string): void; accepted(): void }) {
    this.editor = new SettingsEditor({
      send: (requestId, values) => connection.send(probeChange(requestId, values)),
      changed: () => this.group.refresh(),
      ...events,
    });
    this.group = new ProbeGroup(this.editor);
  }

  /** Call at the end of a session. */
  stop(): void {
    this.editor.stop();
  }

  settle({ requestId, outcome }: ProbeReply): void {
    if (outcome.case === "inForce") {
      this.editor.acceptedReply(requestId, 0n, probeValues(outcome.value));
    } else if (outcome.case === "refused") {
      this.editor.refusedReply(requestId, outcome.value.message);
    }
  }

  tell(status: ProbeStatus): void {
    this.group.tell(status);
  }
}
