// SPDX-License-Identifier: Apache-2.0
// <fanlight-view>: the pictures of a Fanlight server in any page, with the words that have to be beside them. Its
// attributes, events and style are described in element/README.md, its types in element/fanlight-view.d.ts.
import type { Hello, Picture, Scene_Camera, ViewState } from "../../generated/fanlight_pb.js";
import type { FanlightPicture, FanlightState, FanlightViewElement } from "../../element/fanlight-view";
import styles from "../../page/fanlight_view.css";
import { element } from "../element";
import { ageText, markText, stateWord } from "../liveness";
import { noticeFor } from "../notice";
import { uncertainText } from "../uncertain_mark";
import { NewestPicture } from "./newest_picture";
import { OwnTurn } from "./own_turn";
import { PictureSession } from "./picture_session";

const kConditionMs = 250;
const kSettledMs = 200; // after the last change of the element's size

const kStyle = new CSSStyleSheet();
kStyle.replaceSync(styles);

class FanlightView extends HTMLElement implements Pick<FanlightViewElement, "token"> {
  static readonly observedAttributes = ["src", "token", "name", "rate", "turnable"];

  private readonly frame = element("div", { className: "frame" });
  private readonly canvas = element("canvas", { width: 1, height: 1 });
  private readonly mark = element("span", { className: "mark", hidden: true });
  private readonly uncertain = element("span", { className: "uncertain", hidden: true });
  private readonly notice = element("div", { className: "notice" }, element("b", {}), element("span", {}));
  private readonly word = element("span", { className: "word" });
  private readonly age = element("span", { className: "age", title: "Age of the picture" });
  private readonly source = element("span", { className: "source" });
  private readonly notes = element("span", { className: "notes" });
  private readonly mainView = element("button", { type: "button", textContent: "Own view: back to the main view" });
  private readonly picture: NewestPicture;
  private readonly turn: OwnTurn;
  private readonly sizes = new ResizeObserver(() => this.resized());
  private session: PictureSession | undefined;
  private mainCamera: Scene_Camera | undefined;
  private conditionTimer = 0;
  private sizeTimer = 0;
  private restartDue = false;
  private told = "";
  private tokenValue = ""; // set by script: it need not stand in the document

  constructor() {
    super();
    this.picture = new NewestPicture(
      this.canvas,
      (picture) => this.shown(picture),
      (sentence) => this.session?.unreadable(sentence),
    );
    this.turn = new OwnTurn(this.canvas, (body) => this.session?.send(body));
    this.mainView.onclick = () => this.session?.send({ case: "view", value: { leave: true } });
    this.mainView.hidden = true;
    this.canvas.setAttribute("role", "img");
    this.word.setAttribute("role", "status");
    for (const [name, part] of Object.entries({ picture: this.canvas, status: this.word, notice: this.notice }))
      part.setAttribute("part", name);
    const marks = element("div", { className: "marks" }, this.mark, this.uncertain, this.mainView);
    this.frame.append(this.canvas, marks, this.notice);
    const line = element("div", { className: "line" }, this.word, this.age, this.source, this.notes);
    const root = this.attachShadow({ mode: "open" });
    root.adoptedStyleSheets = [kStyle]; // a content policy of the page that forbids inline styles allows it
    root.append(this.frame, line);
  }

  get token(): string {
    return this.tokenValue || (this.getAttribute("token") ?? "");
  }
  set token(token: string) {
    this.tokenValue = token;
    this.restart();
  }

  connectedCallback(): void {
    this.sizes.observe(this);
    this.conditionTimer = window.setInterval(() => this.showCondition(), kConditionMs);
    this.turn.enable(this.hasAttribute("turnable"));
    this.restart();
  }

  disconnectedCallback(): void {
    this.sizes.disconnect();
    window.clearInterval(this.conditionTimer);
    window.clearTimeout(this.sizeTimer);
    this.end();
  }

  attributeChangedCallback(name: string, before: string | null, now: string | null): void {
    if (before === now || !this.isConnected) return;
    if (name !== "turnable") return this.restart();
    this.turn.enable(now !== null);
    if (now === null) this.mainView.click();
  }

  /** Once for all attributes that a script sets together. */
  private restart(): void {
    if (this.restartDue) return;
    this.restartDue = true;
    queueMicrotask(() => {
      this.restartDue = false;
      if (this.isConnected) this.begin();
    });
  }

  private begin(): void {
    this.end();
    const server = this.server();
    const rateHz = Number(this.getAttribute("rate") ?? 0);
    if (!server)
      return this.tell("Wrong address", `src is "${this.getAttribute("src")}", expected http:// or https://`);
    if (!(rateHz >= 0 && rateHz <= 1000))
      return this.tell("Wrong rate", `rate is "${this.getAttribute("rate")}", expected pictures a second, 0 to 1000`);
    const wish = { server, token: this.token, name: this.getAttribute("name") ?? "", rateHz };
    this.session = new PictureSession(wish, {
      hello: (hello) => this.greeted(hello),
      scene: (scene) => this.mainIs(scene.camera),
      picture: (picture) => this.picture.show(picture),
      view: (state) => this.viewIs(state),
      viewRefused: (sentence) => {
        this.turn.answered(undefined);
        this.session?.unreadable(sentence);
      },
      changed: () => this.showCondition(),
    });
    this.session.setSize(this.pixels());
    this.showCondition();
  }

