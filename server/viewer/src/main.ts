// SPDX-License-Identifier: Apache-2.0
// The page: creates its parts and connects them. Each message from the server goes to its parts from here.
import {
  Role,
  type ControlState,
  type Hello,
  type Picture,
  type ProbeStatus,
  type SceneState,
  type ServerMessage,
  type ViewState,
} from "../generated/fanlight_pb.js";
import { bannerAt } from "./banner";
import { ConditionView, previewOf } from "./condition_view";
import { Connection, streamUrl } from "./connection";
import { ControlBar, controlText } from "./control_bar";
import { Controls } from "./controls";
import { CineBar } from "./cine_bar";
import { find } from "./element";
import { FieldEffects, unknownNames } from "./field_effects";
import { LightHandles } from "./light_handles";
import { LoginForm } from "./login_form";
import { LivenessWatch } from "./liveness";
import { MeasuredValues } from "./measured_values";
import { listNotes } from "./notes";
import { kNothingKnown, type Condition } from "./notice";
import { Orbit } from "./orbit";
import { OutwardButtons } from "./outward_buttons";
import { kOwnGroups, OwnView } from "./own_view";
import { page } from "./page";
import { PageShell } from "./page_shell";
import { PictureInput } from "./picture_input";
import { PictureOverlay } from "./picture_overlay";
import { PictureStream } from "./picture_stream";
import { ProbePanel } from "./probe_panel";
import { ProbeWatch } from "./probe_watch";
import { QuickPanel } from "./quick_panel";
import { RecentWarnings } from "./recent_warnings";
import { RecordingBar } from "./recording_bar";
import { inPlainWords, titlesOf } from "./refusal_text";
import { ReplayBar } from "./replay_bar";
import { valuesOf, type Values } from "./scene";
import { SceneChanges } from "./scene_changes";
import { sameSettings } from "./same_settings";
import { ServerClock } from "./server_clock";
import { SettingsEditor } from "./settings_editor";
import { connectShortcuts } from "./shortcuts";
import { guardSliders } from "./slider_guard";
import { SliceClick } from "./slice_click";
import { StatisticsView } from "./statistics";
import { SurfaceFinder } from "./surface_finder";
import { Tools } from "./tools";
import type { PagePoint } from "./view_geometry";

const kProtocolVersion = 2;
const [kClockMs, kConditionMs] = [500, 250];

guardSliders(document.body);
const showRefusal = (sentence: string) => shell.showRefusal(inPlainWords(sentence, titlesOf(hello?.fields ?? [])));
const clock = new ServerClock();
const liveness = new LivenessWatch((pageMs) => clock.at(pageMs));
const condition: Condition = { ...kNothingKnown, liveness: liveness.news(0) };
const warnings = new RecentWarnings();
let hello: Hello | undefined;
let defaults: Values = new Map();
let controls: Controls | undefined;
let shown: Picture | undefined;
let mayChange = true;

