// SPDX-License-Identifier: Apache-2.0
// Asks the user for a token, and keeps it in the session storage until the tab is closed.
import type { Connection } from "./connection";

const kKept = "fanlight-token";

/** The token of this tab; null without one. */
export function keptToken(): string | null {
  return sessionStorage.getItem(kKept);
}

export class LoginForm {
  private readonly input: HTMLInputElement;
  private readonly message: Element;
  /** A token was sent, and the server has not answered yet. */
  isUnderWay = false;

  constructor(
    private readonly form: HTMLFormElement,
    private readonly connection: Pick<Connection, "send" | "end" | "open">,
  ) {
    const input = form.querySelector("input");
    const message = form.querySelector("p");
    if (!input || !message) throw new Error("The page has no place for a token.");
    [this.input, this.message] = [input, message];
    form.onsubmit = (event) => {
      event.preventDefault();
      sessionStorage.setItem(kKept, this.input.value.trim());
      this.input.value = "";
      this.form.hidden = true;
      connection.open();
    };
  }

  /** The server needs a token: sends the stored one; without one, or after a refusal, asks the user. */
  needed(refusal: string): void {
    const token = sessionStorage.getItem(kKept);
    this.isUnderWay = Boolean(token) && !refusal;
    if (token && !refusal) return this.connection.send({ case: "login", value: { token } });
    this.connection.end(); // the server waits ten seconds for a login, a user may need longer
    this.ask(refusal);
  }

  /** Forgets the token, if any, and asks for another one. `sentence`: why the last one was refused, or empty. */
  private ask(sentence: string): void {
    sessionStorage.removeItem(kKept);
    this.message.textContent = sentence;
    this.form.hidden = false;
    this.input.focus();
  }
}
