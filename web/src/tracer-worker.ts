// Traces the reference: pass after pass, until it is told of another picture.

import init, { FileSet, Tracer } from "../wasm/gnomon_web.js";
import type { ReferenceState, WorkerScope } from "./protocol";

export type ToTracer =
  | { type: "open"; path: string; look: string; files: [string, Uint8Array][] }
  | { type: "compare"; look: string; width: number; height: number; radiance: Float32Array; difference: boolean };

const scope = self as unknown as WorkerScope;
const ready = init();
let tracer: Tracer | undefined;
let difference = false;
let size: [number, number] = [0, 0];
let running = false;

async function take(message: ToTracer): Promise<void> {
  await ready;
  if (message.type === "open") {
    const files = new FileSet();
    for (const [path, bytes] of message.files) files.add(path, bytes);
    tracer = Tracer.open(files, message.path, message.look);
    return;
  }
  difference = message.difference;
  size = [message.width, message.height];
  tracer?.compare(message.look, message.width, message.height, message.radiance);
  if (!running) {
    running = true;
    void run();
  }
}

async function run(): Promise<void> {
  try {
    for (;;) {
      tracer?.pass();
      const error = tracer?.error();
      const picture = tracer?.picture(difference) as Uint8Array<ArrayBuffer> | undefined;
      if (error && picture) {
        const [samples, rmse, noise] = error;
        const [width, height] = size;
        const state: ReferenceState = { samples, error: rmse, noise, width, height, picture };
        scope.postMessage(state, [picture.buffer]);
      }
      // Lets messages in.
      await new Promise((resolve) => setTimeout(resolve));
    }
  } catch (error) {
    fail(error);
    running = false;
  }
}

function fail(error: unknown): void {
  scope.postMessage(`the reference: ${error instanceof Error ? error.message : String(error)}`);
}

let taking: Promise<void> = Promise.resolve();
scope.onmessage = ({ data }: MessageEvent<ToTracer>) => {
  taking = taking.then(() => take(data)).catch(fail);
};
