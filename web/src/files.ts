// Files that were dropped, chosen or fetched: what they are.

import { unzipSync } from "fflate";
import type { SceneFile } from "./protocol";

/** Scenes, those that name others first. */
const SCENES = ["toml", "gltf", "glb", "obj", "ply", "stl"];
const MAPS = ["hdr", "exr"];

function extensionOf(path: string): string {
  return path.slice(path.lastIndexOf(".") + 1).toLowerCase();
}

/** What of some files is to be opened. */
export interface Opened {
  scene?: { path: string; files: SceneFile[] };
  environment?: { path: string; files: SceneFile[] };
}

/** Tells scenes, their files and environments apart. What is neither is tried as a scene, whose reader then says what is wrong. */
export async function sorted(given: SceneFile[]): Promise<Opened> {
  const files = (await Promise.all(given.map(unpacked))).flat().filter((file) => !isHidden(file.path));
  const ranked = files.filter((file) => SCENES.includes(extensionOf(file.path)));
  const rank = (file: SceneFile) => SCENES.indexOf(extensionOf(file.path)) + file.path.split("/").length * SCENES.length;
  ranked.sort((a, b) => rank(a) - rank(b));
  const map = files.find((file) => MAPS.includes(extensionOf(file.path)));
  const [scene] = ranked;
  if (scene) {
    const own = scene.path.endsWith(".toml") || !map ? files : files.filter((file) => file !== map);
    return {
      scene: { path: scene.path, files: own },
      // A scene file says what its environment is.
      ...(map && !scene.path.endsWith(".toml") ? { environment: { path: map.path, files: [map] } } : {}),
    };
  }
  if (map) return { environment: { path: map.path, files: [map] } };
  const [first] = files;
  if (!first) throw new Error("There is no file in what was dropped.");
  const isPicture = /^(png|jpe?g|webp)$/.test(extensionOf(first.path));
  return isPicture
    ? { environment: { path: first.path, files: [first] } }
    : { scene: { path: first.path, files } };
}

/** What packers and file managers add. */
function isHidden(path: string): boolean {
  return path.split("/").some((part) => part.startsWith(".") || part === "__MACOSX");
}

async function unpacked(file: SceneFile): Promise<SceneFile[]> {
  if (extensionOf(file.path) !== "zip") return [file];
  const bytes = file.data instanceof Uint8Array ? file.data : new Uint8Array(await file.data.arrayBuffer());
  try {
    const entries = Object.entries(unzipSync(bytes));
    return entries.filter(([path]) => !path.endsWith("/")).map(([path, data]) => ({ path, data }));
  } catch {
    throw new Error(`${file.path} is not a zip archive that can be read.`);
  }
}

/** Files of an input element, folders included. */
export function chosen(list: FileList): SceneFile[] {
  return [...list].map((file) => ({ path: file.webkitRelativePath || file.name, data: file }));
}

/** Files of a drop, folders included. */
export async function dropped(transfer: DataTransfer): Promise<SceneFile[]> {
  // Entries are to be had only before the first wait.
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry());
  const plain = [...transfer.files];
  if (entries.some((entry) => entry?.isDirectory)) {
    return (await Promise.all(entries.map((entry) => (entry ? filesUnder(entry) : [])))).flat();
  }
  return plain.map((file) => ({ path: file.name, data: file }));
}

async function filesUnder(entry: FileSystemEntry): Promise<SceneFile[]> {
  if (entry.isFile) {
    const file = await new Promise<File>((resolve, reject) => (entry as FileSystemFileEntry).file(resolve, reject));
    return [{ path: entry.fullPath.replace(/^\//, ""), data: file }];
  }
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  const found: FileSystemEntry[] = [];
  for (;;) {
    // A folder comes in parts.
    const part = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
    if (part.length === 0) break;
    found.push(...part);
  }
  return (await Promise.all(found.map(filesUnder))).flat();
}

/** Fetches a file, and those that a glTF names. `progress` is told the share that has come. */
export async function fetched(address: string, progress: (share: number) => void): Promise<SceneFile[]> {
  const url = new URL(address, document.baseURI);
  const first = await fetchOne(url, progress);
  const name = decodeURIComponent(url.pathname.slice(url.pathname.lastIndexOf("/") + 1)) || "scene.glb";
  const files: SceneFile[] = [{ path: name, data: first }];
  if (extensionOf(name) !== "gltf") return files;
  const named = urisOf(first);
  for (const [index, uri] of named.entries()) {
    files.push({ path: decodeURIComponent(uri), data: await fetchOne(new URL(uri, url), () => {}) });
    progress((index + 1) / named.length);
  }
  return files;
}

/** Addresses of buffers and pictures; whatever else is wrong with the file its reader says. */
function urisOf(gltf: Uint8Array): string[] {
  try {
    const { buffers = [], images = [] } = JSON.parse(new TextDecoder().decode(gltf));
    const uris: unknown[] = [...buffers, ...images].map((entry: { uri?: unknown }) => entry?.uri);
    return uris.filter((uri): uri is string => typeof uri === "string" && !uri.startsWith("data:"));
  } catch {
    return [];
  }
}

async function fetchOne(url: URL, progress: (share: number) => void): Promise<Uint8Array> {
  const response = await fetch(url).catch(() => undefined);
  if (!response) throw new Error(`${url.href} cannot be reached.`);
  if (!response.ok) throw new Error(`${url.href} cannot be loaded: the server says ${response.status}.`);
  const length = Number(response.headers.get("content-length"));
  const parts: Uint8Array[] = [];
  let come = 0;
  for (const reader = response.body!.getReader(); ; ) {
    const { done, value } = await reader.read();
    if (done) break;
    parts.push(value);
    come += value.length;
    if (length > 0) progress(Math.min(1, come / length));
  }
  const whole = new Uint8Array(come);
  parts.reduce((at, part) => (whole.set(part, at), at + part.length), 0);
  return whole;
}
