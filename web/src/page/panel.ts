// The panel: a control for every option that is declared, and for every parameter of a material.

import type { Client } from "../client";
import type { Control, Entry, Material, Offer, ParameterOffer, Section } from "../protocol";

/** Widest range that has a slider; wider ones are typed. */
const SLIDER_SPAN = 64;
const AUTOMATIC = "automatic";

type Attributes = Record<string, string | number | boolean | ((event: Event) => void)>;

/** An element with attributes and contents. */
export function make<T extends keyof HTMLElementTagNameMap>(tag: T, attributes: Attributes = {}, ...contents: (Node | string)[]): HTMLElementTagNameMap[T] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name, value);
    else if (typeof value === "boolean") element.toggleAttribute(name, value);
    else element.setAttribute(name, String(value));
  }
  element.append(...contents);
  return element;
}

/** Fills the panel anew, but for what somebody is at: what is focused stays. */
export class Panel {
  readonly #options: HTMLElement;
  readonly #material: HTMLElement;
  readonly #client: Client;
  readonly #fail: (error: unknown) => void;
  #shape = "";
  readonly #open = new Map<string, boolean>();
  /** Takes the value of an option over into its control. */
  readonly #updates = new Map<string, (offer: Offer) => void>();

  constructor(options: HTMLElement, material: HTMLElement, client: Client, fail: (error: unknown) => void) {
    this.#options = options;
    this.#material = material;
    this.#client = client;
    this.#fail = fail;
  }

  show(sections: Section[], material: Material): void {
    // What is offered, without the values: controls are made anew only where that changes.
    const shape = JSON.stringify(sections.map(({ title, options }) => [title, options.map(({ name, control, automatic }) => [name, control, automatic])]));
    if (shape !== this.#shape) {
      this.#shape = shape;
      const focused = document.activeElement?.id;
      this.#updates.clear();
      this.#options.replaceChildren(...sections.map((section) => this.#section(section)));
      if (focused) document.getElementById(focused)?.focus();
    }
    for (const offer of sections.flatMap((section) => section.options)) this.#updates.get(offer.name)?.(offer);
    this.#showMaterial(material);
  }

