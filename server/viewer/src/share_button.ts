// SPDX-License-Identifier: Apache-2.0
// Saves the surface of the main view as an HTML file, which the server makes, and notes in its audit log.
import { callApi } from "./api";
import { saveFile, timeInName } from "./save_file";

export class ShareButton {
  constructor(
    private readonly button: HTMLButtonElement,
    private readonly failed: (sentence: string) => void,
  ) {
    button.onclick = () => void this.share();
  }

  /** Whether this display's role may share. */
  allow(may: boolean): void {
    this.button.hidden = !may;
  }

  private async share(): Promise<void> {
    this.button.disabled = true;
    try {
      const response = await callApi("api/surface.html");
      saveFile(await response.blob(), `fanlight-${timeInName()}.html`);
    } catch (error) {
      this.failed(`The surface was not saved: ${(error as Error).message}`);
    }
    this.button.disabled = false;
  }
}
