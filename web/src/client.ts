// The page's end of the session's worker.

import type { Methods, ReferenceState, Status, Told } from "./protocol";

type Answer<T> = Promise<Awaited<T>>;

/** Calls to a session's worker, and what it tells by itself. */
export class Client {
  readonly #worker: Worker;
  readonly #waiting = new Map<number, { resolve(value: never): void; reject(error: Error): void }>();
  #calls = 0;

  onstatus: (status: Status) => void = () => {};
  onreference: (state: ReferenceState | undefined) => void = () => {};
  /** The worker is gone: nothing more is answered. */
  onfailure: (message: string) => void = () => {};

  constructor() {
    this.#worker = new Worker(new URL("./session-worker.js", import.meta.url), { type: "module" });
    this.#worker.onmessage = ({ data }: MessageEvent<Told>) => this.#take(data);
    this.#worker.onerror = (event) => {
      const message = event.message || "its worker could not be loaded";
      for (const { reject } of this.#waiting.values()) reject(new Error(message));
      this.#waiting.clear();
      this.onfailure(message);
    };
  }

  #take(told: Told): void {
    switch (told.type) {
      case "status":
        return this.onstatus(told.status);
      case "reference":
        return this.onreference(told.state);
      case "answer":
      case "refusal": {
        const waiting = this.#waiting.get(told.id);
        this.#waiting.delete(told.id);
        if (told.type === "answer") waiting?.resolve(told.value as never);
        else waiting?.reject(new Error(told.message));
      }
    }
  }

  /** Asks for something. Calls are answered in their order. */
  call<M extends keyof Methods>(method: M, ...args: Parameters<Methods[M]>): Answer<ReturnType<Methods[M]>> {
    const id = ++this.#calls;
    const transfer = (args as unknown[]).filter((argument) => argument instanceof OffscreenCanvas);
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.#worker.postMessage({ id, method, args }, transfer as Transferable[]);
    });
  }

  close(): void {
    this.#worker.terminate();
    for (const { reject } of this.#waiting.values()) reject(new Error("the viewer was removed"));
    this.#waiting.clear();
  }
}