  #set(name: string, value: string): void {
    this.#client.call("set", name, value).catch(this.#fail);
  }

  #section({ title, open, options }: Section): HTMLElement {
    const details = make("details", { open: this.#open.get(title) ?? (open && title === "Display") }, make("summary", {}, title), ...options.map((offer) => this.#row(offer)));
    details.addEventListener("toggle", () => this.#open.set(title, details.open));
    return details;
  }

  #row(offer: Offer): HTMLElement {
    const { name, automatic, control, help } = offer;
    const id = `option-${name}`;
    const label = make("label", { for: id, title: `${name}: ${help}` }, offer.label + (offer.unit ? ` (${offer.unit})` : ""));
    const { element, show } = this.#control(id, name, control, automatic);
    const value = make("div", { class: "value" }, element);
    const isList = control.kind === "choice" || control.kind === "text";
    if (automatic === null || isList) {
      this.#updates.set(name, (offer) => show(offer.value, offer.inForce));
      return make("div", { class: "row" }, label, value);
    }
    const tick = make("input", {
      type: "checkbox",
      "aria-label": `${offer.label}: automatic, ${automatic}`,
      title: automatic,
      change: () => this.#set(name, tick.checked ? AUTOMATIC : startOf(element)),
    });
    value.append(make("label", { class: "auto" }, tick, "auto"));
    this.#updates.set(name, (offer) => {
      const isAutomatic = offer.value === AUTOMATIC;
      tick.checked = isAutomatic;
      for (const input of inputs(element)) input.disabled = isAutomatic;
      show(isAutomatic ? (offer.inForce ?? "") : offer.value, null);
    });
    return make("div", { class: "row" }, label, value);
  }

  #control(id: string, name: string, control: Control, automatic: string | null): { element: HTMLElement; show(value: string, inForce: string | null): void } {
    switch (control.kind) {
      case "yesNo": {
        const box = make("input", { id, type: "checkbox", change: () => this.#set(name, String(box.checked)) });
        return { element: box, show: (value) => (box.checked = value === "true") };
      }
      case "choice": {
        const entries: Entry[] = automatic === null ? control.choices : [{ value: AUTOMATIC, label: AUTOMATIC, help: automatic }, ...control.choices];
        const list = make("select", { id, change: () => this.#set(name, list.value) }, ...entries.map(({ value, label, help }) => make("option", { value, title: help }, label)));
        return { element: list, show: (value) => (list.value = value) };
      }
      case "text": {
        const line = make("input", { id, type: "text", placeholder: automatic ?? "", change: () => this.#set(name, line.value || AUTOMATIC) });
        return { element: line, show: (value) => unlessFocused(line, value === AUTOMATIC ? "" : value) };
      }
      case "color": {
        const line = make("input", { id, type: "text", title: "red/green/blue, linear", change: () => this.#set(name, line.value) });
        return { element: line, show: (value) => unlessFocused(line, value) };
      }
      case "angle":
        return slider(id, name, { least: -180, most: 180, step: 1 }, (value) => this.#set(name, value));
      case "number": {
        const { least, most, whole } = control;
        const step = whole ? 1 : (most - least) / 1000;
        if (most - least <= SLIDER_SPAN) return slider(id, name, { least, most, step }, (value) => this.#set(name, value));
        const range: Attributes = Math.abs(least) < 1e7 && Math.abs(most) < 1e7 ? { min: least, max: most } : {};
        const number: HTMLInputElement = make("input", { id, type: "number", step: whole ? 1 : "any", ...range, change: () => this.#set(name, number.value) });
        return { element: number, show: (value) => unlessFocused(number, value) };
      }
    }
  }

  #materialShape = "";

  #showMaterial(material: Material): void {
    const shape = JSON.stringify(material);
    if (shape === this.#materialShape || this.#material.contains(document.activeElement) && document.activeElement?.matches("input[type=range]")) return;
    this.#materialShape = shape;
    const own = { value: "", label: "as in the scene", help: "every material keeps its own" };
    const models: HTMLSelectElement = make("select", { id: "model", change: () => this.#client.call("setModel", models.value).catch(this.#fail) },
      ...[own, ...material.models].map(({ value, label, help }) => make("option", { value, title: help }, label)));
    models.value = material.model;
    const focused = document.activeElement?.id;
    this.#material.replaceChildren(
      make("div", { class: "row" }, make("label", { for: "model" }, "model"), make("div", { class: "value" }, models)),
      ...material.parameters.map((parameter) => this.#parameter(parameter)),
    );
    if (focused && focused.startsWith("parameter-") || focused === "model") document.getElementById(focused)?.focus();
  }

  #parameter({ name, help, isColor, optional, slider: [least, most], start, value }: ParameterOffer): HTMLElement {
    const id = `parameter-${name}`;
    const set = (value: number[] | undefined) => this.#client.call("setParameter", name, value).catch(this.#fail);
    const label = make("label", { for: id, title: help }, name.replaceAll("_", " "));
    const field = make("div", { class: "value" });
    if (optional) {
      const own = make("input", { type: "checkbox", "aria-label": `${name}: the scene's`, change: () => set(own.checked ? undefined : [start, start, start]) });
      own.checked = value === null;
      field.append(make("label", { class: "auto" }, own, "the scene's"));
    }
    if (value !== null && isColor) {
      const color = make("input", { id, type: "color", value: hexOf(value), input: () => set(linearOf(color.value)) });
      field.prepend(color);
    } else if (value !== null) {
      const { element, show } = slider(id, name, { least, most, step: (most - least) / 200 }, (text) => set([Number(text), Number(text), Number(text)]));
      show(String(value[0]), null);
      field.prepend(element);
    } else {
      label.removeAttribute("for");
    }
    return make("div", { class: "row" }, label, field);
  }
}

function inputs(element: HTMLElement): HTMLInputElement[] {
  return element instanceof HTMLInputElement ? [element] : [...element.querySelectorAll("input")];
}

function startOf(element: HTMLElement): string {
  const [input] = inputs(element);
  return input.value || "1";
}

function unlessFocused(input: HTMLInputElement, value: string): void {
  if (document.activeElement !== input) input.value = value;
}

/** A slider with its number beside it. */
function slider(id: string, name: string, { least, most, step }: { least: number; most: number; step: number }, set: (value: string) => void) {
  const range: HTMLInputElement = make("input", { id, type: "range", min: least, max: most, step, input: () => { number.value = brief(range.value); set(range.value); } });
  const number: HTMLInputElement = make("input", { type: "number", min: least, max: most, step: "any", "aria-label": `${name}, as a number`, change: () => set(number.value) });
  const element = make("div", { class: "value" }, range, number);
  const show = (value: string, _inForce: string | null) => {
    if (element.contains(document.activeElement) && document.activeElement?.matches(":active")) return;
    range.value = value;
    unlessFocused(number, brief(value));
  };
  return { element, show };
}

function brief(value: string): string {
  return value === "" ? "" : String(Number(Number(value).toPrecision(4)));
}

function hexOf(linear: [number, number, number]): string {
  const encode = (c: number) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);
  return "#" + linear.map((c) => Math.round(255 * Math.min(1, Math.max(0, encode(c)))).toString(16).padStart(2, "0")).join("");
}

function linearOf(hex: string): number[] {
  const decode = (c: number) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
  return [1, 3, 5].map((at) => decode(parseInt(hex.slice(at, at + 2), 16) / 255));
}
