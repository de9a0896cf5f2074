// SPDX-License-Identifier: Apache-2.0
// Asks the user for a token, and keeps it in the session storage until the tab is closed.

const kKept = "fanlight-token";

export class LoginForm {
  private readonly input: HTMLInputElement;
  private readonly message: Element;

  constructor(
    private readonly form: HTMLFormElement,
    entered: () => void,
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
      entered();
    };
  }

  get token(): string {
    return sessionStorage.getItem(kKept) ?? "";
  }

  /** Forgets the token, if any, and asks for another one. `sentence`: why the last one was refused, or empty. */
  ask(sentence: string): void {
    sessionStorage.removeItem(kKept);
    this.message.textContent = sentence;
    this.form.hidden = false;
    this.input.focus();
  }
}
