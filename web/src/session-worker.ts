// Holds the session: everything that takes time happens here, and the page stays responsive.

import init, { FileSet, Session } from "../wasm/gnomon_web.js";
import type { Call, Methods, Notice, ReferenceState, Request, SceneFile, Shown, Status, Told, WorkerScope } from "./protocol";
import type { ToTracer } from "./tracer-worker";

/** Pixels of the reference: a pass of it takes about as long as the page's frames do on a slow machine. */
const REFERENCE_PIXELS = 320 * 180;
/** How often the page is told what goes on [ms]. */
const STATUS_EVERY = 100;
/** While a slow GPU is at a frame browsers ask for no other; what is loaded goes on and is told meanwhile [ms]. */
const LONGEST_WAIT = 100;
/** How often a device at rest is asked whether it was lost [ms]. */
const WATCHED_EVERY = 1000;

const scope = self as unknown as WorkerScope;
let memory: WebAssembly.Memory;
let session: Session | undefined;
/** A call that waits for the GPU has the session for itself. */
let taken = false;
let visible = true;
let scheduled = false;
let watching: ReturnType<typeof setTimeout> | undefined;
let told = -Infinity;
const notices: Notice[] = [];

function tell(message: Told, transfer: Transferable[] = []): void {
  scope.postMessage(message, transfer);
}

function messageOf(error: unknown): string {
  if (error instanceof WebAssembly.RuntimeError) {
    return `Gnomon failed, which is a fault of its own: ${error.message}. Reload the page.`;
  }
  return error instanceof Error ? error.message : String(error);
}

function opened(): Session {
  if (!session) throw new Error("nothing is open yet");
  return session;
}

async function fileSet(files: SceneFile[]): Promise<FileSet> {
  const set = new FileSet();
  for (const { path, data } of files) {
    set.add(path, data instanceof Uint8Array ? data : new Uint8Array(await data.arrayBuffer()));
  }
  return set;
}

/** What is done one after another: a session takes one call at a time. */
let calls: Promise<unknown> = Promise.resolve();

function inTurn<T>(call: () => Promise<T>): Promise<T> {
  const answer = calls.then(call);
  calls = answer.catch(() => {});
  return answer;
}

/** Runs a call that waits for the GPU, when it is its turn; no frame is drawn meanwhile. */
async function alone<T>(call: () => Promise<T>): Promise<T> {
  taken = true;
  try {
    return await call();
  } finally {
    taken = false;
    wake();
  }
}

// --- frames ---------------------------------------------------------------------------------------------------------

function wake(): void {
  if (scheduled || !visible || !session) return;
  scheduled = true;
  const go = () => {
    scope.cancelAnimationFrame(frame);
    clearTimeout(timer);
    step(performance.now());
  };
  const frame = scope.requestAnimationFrame(go);
  const timer = setTimeout(go, LONGEST_WAIT);
}

function step(now: number): void {
  scheduled = false;
  if (!session || taken || !visible) return;
  let active = false;
  try {
    active = session.frame(now);
  } catch (error) {
    notices.push({ is_error: true, text: messageOf(error) });
    if (error instanceof WebAssembly.RuntimeError) session = undefined;
  }
  if (!active || now - told > STATUS_EVERY) tellStatus(now);
  if (active) wake();
  else watch();
}

/** A device may be lost while there is nothing to draw. */
function watch(): void {
  clearTimeout(watching);
  watching = setTimeout(() => {
    if (!session || taken || scheduled) return;
    if (session.deviceIsLost()) wake();
    else watch();
  }, WATCHED_EVERY);
}

function tellStatus(now: number): void {
  if (!session || taken) return;
  told = now;
  const status: Status = { ...JSON.parse(session.status()), memory: memory.buffer.byteLength };
  status.notices.push(...notices.splice(0));
  tell({ type: "status", status });
  if (status.deviceLost) void reopen();
  if (!status.busy && !status.moving) void followReference();
}

let reopening = false;

async function reopen(): Promise<void> {
  if (reopening) return;
  reopening = true;
  try {
    await inTurn(() => alone(() => opened().reopen()));
  } catch (error) {
    notices.push({ is_error: true, text: messageOf(error) });
  }
  reopening = false;
}

// --- reference ------------------------------------------------------------------------------------------------------

let shown: Shown | undefined;
let tracer: Worker | undefined;
/** What the tracer has been told last. */
let traced = { scene: "", look: "" };
/** Counts scenes and environments. */
let scenes = 0;

function stopTracing(): void {
  tracer?.terminate();
  tracer = undefined;
  traced = { scene: "", look: "" };
}

