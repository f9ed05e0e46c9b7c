// What the page and the session's worker tell each other.

/** Bytes, or where to get them, under the path that other files name. */
export interface SceneFile {
  path: string;
  data: Blob | Uint8Array;
}

/** What a session begins with. */
export interface Request {
  /** A built-in scene, or a path among the files. */
  scene: string;
  environment?: string;
  /** Names of options with texts. */
  options?: [string, string][];
  camera?: unknown;
  reflectance?: unknown;
  /** Pixels of the canvas. */
  size: [number, number];
}

/** What has been changed, as a link carries it. */
export type Link = Pick<Request, "options" | "camera" | "reflectance">;

export interface Notice {
  is_error: boolean;
  text: string;
}

export interface Status {
  scene: string;
  environment: string;
  triangles: number;
  lights: number;
  clips: number;
  duration: number | null;
  time: number;
  playing: boolean;
  busy: boolean;
  loading: boolean;
  moving: boolean;
  deviceLost: boolean;
  drawn: [number, number];
  frames: number;
  frameMs: number;
  passes: { name: string; milliseconds: number }[];
  level: string;
  adapter: string;
  notices: Notice[];
  /** Bytes of the session's memory. */
  memory: number;
}

export interface Entry {
  value: string;
  label: string;
  help: string;
}

export type Control =
  | { kind: "yesNo" | "angle" | "text" | "color" }
  | { kind: "number"; least: number; most: number; whole: boolean }
  | { kind: "choice"; choices: Entry[] };

export interface Offer {
  name: string;
  label: string;
  help: string;
  unit: string;
  control: Control;
  value: string;
  inForce: string | null;
  automatic: string | null;
}

export interface Section {
  title: string;
  open: boolean;
  options: Offer[];
}

export interface ParameterOffer {
  name: string;
  help: string;
  isColor: boolean;
  optional: boolean;
  slider: [number, number];
  start: number;
  value: [number, number, number] | null;
}

export interface Material {
  model: string;
  models: Entry[];
  parameters: ParameterOffer[];
}

/** Names. */
export interface BuiltIn {
  scenes: string[];
  environments: string[];
}

export type Panel = [Section[], Material, BuiltIn];

/** What the middle of the page shows of the reference. */
export type Shown = "reference" | "difference";

export interface ReferenceState {
  samples: number;
  /** Relative root mean square error of the GPU's picture. */
  error: number;
  /** Of the reference itself. */
  noise: number;
  width: number;
  height: number;
  /** RGBA. */
  picture: Uint8Array<ArrayBuffer>;
}

/** What the page asks the session's worker for. */
export interface Methods {
  open(canvas: OffscreenCanvas, request: Request, files: SceneFile[]): void;
  resize(width: number, height: number): void;
  openScene(scene: string, files: SceneFile[]): void;
  setEnvironment(name: string, files: SceneFile[]): void;
  set(name: string, value: string): void;
  setModel(name: string): void;
  setParameter(name: string, value: number[] | undefined): void;
  play(playing: boolean): void;
  turn(x: number, y: number): void;
  pan(x: number, y: number): void;
  dolly(factor: number): void;
  frameScene(): void;
  turnEnvironment(degrees: number): void;
  holdFrameRate(framesASecond: number): void;
  setSplit(canvas: OffscreenCanvas | undefined): void;
  setVisible(visible: boolean): void;
  loseDevice(): void;
  panel(): Panel;
  map(width: number): Uint8Array<ArrayBuffer>;
  png(): Uint8Array<ArrayBuffer>;
  sceneFile(): string;
  link(): Link;
  showReference(shown: Shown | undefined): void;
}

export type Call = { [M in keyof Methods]: { id: number; method: M; args: Parameters<Methods[M]> } }[keyof Methods];

export type Told =
  | { type: "answer"; id: number; value: unknown }
  | { type: "refusal"; id: number; message: string }
  | { type: "status"; status: Status }
  | { type: "reference"; state: ReferenceState | undefined };

/** What a worker has of its own: the types of pages do not have it. */
export interface WorkerScope {
  postMessage(message: unknown, transfer?: Transferable[]): void;
  onmessage: ((event: MessageEvent) => void) | null;
  requestAnimationFrame(step: (now: number) => void): number;
  cancelAnimationFrame(request: number): void;
}
