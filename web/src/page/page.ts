// The page around the component.

import { type GnomonViewer, KEYS } from "../gnomon-viewer";
import type { BuiltIn, Link, ReferenceState, SceneFile, Shown, Status } from "../protocol";
import { chosen, dropped } from "../files";
import { Panel, make } from "./panel";

const element = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;
const viewer = element<GnomonViewer>("viewer");
const body = document.body;

// --- messages -------------------------------------------------------------------------------------------------------

const MOST_NOTICES = 4;
const NOTICE_LASTS = 12_000;

function notice(text: string, isBad = false): void {
  const list = element("notices");
  const line = make("p", isBad ? { class: "bad" } : {}, make("span", {}, text));
  line.append(make("button", { type: "button", "aria-label": "dismiss", click: () => line.remove() }, "✕"));
  list.append(line);
  while (list.children.length > MOST_NOTICES) list.firstElementChild?.remove();
  // What went wrong stays until it is dismissed or pushed out.
  if (!isBad) setTimeout(() => line.remove(), NOTICE_LASTS);
}

function fail(error: unknown): void {
  const text = error instanceof Error ? error.message : String(error);
  // A sentence that begins with a file's name keeps it.
  const sentence = text.replace(/^[a-z]+(?= )/, (word) => word.charAt(0).toUpperCase() + word.slice(1));
  notice(sentence + (/[.!?]$/.test(text) ? "" : "."), true);
}

viewer.addEventListener("error", (event) => {
  if (!viewer.loaded) element("caption").textContent = "";
  fail((event as Event as CustomEvent).detail.message);
});

// --- what a link carries --------------------------------------------------------------------------------------------

interface PageLink extends Link {
  scene?: string;
  environment?: string;
}

/** What came by name or by address. */
const came: { scene?: string; environment?: string } = {};

function readLink(): PageLink {
  const text = location.hash.slice(1);
  if (!text) return {};
  try {
    return JSON.parse(decodeURIComponent(text)) as PageLink;
  } catch {
    notice("The link's settings cannot be read, so the page opened without them.", true);
    return {};
  }
}

const { scene, environment, ...settings } = readLink();
if (scene) viewer.src = came.scene = scene;
if (environment) viewer.environmentImage = came.environment = environment;
viewer.link = settings;

// --- scenes and environments ----------------------------------------------------------------------------------------

const scenes = element<HTMLSelectElement>("scene");
const environments = element<HTMLSelectElement>("environment");

/** Known once there is a session. */
let builtIn: BuiltIn = { scenes: [], environments: [] };

function fill(list: HTMLSelectElement, names: readonly string[], now: string): void {
  const all = names.includes(now) || !now ? names : [...names, now];
  const shape = all.join("\n");
  if (list.dataset.shape !== shape) {
    list.dataset.shape = shape;
    list.replaceChildren(...all.map((name) => make("option", { value: name }, name)));
  }
  if (document.activeElement !== list || list.value === "") list.value = now;
}

scenes.addEventListener("change", () => {
  if (!builtIn.scenes.includes(scenes.value)) return;
  came.scene = scenes.value;
  viewer.openBuiltIn(scenes.value).catch(fail);
});
environments.addEventListener("change", () => {
  if (!builtIn.environments.includes(environments.value)) return;
  came.environment = environments.value;
  viewer.setEnvironment(environments.value).catch(fail);
});

async function open(files: SceneFile[]): Promise<void> {
  try {
    const opened = await viewer.openFiles(files);
    // What was dropped is in no link.
    if (opened.scene) delete came.scene;
    if (opened.environment) delete came.environment;
  } catch (error) {
    fail(error);
  }
}

const input = element<HTMLInputElement>("files");
element("open").addEventListener("click", () => input.click());
input.addEventListener("change", () => {
  if (input.files?.length) void open(chosen(input.files)).finally(() => (input.value = ""));
});

let dragged = 0;
const drop = element("drop");
addEventListener("dragenter", (event) => {
  event.preventDefault();
  dragged += 1;
  drop.hidden = false;
});
addEventListener("dragleave", () => {
  dragged = Math.max(0, dragged - 1);
  drop.hidden = dragged === 0;
});
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => {
  event.preventDefault();
  dragged = 0;
  drop.hidden = true;
  if (event.dataTransfer) dropped(event.dataTransfer).then(open, fail);
});