/** Has the picture at rest compared, if that is not done already. */
async function followReference(): Promise<void> {
  if (!shown || !session || taken) return;
  const look = session.look();
  const scene = `${scenes} ${JSON.parse(session.status()).environment} ${session.scenePath()}`;
  if (traced.look === look + shown && traced.scene === scene) return;
  if (traced.scene !== scene) {
    stopTracing();
    tracer = new Worker(new URL("./tracer-worker.js", import.meta.url), { type: "module" });
    tracer.onmessage = ({ data }: MessageEvent<ReferenceState | string>) => {
      if (typeof data === "string") {
        notices.push({ is_error: true, text: data });
        tellStatus(performance.now());
      } else if (shown) {
        tell({ type: "reference", state: data }, [data.picture.buffer]);
      }
    };
    const files = [...(session.sceneFiles() as Map<string, Uint8Array>)];
    post({ type: "open", path: session.scenePath(), look, files });
  }
  traced = { scene, look: look + shown };
  tell({ type: "reference", state: undefined });
  const [width, height] = size;
  const scale = Math.min(1, Math.sqrt(REFERENCE_PIXELS / (width * height)));
  const [w, h] = [width, height].map((side) => Math.max(1, Math.round(side * scale)));
  const radiance: Float32Array = await inTurn(() => alone(() => opened().radiance(w, h)));
  post({ type: "compare", look, width: w, height: h, radiance, difference: shown === "difference" });
}

function post(message: ToTracer): void {
  tracer?.postMessage(message);
}

// --- calls ----------------------------------------------------------------------------------------------------------

let size: [number, number] = [1, 1];

const methods: { [M in keyof Methods]: (...args: Parameters<Methods[M]>) => ReturnType<Methods[M]> | Promise<ReturnType<Methods[M]>> } = {
  async open(canvas: OffscreenCanvas, request: Request, files: SceneFile[]) {
    memory = (await init()).memory;
    size = request.size;
    session = await Session.open(canvas, JSON.stringify(request), await fileSet(files));
  },
  resize(width, height) {
    size = [width, height];
    opened().resize(width, height);
  },
  async openScene(scene, files) {
    scenes += 1;
    opened().openScene(scene, await fileSet(files));
  },
  async setEnvironment(name, files) {
    scenes += 1;
    opened().setEnvironment(name, await fileSet(files));
  },
  set: (name, value) => opened().set(name, value),
  setModel: (name) => opened().setModel(name),
  setParameter: (name, value) => opened().setParameter(name, value && new Float32Array(value)),
  play: (playing) => opened().play(playing),
  turn: (x, y) => opened().turn(x, y),
  pan: (x, y) => opened().pan(x, y),
  dolly: (factor) => opened().dolly(factor),
  frameScene: () => opened().frameScene(),
  turnEnvironment: (degrees) => opened().turnEnvironment(degrees),
  holdFrameRate: (framesASecond) => opened().holdFrameRate(framesASecond),
  setSplit: (canvas) => opened().setSplit(canvas),
  setVisible(now) {
    visible = now;
    if (!visible) stopTracing();
  },
  loseDevice: () => opened().loseDevice(),
  panel: () => JSON.parse(opened().panel()),
  map: (width) => opened().map(width) as Uint8Array<ArrayBuffer>,
  png: () => alone(() => opened().png()) as Promise<Uint8Array<ArrayBuffer>>,
  sceneFile: () => opened().sceneFile(),
  link: () => JSON.parse(opened().link()),
  showReference(wanted) {
    shown = wanted;
    if (!shown) stopTracing();
  },
};

/** Calls that come with every movement: frames tell what becomes of them. */
const FREQUENT: readonly (keyof Methods)[] = ["turn", "pan", "dolly", "turnEnvironment", "resize"];
/** Calls that change nothing: a page that asks whenever it is told something would never rest. */
const QUESTIONS: readonly (keyof Methods)[] = ["panel", "map", "link"];

scope.onmessage = ({ data }: MessageEvent<Call>) => {
  void inTurn(async () => {
    try {
      const method = methods[data.method] as (...args: unknown[]) => unknown;
      const value = await method(...data.args);
      // Loading holds the worker up: the page is told before.
      if (![...FREQUENT, ...QUESTIONS].includes(data.method)) tellStatus(performance.now());
      tell({ type: "answer", id: data.id, value });
    } catch (error) {
      tell({ type: "refusal", id: data.id, message: messageOf(error) });
    }
    if (!QUESTIONS.includes(data.method)) wake();
  });
};