const probe = new ProbeWatch(
  (pageMs) => clock.at(pageMs),
  (pageMs) => Date.now() - performance.now() + pageMs,
);
const conditionView = new ConditionView({
  root: document.documentElement,
  connection: find("#connection", HTMLElement),
  frame: page.frame,
  notLive: find("#not-live", HTMLElement),
  rendering: find("#rendering", HTMLElement),
  notice: find("#notice", HTMLElement),
});
const statistics = new StatisticsView(document, clock);
const connection = new Connection(streamUrl(), {
  connecting: () => showCondition({ connection: { state: "connecting" } }),
  message: receive,
  lost: (sentence) => {
    editor.stop();
    probePanel.stop();
    overlay.clip.sessionEnded();
    page.refusal.hidden = true;
    showCondition({ connection: { state: "lost", sentence, retrying: true }, serverError: undefined });
  },
});
const changes: SceneChanges = new SceneChanges(connection, {
  ownView: () => ownView,
  lightsHere: () => pictures.surface.isWhole,
  editor: () => editor,
  failed: showRefusal,
});
const editor: SettingsEditor = new SettingsEditor({
  edited: (...change) => quickPanel.edited(...change),
  send: (requestId, values) => changes.send(requestId, values),
  paceMs: (names) => changes.paceMs(names),
  changed: showScene,
  refused: (sentence) => {
    quickPanel.refused();
    showRefusal(sentence);
  },
  accepted: () => shell.hideRefusal(),
});
const probePanel = new ProbePanel(connection, { refused: showRefusal, accepted: () => shell.hideRefusal() });
const effects = new FieldEffects(editor);
const measured = new MeasuredValues(editor);
const isLit = () => effects.missing("light") === undefined;
const light = new LightHandles(editor, page.canvas, page.lampMarkers, isLit);
const movesRays = () => !ownView.wanted;
const orbit = new Orbit(editor, page.canvas, movesRays);
const pictures: PictureStream = new PictureStream(editor, connection, {
  shown: pictureShown,
  turned: () => showBusy(),
  drawn: () => overlay.drawn(),
  unreadable: (sentence) => showCondition({ serverError: sentence }),
});
const { view, codec } = pictures;
const login = new LoginForm(page.login, connection);
const controlBar = new ControlBar(page.control, (wish, toSession) =>
  connection.send({ case: "control", value: { wish, toSession } }),
);
const recordingBar = new RecordingBar(find("#recording", HTMLElement), (requestId, wish) =>
  connection.send({ case: "recording", value: { requestId, wish } }),
);
const replayBar = new ReplayBar(find("#replay", HTMLElement), (requestId, wish) =>
  connection.send({ case: "replay", value: { requestId, ...wish } }),
);
const ownView: OwnView = new OwnView(page.ownView, {
  chosen: () => ownViewChosen(),
  leave: () => connection.send({ case: "view", value: { leave: true } }),
  backTo: (main) => {
    startEditor(main);
    ownViewChosen();
  },
});
const cineBar = new CineBar(
  page.cine,
  (wish) => connection.send({ case: "cine", value: wish }),
  (held) => [view, liveness].forEach((part) => part.hold(held)),
  pictures.kept,
);
const overlay: PictureOverlay = new PictureOverlay(editor, codec, {
  hello: () => hello,
  shown: () => shown,
  isPreview: () => pictures.surface.isTurned,
  isFrozen: () => cineBar.isStill,
  isCurrent: () => shown?.privateView === ownView.isOpen && !cineBar.isHeld && editor.isShownBy(shown.sceneRevision),
  mayFreeze: () => cineBar.mayFreeze,
  freeze: () => cineBar.still(),
  surfaceAt: (pixel) => pictures.surface.pointAt(pixel),
  drawnView: () => pictures.surface.drawnView,
  dateOf: (serverMs) => (liveness.isReplay ? undefined : clock.dateOf(serverMs)),
  send: (body) => connection.send(body),
  failed: showRefusal,
});
const tools = new Tools(page.tools, page.canvas, (tool) => overlay.choose(tool));
const sliceClick = new SliceClick(editor, page.canvas, movesRays);
const clicked = (pointer: PagePoint) => void (overlay.clicked(pointer) || sliceClick.clicked(pointer));
new PictureInput(page.canvas, page.frame, () => tools.chosen(), light, orbit, clicked, doubleClicked, overlay.strokes);
const quickPanel: QuickPanel = new QuickPanel(editor, effects, light, {
  fields: () => hello?.fields ?? [],
  found: () => finder.found ?? defaults,
  ask: (wish, withCuts) => connection.send({ case: "preset", value: { requestId: 0n, wish, withCuts } }),
  failed: showRefusal,
});
const shell = new PageShell(showRefusal);
const outward = new OutwardButtons(overlay, cineBar, showRefusal);
connectShortcuts({ cineBar, quickPanel, tools, overlay, shell });
page.resetView.onclick = () => orbit.reset();
const askSurvey = (requestId: bigint) => connection.send({ case: "survey", value: { requestId } });
const finder: SurfaceFinder = new SurfaceFinder(page.findSurface, bannerAt("#found"), quickPanel, askSurvey);
window.setInterval(askClock, kClockMs);
window.setInterval(() => showCondition({}), kConditionMs);
connection.open();

