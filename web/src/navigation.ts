// Mouse, touch and keyboard on a picture.

import type { Client } from "./client";

/** A drag across the picture turns by this much [rad], and the environment by so many degrees. */
const TURN_ACROSS = 3.5;
const ENVIRONMENT_ACROSS = 180;
/** A press of an arrow turns by this much [rad], and moves by this share of the view's width. */
const TURN_STEP = 0.1;
const PAN_STEP = 0.05;
const DOLLY_STEP = 0.9;
const ENVIRONMENT_STEP = 15;
/** Of the wheel, a power of e a pixel. */
const DOLLY_SCROLL = 0.002;

/** What the keys do, for people. */
export const KEYS: readonly [string, string][] = [
  ["drag, one finger, arrow keys", "turn the view"],
  ["Shift or right button and drag, two fingers, Shift and arrows", "move the view"],
  ["wheel, pinch, + and −", "come nearer or go away"],
  ["Alt and drag, [ and ]", "turn the environment"],
  ["double click, Home", "frame the scene"],
  ["Space", "run or stop the animation"],
];

/** Lets people move the view of an element's picture. `moved` is called with every movement. */
export function navigate(element: HTMLElement, client: Client, moved: () => void, toggle: () => void): AbortController {
  const end = new AbortController();
  const { signal } = end;
  const fingers = new Map<number, PointerEvent>();
  let pending = { turn: [0, 0], pan: [0, 0], dolly: 1, environment: 0 };
  let scheduled = false;

  // One call a frame, however many events come.
  const flush = () => {
    scheduled = false;
    const { turn, pan, dolly, environment } = pending;
    pending = { turn: [0, 0], pan: [0, 0], dolly: 1, environment: 0 };
    const ignore = () => {};
    if (turn[0] || turn[1]) client.call("turn", turn[0], turn[1]).catch(ignore);
    if (pan[0] || pan[1]) client.call("pan", pan[0], pan[1]).catch(ignore);
    if (dolly !== 1) client.call("dolly", dolly).catch(ignore);
    if (environment) client.call("turnEnvironment", environment).catch(ignore);
    moved();
  };
  const soon = () => {
    if (scheduled) return;
    scheduled = true;
    requestAnimationFrame(flush);
  };
  const turn = (x: number, y: number) => (pending.turn = [pending.turn[0] + x, pending.turn[1] + y], soon());
  const pan = (x: number, y: number) => (pending.pan = [pending.pan[0] + x, pending.pan[1] + y], soon());
  const dolly = (factor: number) => ((pending.dolly *= factor), soon());
  const environment = (degrees: number) => ((pending.environment += degrees), soon());

  element.addEventListener("pointerdown", (event) => {
    element.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, event);
  }, { signal });
  for (const type of ["pointerup", "pointercancel"] as const) {
    element.addEventListener(type, (event) => fingers.delete(event.pointerId), { signal });
  }
  element.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const width = Math.max(1, element.clientWidth);
    const x = (event.clientX - before.clientX) / width;
    const y = (event.clientY - before.clientY) / width;
    if (fingers.size === 2) {
      const [other] = [...fingers.values()].filter((finger) => finger.pointerId !== event.pointerId);
      const apart = (finger: PointerEvent) => Math.hypot(finger.clientX - other.clientX, finger.clientY - other.clientY);
      dolly(Math.max(1, apart(before)) / Math.max(1, apart(event)));
      // Two fingers, each by half.
      pan(-0.5 * x, 0.5 * y);
    } else if (event.altKey) {
      environment(ENVIRONMENT_ACROSS * x);
    } else if (event.shiftKey || (event.buttons & 6) !== 0) {
      pan(-x, y);
    } else {
      turn(-TURN_ACROSS * x, TURN_ACROSS * y);
    }
    fingers.set(event.pointerId, event);
  }, { signal });
  element.addEventListener("contextmenu", (event) => event.preventDefault(), { signal });
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    dolly(Math.exp(DOLLY_SCROLL * event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1)));
  }, { signal, passive: false });
  element.addEventListener("dblclick", () => {
    client.call("frameScene").then(moved, () => {});
  }, { signal });
  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = (x: number, y: number) =>
      event.shiftKey ? pan(PAN_STEP * x, PAN_STEP * y) : turn(TURN_STEP * x, TURN_STEP * y);
    switch (event.key) {
      case "ArrowLeft": step(-1, 0); break;
      case "ArrowRight": step(1, 0); break;
      case "ArrowUp": step(0, 1); break;
      case "ArrowDown": step(0, -1); break;
      case "+": case "=": dolly(DOLLY_STEP); break;
      case "-": case "_": dolly(1 / DOLLY_STEP); break;
      case "[": environment(-ENVIRONMENT_STEP); break;
      case "]": environment(ENVIRONMENT_STEP); break;
      case "Home": client.call("frameScene").then(moved, () => {}); break;
      case " ": toggle(); break;
      default: return;
    }
    event.preventDefault();
  }, { signal });
  return end;
}
