// The component <gnomon-viewer>.

import { Client } from "./client";
import { fetched, sorted } from "./files";
import { navigate } from "./navigation";
import type { Link, ReferenceState, Request, SceneFile, Status } from "./protocol";

export type * from "./protocol";
export { KEYS } from "./navigation";
export type { Client } from "./client";

/** What is shown where nothing is asked for. */
const SCENE = "three-boxes";
const ENVIRONMENT = "room";

/** Addresses have an extension; what is built in goes by a mere name. */
function isBuiltIn(name: string): boolean {
  return /^[\w-]+$/.test(name);
}

/** Sharper pictures than that are not worth their time. */
const MOST_PIXELS_A_POINT = 2;

const STYLE = `
:host { display: block; position: relative; width: 300px; height: 300px; overflow: hidden; background: #15171a; contain: content; }
:host([hidden]) { display: none; }
canvas, img, slot[name="poster"]::slotted(*) { position: absolute; inset: 0; width: 100%; height: 100%; display: block; }
img { object-fit: cover; }
#picture { touch-action: none; outline-offset: -3px; }
#picture:focus-visible { outline: 3px solid #4c8dff; }
.gone { visibility: hidden; }
#bar { position: absolute; left: 0; right: 0; top: 0; height: 3px; background: #4c8dff; transform-origin: left; transition: transform .2s; }
#bar.endless { animation: endless 1.2s linear infinite; }
@keyframes endless { from { transform: translateX(-60%) scaleX(.6); } to { transform: translateX(100%) scaleX(.6); } }
@media (prefers-reduced-motion: reduce) { #bar.endless { animation-duration: 6s; } }
#told { position: absolute; inset: 0; display: grid; place-items: center; padding: 1rem; text-align: center; font: 1rem/1.5 system-ui, sans-serif;
  color: #f2f3f5; background: #15171acc; }
#told:empty { display: none; }
`;

/**
 * A scene lit by an environment map.
 *
 * Attributes as those of `<model-viewer>`: `src`, `environment-image`, `poster`, `alt`, `camera-controls`, `autoplay`, `animation-name`.
 * `environment` is short for `environment-image`. Both take the name of what is built in, or an address. `options` sets whatever
 * `gnomon render --help` lists: `options="light-count=24; exposure=1"`.
 *
 * Events: `load`, `error`, `progress`, `camera-change`, `play`, `pause`; `status` with every change of what is told of the session.
 */
export class GnomonViewer extends HTMLElement {
  static readonly observedAttributes = ["src", "environment-image", "environment", "alt", "poster", "animation-name", "options", "camera-controls"];
  #client: Client | undefined;
  #canvas: HTMLCanvasElement | undefined;
  #opening: Promise<void> = Promise.resolve();
  #navigation: AbortController | undefined;
  #sizes: ResizeObserver | undefined;
  #status: Status | undefined;
  #loaded = false;
  #link: Link | undefined;
  /** Whether the session has been asked for: until then attributes and link are what it begins with. */
  #begun = false;
  readonly #root: ShadowRoot;
  readonly #bar: HTMLElement;
  readonly #told: HTMLElement;
  readonly #poster: HTMLImageElement;

  /** Told what there is of the reference while it is shown. */
  onreference: (state: ReferenceState | undefined) => void = () => {};