function receive({ body }: ServerMessage): void {
  liveness.heard(performance.now());
  switch (body.case) {
    case "hello":
      return begin(body.value);
    case "picture":
      overlay.clip.take(body.value);
      return view.show(body.value);
    case "presets":
      return quickPanel.takePresets(body.value);
    case "statistics":
      return statistics.counters(body.value);
    case "liveness":
      liveness.tell(body.value);
      return showCondition({});
    case "scene":
      return sceneTold(body.value);
    case "sceneReply":
      return changes.settle(body.value);
    case "surveyReply":
      return finder.answered(body.value);
    case "viewReply":
      return changes.settleView(body.value);
    case "view":
      return viewTold(body.value);
    case "probeStatus":
      return probeTold(body.value);
    case "probeReply":
      return probePanel.settle(body.value);
    case "clockReply":
      return clock.add(body.value.clientTimeMs, body.value.serverTimeNs, performance.now());
    case "control":
      return controlTold(body.value);
    case "controlReply":
      if (body.value.outcome.case === "refused") return showRefusal(body.value.outcome.value.message);
      if (body.value.outcome.case === "state") controlTold(body.value.outcome.value);
      return shell.hideRefusal();
    case "recording":
      return recordingBar.tell(body.value);
    case "replay":
      replayBar.tell(body.value);
      return void (cineBar.isReplay = replayBar.isShown);
    case "relay":
      return void page.relay.toggleAttribute("hidden", !body.value.sending);
    case "cine":
      cineBar.tell(body.value);
      showBusy();
      return overlay.measurement.frozenChanged();
    case "depthReply":
    case "fluidReply":
    case "measurements":
      return overlay.take(body);
    case "streamReply": // the page asks by itself: an answer says nothing of what was refused before
      return body.value.outcome.case === "refused" ? showRefusal(body.value.outcome.value.message) : undefined;
    case "presetReply":
    case "measurementReply":
    case "recordingReply":
    case "cineReply":
    case "replayReply":
      if (body.value.outcome.case === "refused") return showRefusal(body.value.outcome.value.message);
      return shell.hideRefusal();
    case "loginNeeded":
      return login.needed("");
    case "error":
      if (login.isUnderWay) return login.needed(body.value.message);
      return showCondition({ serverError: body.value.message });
  }
}

function begin(newHello: Hello): void {
  if (newHello.protocolVersion !== kProtocolVersion) {
    connection.end();
    const sentence = `The server speaks protocol ${newHello.protocolVersion}, this page ${kProtocolVersion}: reload it.`;
    return showCondition({ connection: { state: "lost", sentence, retrying: false } });
  }
  login.isUnderWay = false;
  for (const part of [clock, probe, finder]) part.reset();
  liveness.reset(performance.now());
  probePanel.group.forget();
  askClock();
  statistics.start(newHello);
  // A new session usually offers the same settings. Then they stay as they are, with their scroll position.
  if (!hello || !sameSettings(hello, newHello)) {
    defaults = newHello.defaultScene ? valuesOf(newHello.defaultScene) : new Map();
    orbit.start(newHello.fields, defaults);
    const unknown = unknownNames(newHello.fields);
    if (unknown.length > 0) console.warn(`The page knows settings that the server lacks: ${unknown.join(", ")}`);
    controls = new Controls(page.form, editor, effects, newHello, defaults, probePanel.group.root, measured);
  }
  hello = newHello;
  outward.allow(newHello.role !== Role.VIEWER);
  cineBar.start();
  view.start();
  overlay.start();
  quickPanel.start(hello);
  if (hello.control) controlTold(hello.control);
  codec.start();
  page.source.textContent = hello.title || hello.source;
  page.source.title = `Where the frames come from: ${hello.source}`;
  listNotes(page.notes, hello.notes);
  ownView.forget();
  if (hello.scene) {
    ownView.mainIs(hello.scene);
    startEditor(hello.scene);
  }
  ownViewChosen();
  showCondition({ connection: { state: "open" }, source: hello.title || hello.source, pictureShown: false });
}

function controlTold(state: ControlState): void {
  if (!hello) return;
  const text = controlText(state, hello.role, hello.sessionId);
  mayChange = text.mayChange;
  controlBar.show(text);
  showCondition({});
}

function startEditor({ revision, scene }: SceneState): void {
  if (hello && scene) editor.start(hello.fields, revision, valuesOf(scene));
}

