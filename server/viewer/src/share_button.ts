// SPDX-License-Identifier: Apache-2.0
// Saves the surface of the main view as an HTML file, which the server makes, and notes in its audit log.
import { keptToken } from "./login_form";
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
      const token = keptToken();
      const response = await fetch("api/surface.html", token ? { headers: { Authorization: `Bearer ${token}` } } : {});
      if (!response.ok) throw new Error(await sentenceOf(response));
      saveFile(await response.blob(), `fanlight-${timeInName()}.html`);
    } catch (error) {
      this.failed(`The surface was not saved: ${(error as Error).message}`);
    }
    this.button.disabled = false;
  }
}

/** What the server says in a refusal. */
async function sentenceOf(response: Response): Promise<string> {
  const text = await response.text();
  try {
    return (JSON.parse(text) as { error: { message: string } }).error.message;
  } catch {
    return text.trim() || `the server answers ${response.status}`;
  }
}