// --- panel ----------------------------------------------------------------------------------------------------------

const toggle = element("panel-toggle");
function showPanel(show: boolean): void {
  body.classList.toggle("wide", !show);
  toggle.setAttribute("aria-expanded", String(show));
}
toggle.addEventListener("click", () => showPanel(body.classList.contains("wide")));
showPanel(innerWidth > 760);

element("keys").append(...KEYS.flatMap(([keys, does]) => [make("dt", {}, keys), make("dd", {}, does)]));

let panel: Panel | undefined;
let asking = false;
let askAgain = false;

/** Brings panel and map up to date; one question at a time. */
async function refresh(): Promise<void> {
  if (asking) {
    askAgain = true;
    return;
  }
  asking = true;
  try {
    const client = await viewer.client();
    panel ??= new Panel(element("options"), element("material"), client, fail);
    const [sections, material, names] = await client.call("panel");
    builtIn = names;
    panel.show(sections, material);
  } catch {
    // The element says why there is no session.
  }
  asking = false;
  if (askAgain) {
    askAgain = false;
    void refresh();
  }
}

let mapOf = "";
async function refreshMap(status: Status): Promise<void> {
  const of = `${status.environment} ${status.lights} ${opened}`;
  if (of === mapOf || status.loading) return;
  mapOf = of;
  const map = element<HTMLCanvasElement>("map");
  const pixels = await (await viewer.client()).call("map", map.width);
  const picture = new ImageData(new Uint8ClampedArray(pixels.buffer), map.width, map.height);
  map.getContext("2d")?.putImageData(picture, 0, 0);
  element("lights").textContent = `${status.lights} lights stand for the environment; what is left is ambient light, shadowed too.`;
}

// --- status ---------------------------------------------------------------------------------------------------------

let wasLoading = true;
let opened = 0;

viewer.addEventListener("status", (event) => {
  const status = (event as CustomEvent<Status>).detail;
  for (const { is_error, text } of status.notices) if (!is_error) notice(text);
  fill(scenes, builtIn.scenes, status.scene);
  fill(environments, builtIn.environments, status.environment);
  const [width, height] = status.drawn;
  element("caption").textContent = [
    `${status.triangles.toLocaleString("en")} triangles`,
    `${status.lights} lights`,
    `${width} × ${height}`,
    status.loading ? "loading…" : status.moving ? `${(1000 / Math.max(1, status.frameMs)).toFixed(0)} frames a second` : `${status.frameMs.toFixed(0)} ms`,
  ].join(" · ");
  element("level").textContent = `${status.adapter ? `${status.adapter}: ` : ""}${status.level}.`;
  element("animation").hidden = status.clips === 0;
  element("play").textContent = status.playing ? "Pause" : "Play";
  element("time").textContent = status.duration === null ? "" : `${status.time.toFixed(2)} of ${status.duration.toFixed(2)} s`;
  if (element<HTMLDetailsElement>("speed").open) {
    element("passes").querySelector("tbody")?.replaceChildren(
      ...status.passes.map(({ name, milliseconds }) => make("tr", {}, make("td", {}, name), make("td", {}, `${milliseconds.toFixed(2)} ms`))),
    );
  }
  if (wasLoading && !status.loading) opened += 1;
  wasLoading = status.loading;
  if (!status.moving || status.playing) void refresh();
  refreshMap(status).catch(fail);
});

element("play").addEventListener("click", () => void (viewer.paused ? viewer.play() : viewer.pause()).catch(fail));
element<HTMLSelectElement>("rate").addEventListener("change", async (event) => {
  const rate = Number((event.target as HTMLSelectElement).value);
  await (await viewer.client()).call("holdFrameRate", rate).catch(fail);
});

// --- without shadows ------------------------------------------------------------------------------------------------

const split = element("split");
const handle = element("handle");
const tags = [element("tag-left"), element("tag-right")];
let boundary = 0.5;

function showBoundary(): void {
  handle.style.left = `${100 * boundary}%`;
  handle.setAttribute("aria-valuenow", String(Math.round(100 * boundary)));
  element("without").style.clipPath = `inset(0 ${100 - 100 * boundary}% 0 0)`;
}