  constructor() {
    super();
    this.#root = this.attachShadow({ mode: "open" });
    this.#root.innerHTML = `<style>${STYLE}</style><img id="poster" class="gone" alt=""><slot name="poster"></slot><slot></slot>
<div id="told" role="status"></div><div id="bar" class="gone" role="progressbar" aria-label="loading" aria-valuemin="0" aria-valuemax="100"></div>`;
    const part = <T extends HTMLElement>(id: string) => this.#root.getElementById(id) as T;
    this.#bar = part("bar");
    this.#told = part("told");
    this.#poster = part<HTMLImageElement>("poster");
  }

  connectedCallback(): void {
    this.#showPoster();
    this.#sizes = new ResizeObserver(() => this.#resize());
    this.#sizes.observe(this);
    document.addEventListener("visibilitychange", this.#visibility);
    this.#opening = this.#open();
  }

  disconnectedCallback(): void {
    document.removeEventListener("visibilitychange", this.#visibility);
    this.#sizes?.disconnect();
    this.#navigation?.abort();
    this.#client?.close();
    this.#canvas?.remove();
    this.#client = this.#canvas = this.#status = undefined;
    this.#loaded = this.#begun = false;
  }

  attributeChangedCallback(name: string, before: string | null, value: string | null): void {
    if (before === value || !this.isConnected) return;
    const failed = (error: unknown) => this.#fail(error);
    const begins = !this.#begun && ["src", "environment", "environment-image", "animation-name", "options"].includes(name);
    if (begins) return;
    switch (name) {
      case "src":
        (isBuiltIn(this.src) ? this.openBuiltIn(this.src) : this.#fetch(this.src).then((files) => this.openFiles(files))).catch(failed);
        break;
      case "environment":
      case "environment-image":
        this.setEnvironment(value ?? ENVIRONMENT).catch(failed);
        break;
      case "animation-name":
        this.set("clip", value ?? "automatic").catch(failed);
        break;
      case "options":
        for (const [option, text] of optionsOf(value)) this.set(option, text).catch(failed);
        break;
      case "poster":
        this.#showPoster();
        break;
      case "camera-controls":
        this.#allowNavigation();
        break;
      case "alt":
        this.#name();
    }
  }

  get src(): string { return this.getAttribute("src") ?? SCENE; }
  set src(value: string) { this.setAttribute("src", value); }
  get environmentImage(): string | null { return this.getAttribute("environment-image") ?? this.getAttribute("environment"); }
  set environmentImage(value: string) { this.setAttribute("environment-image", value); }
  get alt(): string { return this.getAttribute("alt") ?? "A scene in three dimensions"; }
  set alt(value: string) { this.setAttribute("alt", value); }

  /** Whether the first picture is there. */
  get loaded(): boolean { return this.#loaded; }
  /** What goes on, as it was told last. */
  get status(): Status | undefined { return this.#status; }
  /** Length of the clip that is chosen [s], 0 without one. */
  get duration(): number { return this.#status?.duration ?? 0; }
  get currentTime(): number { return this.#status?.time ?? 0; }
  set currentTime(seconds: number) { this.set("time", String(seconds)).catch((error) => this.#fail(error)); }
  get paused(): boolean { return !this.#status?.playing; }

  /** The session behind the picture, for what the element has no method for. */
  async client(): Promise<Client> {
    await this.#opening;
    if (!this.#client) throw new Error("nothing is open");
    return this.#client;
  }

  /** What a session that is opened from now on begins with, beside the attributes: what a link carries. */
  set link(link: Link) { this.#link = link; }

  async play(): Promise<void> {
    const client = await this.client();
    // The first clip, where none is chosen.
    if (this.#status?.duration == null) await client.call("set", "clip", "0");
    await client.call("play", true);
    this.dispatchEvent(new Event("play"));
  }

  async pause(): Promise<void> {
    await (await this.client()).call("play", false);
    this.dispatchEvent(new Event("pause"));
  }

  /** Gives an option a value, both as texts, as `gnomon render --help` has them. */
  async set(option: string, value: string): Promise<void> {
    await (await this.client()).call("set", option, value);
  }

  /** Opens a scene, an environment or both: what of some files is which the names tell. Says what it opens, by their paths. */
  async openFiles(files: SceneFile[]): Promise<{ scene?: string; environment?: string }> {
    const client = await this.client();
    const { scene, environment } = await sorted(files);
    if (scene) await client.call("openScene", scene.path, scene.files);
    if (scene && environment) await this.#idle();
    if (environment) await client.call("setEnvironment", environment.path, environment.files);
    return { scene: scene?.path, environment: environment?.path };
  }

  /** Opens a scene that is built in. */
  async openBuiltIn(scene: string): Promise<void> {
    await (await this.client()).call("openScene", scene, []);
  }

  /** Takes another environment: the name of one that is built in, or an address. */
  async setEnvironment(environment: string): Promise<void> {
    const files = isBuiltIn(environment) ? [] : await this.#fetch(environment);
    await (await this.client()).call("setEnvironment", environment, files);
  }

  /** The picture as a PNG. */
  async toBlob(): Promise<Blob> {
    return new Blob([await (await this.client()).call("png")], { type: "image/png" });
  }

  /** Until nothing is loaded. */
  async #idle(): Promise<void> {
    while (!this.#status || this.#status.loading) {
      await new Promise((resolve) => this.addEventListener("status", resolve, { once: true }));
    }
  }

  async #fetch(address: string): Promise<SceneFile[]> {
    return fetched(address, (share) => this.#progress(share));
  }

  async #open(): Promise<void> {
    // What a program sets beside the element's making belongs to the beginning.
    await undefined;
    if (!("gpu" in navigator)) {
      this.#told.textContent = "This browser has no WebGPU, which Gnomon draws with. Chrome and Edge from 113, Safari from 26, and Firefox from 141 on Windows and 145 on Macs have it.";
      this.dispatchEvent(new CustomEvent("error", { detail: { type: "nowebgpu", message: this.#told.textContent } }));
      return;
    }
    const canvas = document.createElement("canvas");
    canvas.id = "picture";
    canvas.className = "gone";
    this.#canvas = canvas;
    this.#root.insertBefore(canvas, this.#told);
    this.#name();
    const client = new Client();
    this.#client = client;
    client.onstatus = (status) => this.#take(status);
    client.onreference = (state) => this.onreference(state);
    client.onfailure = (message) => this.#fail(new Error(message));
    this.#allowNavigation();
    this.#begun = true;
    const { src, environmentImage: environment } = this;
    const [link, given] = [this.#link, optionsOf(this.getAttribute("options"))];
    const named = this.getAttribute("animation-name");
    try {
      this.#progress(0.05);
      const scene = isBuiltIn(src) ? undefined : (await sorted(await this.#fetch(src))).scene;
      const map = environment && !isBuiltIn(environment) ? await this.#fetch(environment) : [];
      const clip = named ?? (this.hasAttribute("autoplay") && scene ? "0" : undefined);
      const request: Request = {
        ...link,
        scene: scene?.path ?? src,
        ...(environment ? { environment: map[0]?.path ?? environment } : {}),
        options: [...given, ...(link?.options ?? []), ...(clip ? [["clip", clip] as [string, string]] : [])],
        size: this.#pixels(),
      };
      this.#progress(0.2);
      await client.call("open", canvas.transferControlToOffscreen(), request, [...(scene?.files ?? []), ...map]);
      if (this.hasAttribute("autoplay")) await client.call("play", true);
      this.#progress(0.8);
    } catch (error) {
      if (this.#client !== client) return;
      client.close();
      this.#client = undefined;
      this.#fail(error);
      this.#told.textContent = error instanceof Error ? error.message : String(error);
    }
  }

  #take(status: Status): void {
    this.#status = status;
    if (!this.#loaded && status.frames > 0) {
      this.#loaded = true;
      this.#canvas?.classList.remove("gone");
      this.#poster.classList.add("gone");
      this.#progress(1);
      this.dispatchEvent(new Event("load"));
    }
    if (this.#loaded) {
      this.#bar.classList.toggle("endless", status.loading);
      this.#bar.classList.toggle("gone", !status.loading);
    }
    for (const { is_error, text } of status.notices) {
      if (is_error) this.#fail(new Error(text));
    }
    this.dispatchEvent(new CustomEvent("status", { detail: status }));
  }

  #fail(error: unknown): void {
    this.#progress(1);
    const message = error instanceof Error ? error.message : String(error);
    this.dispatchEvent(new CustomEvent("error", { detail: { type: "loadfailure", message } }));
  }

  #progress(share: number): void {
    this.#bar.classList.toggle("gone", share >= 1);
    this.#bar.style.transform = `scaleX(${share})`;
    this.#bar.setAttribute("aria-valuenow", String(Math.round(100 * share)));
    this.dispatchEvent(new CustomEvent("progress", { detail: { totalProgress: share } }));
  }

  #showPoster(): void {
    const poster = this.getAttribute("poster");
    if (poster && !this.#loaded) this.#poster.src = poster;
    this.#poster.classList.toggle("gone", !poster || this.#loaded);
  }

  #name(): void {
    this.#canvas?.setAttribute("aria-label", this.alt);
    this.#canvas?.setAttribute("role", this.hasAttribute("camera-controls") ? "application" : "img");
  }

  #allowNavigation(): void {
    this.#navigation?.abort();
    this.#navigation = undefined;
    const [canvas, client] = [this.#canvas, this.#client];
    if (!canvas || !client) return;
    this.#name();
    if (!this.hasAttribute("camera-controls")) {
      canvas.removeAttribute("tabindex");
      return;
    }
    canvas.tabIndex = 0;
    const toggle = () => void (this.paused ? this.play() : this.pause()).catch((error) => this.#fail(error));
    this.#navigation = navigate(canvas, client, () => this.dispatchEvent(new CustomEvent("camera-change", { detail: { source: "user-interaction" } })), toggle);
  }

  #pixels(): [number, number] {
    const scale = Math.min(devicePixelRatio || 1, MOST_PIXELS_A_POINT);
    return [this.clientWidth, this.clientHeight].map((side) => Math.max(1, Math.round(side * scale))) as [number, number];
  }

  #resize(): void {
    this.#opening.then(() => this.#client?.call("resize", ...this.#pixels())).catch((error) => this.#fail(error));
  }

  #visibility = (): void => {
    this.#client?.call("setVisible", !document.hidden).catch(() => {});
  };
}

/** `name=value; name=value` */
function optionsOf(text: string | null): [string, string][] {
  const pairs = (text ?? "").split(";").map((pair) => pair.split("=").map((part) => part.trim()));
  return pairs.filter((pair): pair is [string, string] => pair.length === 2 && pair[0] !== "");
}

if (!customElements.get("gnomon-viewer")) customElements.define("gnomon-viewer", GnomonViewer);

declare global {
  interface HTMLElementTagNameMap {
    "gnomon-viewer": GnomonViewer;
  }
}