/** Switches the target of later changes between this display's own view and the main view. */
function ownViewChosen(): void {
  quickPanel.forgetChanges();
  controls?.limitTo(ownView.wanted ? kOwnGroups : undefined);
  probePanel.group.root.inert = ownView.wanted;
  showCondition({});
}

function viewTold(state: ViewState): void {
  const ended = ownView.tell(state);
  if (ended) return showRefusal(ended);
  if (ownView.isOpen && state.scene) editor.adopt(state.revision, ownView.over(valuesOf(state.scene)));
}

function sceneTold(state: SceneState): void {
  const { revision, scene, defaultScene, withdrawn } = state;
  ownView.mainIs(state);
  if (defaultScene && hello) {
    hello.defaultScene = defaultScene;
    listNotes(page.notes, state.notes);
    for (const [name, value] of valuesOf(defaultScene)) defaults.set(name, value); // the controls hold the same map
    orbit.start(hello.fields, defaults);
    finder.reset();
  }
  if (scene && !ownView.isOpen) editor.adopt(revision, ownView.over(valuesOf(scene)));
  if (withdrawn) showRefusal(withdrawn);
}

function probeTold(status: ProbeStatus): void {
  probe.tell(status.state, performance.now());
  probePanel.tell(status);
  showCondition({ probeTrouble: status.trouble });
}

function pictureShown(picture: Picture): void {
  const news = picture.volumeId !== shown?.volumeId || !condition.pictureShown;
  shown = picture;
  changes.pictureShown();
  for (const each of [probe, liveness]) each.show(Number(picture.captureTimeNs) / 1e6);
  statistics.picture(picture);
  if (measured.take(picture.levels, picture.surfaceShare)) controls?.refresh();
  light.placeMarkers(); // the size of the picture may have changed
  quickPanel.take(picture);
  overlay.show(picture);
  cineBar.pictureShown();
  showBusy();
  warnings.take(picture.warnings, performance.now());
  if (news) showCondition({ pictureShown: true, serverError: undefined, hasNoSurface: measured.hasNoSurface() });
}

function showScene(): void {
  controls?.refresh();
  showCondition({ hasNoSurface: measured.hasNoSurface() });
  view.relight();
  quickPanel.refresh();
  overlay.refresh();
  tools.offerLight(isLit());
  light.placeMarkers();
  showBusy();
}

/** The canvas is busy until it shows the scene that was requested last. */
function showBusy(): void {
  const isOld = !shown || shown.privateView !== ownView.isOpen || !editor.isShownBy(shown.sceneRevision);
  const busy = isOld || cineBar.isBehind;
  page.canvas.ariaBusy = String(busy);
  quickPanel.setBusy(busy);
  conditionView.setBusy(busy, previewOf(shown, pictures.surface.isTurned), performance.now());
  conditionView.showRendering(condition, performance.now());
}

function showCondition(change: Partial<Condition>): void {
  const nowMs = performance.now();
  const news = { probe: probe.news(nowMs), liveness: liveness.news(nowMs), warnings: warnings.recent(nowMs) };
  Object.assign(condition, change, news);
  // After a probe's return only a volume from after it is live.
  if (condition.liveness.state === "live" && !probe.isLive()) condition.liveness.state = "not-live";
  const open = condition.connection.state === "open";
  for (const bar of [recordingBar, replayBar]) bar.allow(open && mayChange);
  cineBar.allow(open && mayChange && !ownView.wanted, open);
  page.findSurface.disabled = !open || !mayChange || ownView.wanted;
  const closed = !open || !(mayChange || ownView.wanted);
  page.form.inert = page.resetView.disabled = closed;
  quickPanel.allow(!closed, ownView.wanted);
  overlay.allow(!closed, ownView.wanted);
  conditionView.show(condition);
  showBusy();
}

function doubleClicked(pointer: PagePoint): void {
  if (["measure", "note", "cut"].includes(tools.chosen()) || quickPanel.enlarges(pointer, page.canvas)) return;
  if (tools.chosen() === "orbit") orbit.reset();
}

function askClock(): void {
  connection.send({ case: "clockRequest", value: { clientTimeMs: performance.now() } });
}
