// SPDX-License-Identifier: Apache-2.0
// What belongs to the page and not to the scene: full screen, the statistics, the panel of a small screen, refusals.
import { page } from "./page";

const kRefusalMs = 12_000;

export class PageShell {
  private refusalTimer = 0;

  constructor(private readonly failed: (sentence: string) => void) {
    page.fullScreen.hidden = !document.fullscreenEnabled; // an iPhone has none
    page.fullScreen.onclick = () => this.toggleFullScreen();
    document.addEventListener("fullscreenchange", () => {
      page.fullScreen.ariaPressed = String(document.fullscreenElement !== null);
    });
    page.showStatistics.onclick = () => this.toggleStatistics();
    page.showPanel.onclick = () => {
      page.showPanel.ariaExpanded = String(page.panel.classList.toggle("open"));
    };
    page.refusal.querySelector("button")!.onclick = () => this.hideRefusal();
  }

  toggleFullScreen(): void {
    if (!document.fullscreenEnabled) return;
    const done = document.fullscreenElement ? document.exitFullscreen() : document.documentElement.requestFullscreen();
    done.catch((error: Error) => this.failed(`The browser allows no full screen: ${error.message}`));
  }

  toggleStatistics(): void {
    page.statistics.hidden = !page.statistics.hidden;
    page.showStatistics.ariaExpanded = String(!page.statistics.hidden);
  }

  /** It goes by itself after a while, or with its button. */
  showRefusal(sentence: string): void {
    page.refusal.firstElementChild!.textContent = sentence;
    page.refusal.hidden = false;
    window.clearTimeout(this.refusalTimer);
    this.refusalTimer = window.setTimeout(() => this.hideRefusal(), kRefusalMs);
  }

  hideRefusal(): void {
    page.refusal.hidden = true;
  }
}