  private end(): void {
    this.session?.dispose();
    this.session = undefined;
    this.picture.forget();
    this.mainView.hidden = true;
  }

  /** Of the server's page; without `src` that of this script. undefined: not an address. */
  private server(): string | undefined {
    try {
      const url = new URL(this.getAttribute("src") ?? import.meta.url, document.baseURI);
      if (!["http:", "https:"].includes(url.protocol)) return undefined;
      return url.href;
    } catch {
      return undefined;
    }
  }

  private greeted(hello: Hello): void {
    this.source.textContent = hello.title || hello.source;
    this.notes.textContent = hello.notes.join(" ");
    this.notes.title = hello.notes.join("\n");
    this.mainView.hidden = true;
    this.mainIs(hello.scene?.scene?.camera);
  }

  private mainIs(camera: Scene_Camera | undefined): void {
    this.mainCamera = camera;
    if (this.mainView.hidden) this.turn.start(camera);
  }

  private viewIs(state: ViewState): void {
    this.mainView.hidden = !state.isPrivate;
    if (state.isPrivate) return this.turn.answered(state);
    this.turn.start(this.mainCamera);
  }

  private pixels(): { width: number; height: number } {
    const { clientWidth, clientHeight } = this.canvas;
    return { width: clientWidth * devicePixelRatio, height: clientHeight * devicePixelRatio };
  }

  private resized(): void {
    window.clearTimeout(this.sizeTimer);
    this.sizeTimer = window.setTimeout(() => this.session?.setSize(this.pixels()), kSettledMs);
  }

  private shown(picture: Picture): void {
    this.session?.shown(picture);
    const { pictureId, volumeId, sceneRevision, captureTimeNs, width, height } = picture;
    const missing = picture.framesMissing;
    write(
      this.uncertain,
      [uncertainText(picture), missing > 0 ? `${missing} frames were lost and are interpolated` : ""]
        .filter((text) => text)
        .join(". "),
    );
    this.frame.style.aspectRatio = `${width} / ${height}`;
    const detail: FanlightPicture = { pictureId, volumeId, sceneRevision, captureTimeNs, width, height };
    this.dispatchEvent(new CustomEvent("fanlight-picture", { detail }));
  }

  private showCondition(): void {
    if (!this.session) return;
    const condition = this.session.condition();
    const { connection, liveness, pictureShown } = condition;
    if (this.session.refusal) return this.tell("No access", this.session.refusal);
    const isOpen = connection.state === "open";
    const word = { connecting: "Connecting", open: stateWord(liveness), lost: "Lost" }[connection.state];
    write(this.word, word + (this.session.isRelayed ? ", sent outside" : ""));
    write(this.age, isOpen ? ageText(liveness.ageMs) : "");
    write(this.mark, pictureShown ? markText(isOpen ? liveness : { ...liveness, state: "not-live" }) : "");
    const isGood = isOpen && ["live", "replay", "ended", "frozen"].includes(liveness.state);
    const notice = noticeFor(condition);
    const state = connection.state === "open" ? liveness.state : connection.state;
    this.become({ state, word, title: notice?.title ?? "", detail: notice?.detail ?? "" }, isGood);
  }

  /** No session, and none will come. */
  private tell(title: string, detail: string): void {
    write(this.word, title);
    write(this.age, "");
    write(this.mark, "Lost");
    this.become({ state: "refused", word: title, title, detail }, false);
  }

  private become({ state, word, title, detail }: FanlightState, isGood: boolean): void {
    this.dataset.state = state;
    this.frame.classList.toggle("stale", !isGood);
    const [first, second] = this.notice.children;
    write(first as HTMLElement, title);
    write(second as HTMLElement, detail);
    this.notice.hidden = title === "";
    const label = `Surface of ${this.source.textContent || "a Fanlight server"}: ${word}`;
    if (this.canvas.ariaLabel !== label) this.canvas.ariaLabel = label;
    const news = JSON.stringify([state, word, title, detail]);
    if (news === this.told) return;
    this.told = news;
    this.dispatchEvent(new CustomEvent<FanlightState>("fanlight-state", { detail: { state, word, title, detail } }));
  }
}

/** Writes only changed text, because a screen reader announces every write; hides what is empty. */
function write(place: HTMLElement, text: string): void {
  if (place.textContent !== text) place.textContent = text;
  if (place.hidden !== (text === "")) place.hidden = text === "";
}

customElements.define("fanlight-view", FanlightView);