split.addEventListener("click", async () => {
  const on = split.getAttribute("aria-pressed") !== "true";
  if (on && truthIsShown()) await showTruth(undefined);
  split.setAttribute("aria-pressed", String(on));
  handle.hidden = !on;
  for (const tag of tags) tag.hidden = !on;
  // A canvas can be given away once: another one takes its place.
  const canvas = make("canvas", { id: "without", "aria-hidden": "true", hidden: !on });
  element("without").replaceWith(canvas);
  showBoundary();
  const client = await viewer.client();
  await client.call("setSplit", on ? canvas.transferControlToOffscreen() : undefined).catch(fail);
});

function moveBoundary(to: number): void {
  boundary = Math.min(1, Math.max(0, to));
  showBoundary();
}
handle.addEventListener("pointerdown", (event) => handle.setPointerCapture(event.pointerId));
handle.addEventListener("pointermove", (event) => {
  if (!handle.hasPointerCapture(event.pointerId)) return;
  const { left, width } = element("stage").getBoundingClientRect();
  moveBoundary((event.clientX - left) / width);
});
handle.addEventListener("keydown", (event) => {
  const to = { ArrowLeft: boundary - 0.02, ArrowRight: boundary + 0.02, Home: 0, End: 1 }[event.key];
  if (to === undefined) return;
  event.preventDefault();
  moveBoundary(to);
});

// --- reference ------------------------------------------------------------------------------------------------------

const reference = element("reference");
const truth = element<HTMLCanvasElement>("truth");

function truthIsShown(): boolean {
  return reference.getAttribute("aria-pressed") === "true";
}

async function showTruth(shown: Shown | undefined): Promise<void> {
  reference.setAttribute("aria-pressed", String(shown !== undefined));
  element("truth-bar").hidden = shown === undefined;
  truth.hidden = true;
  element("error").textContent = "tracing…";
  await (await viewer.client()).call("showReference", shown).catch(fail);
}

function shownNow(): Shown {
  return (document.querySelector<HTMLInputElement>("input[name=shown]:checked")?.value ?? "reference") as Shown;
}

reference.addEventListener("click", () => {
  if (split.getAttribute("aria-pressed") === "true") split.click();
  void showTruth(truthIsShown() ? undefined : shownNow());
});
for (const radio of document.querySelectorAll("input[name=shown]")) {
  radio.addEventListener("change", () => void showTruth(shownNow()));
}

viewer.onreference = (state: ReferenceState | undefined) => {
  truth.hidden = state === undefined || !truthIsShown();
  if (!state) {
    element("error").textContent = "tracing…";
    return;
  }
  truth.width = state.width;
  truth.height = state.height;
  truth.getContext("2d")?.putImageData(new ImageData(new Uint8ClampedArray(state.picture.buffer), state.width, state.height), 0, 0);
  const percent = (share: number) => `${(100 * share).toPrecision(2)} %`;
  const noise = state.noise > 0 ? `, of that ${percent(state.noise)} noise of the reference` : "";
  element("error").textContent = `error ${percent(state.error)}${noise}; ${state.samples} samples a pixel`;
};

// --- saving ---------------------------------------------------------------------------------------------------------

function save(name: string, blob: Blob): void {
  const link = make("a", { download: name, href: URL.createObjectURL(blob) });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

element("save-png").addEventListener("click", () => {
  viewer.toBlob().then((blob) => save("gnomon.png", blob), fail);
});
element("save-scene").addEventListener("click", async () => {
  try {
    const text = await (await viewer.client()).call("sceneFile");
    save("gnomon.toml", new Blob([text], { type: "application/toml" }));
  } catch (error) {
    fail(error);
  }
});
element("copy-link").addEventListener("click", async () => {
  try {
    const changes = await (await viewer.client()).call("link");
    const link: PageLink = { ...came, ...changes };
    const address = new URL(location.href);
    address.hash = encodeURIComponent(JSON.stringify(link));
    history.replaceState(null, "", address);
    await navigator.clipboard?.writeText(address.href).then(() => notice("The link is on the clipboard."), () => notice("The link is in the address bar."));
    const status = viewer.status;
    const isKnown = status && (came.scene ?? builtIn.scenes[0]) === status.scene;
    if (!isKnown && !came.scene) notice("The files that you dropped are not part of the link.");
  } catch (error) {
    fail(error);
  }
});
