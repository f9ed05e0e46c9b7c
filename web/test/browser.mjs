// A headless Chromium that really draws, and pictures of what it shows.

import { existsSync } from "node:fs";
import { chromium } from "playwright-core";

const PLACES = [process.env.GNOMON_CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];

/** WebGPU on SwiftShader. With --use-webgpu-adapter=swiftshader all seems well, and the canvas stays blank. */
const FLAGS = [
  "--enable-unsafe-webgpu", "--enable-features=Vulkan", "--use-vulkan=swiftshader", "--use-angle=swiftshader",
  "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
];

/** Where a browser is installed; undefined where there is none. */
export const place = PLACES.find((path) => path && existsSync(path));

export function launch() {
  return chromium.launch({ executablePath: place, headless: true, args: FLAGS });
}

/** What is seen at an element: mean colours of a grid of cells, 0 to 255, row by row. */
export async function seen(page, selector, columns = 32, rows = 18) {
  const box = await page.locator(selector).boundingBox();
  const png = await page.screenshot({ clip: box });
  return page.evaluate(async ([base64, columns, rows]) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const { width, height } = bitmap;
    const context = new OffscreenCanvas(width, height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, width, height);
    const cells = Array.from({ length: columns * rows }, () => [0, 0, 0, 0]);
    for (let y = 0; y < height; y++) {
      for (let x = 0; x < width; x++) {
        const cell = cells[Math.floor((y * rows) / height) * columns + Math.floor((x * columns) / width)];
        for (let c = 0; c < 3; c++) cell[c] += data[4 * (y * width + x) + c];
        cell[3] += 1;
      }
    }
    return cells.map((cell) => cell.slice(0, 3).map((sum) => sum / cell[3]));
  }, [png.toString("base64"), columns, rows]);
}

/** How much a picture varies: the standard deviation of its cells' brightness. A blank one is near 0. */
export function variation(cells) {
  const grey = cells.map(([r, g, b]) => (r + g + b) / 3);
  const mean = grey.reduce((a, b) => a + b) / grey.length;
  return Math.sqrt(grey.reduce((sum, value) => sum + (value - mean) ** 2, 0) / grey.length);
}

/** Mean absolute difference of two pictures. */
export function difference(a, b) {
  const each = a.map((cell, i) => cell.reduce((sum, value, c) => sum + Math.abs(value - b[i][c]), 0) / 3);
  return each.reduce((x, y) => x + y) / each.length;
}

/** Without the ring that shows where the keyboard is. */
export function unfocused(page) {
  return page.evaluate(() => document.activeElement?.blur());
}

/** Waits until the viewer has nothing to do, and gives its status. */
export async function atRest(page, selector = "gnomon-viewer", timeout = 300_000) {
  return page.evaluate(([selector, timeout]) => new Promise((resolve, reject) => {
    const viewer = document.querySelector(selector);
    let quiet = 0;
    const end = setTimeout(() => reject(new Error(`not at rest: ${JSON.stringify(viewer.status)}`)), timeout);
    const look = () => {
      const status = viewer.status;
      quiet = status && viewer.loaded && !status.busy && !status.moving ? quiet + 1 : 0;
      if (quiet < 6) return void setTimeout(look, 50);
      clearTimeout(end);
      resolve(status);
    };
    // What was asked for a moment ago has reached the worker by its answer.
    viewer.client().then((client) => client.call("link")).then(look, reject);
  }), [selector, timeout]);
}

/** Drops files on the page; `files` are names with texts or bytes. */
export async function drop(page, files) {
  const coded = files.map(([name, data]) => [name, Buffer.from(data).toString("base64")]);
  await page.evaluate((files) => {
    const transfer = new DataTransfer();
    for (const [name, base64] of files) {
      transfer.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name));
    }
    for (const type of ["dragenter", "drop"]) {
      window.dispatchEvent(new DragEvent(type, { dataTransfer: transfer, bubbles: true, cancelable: true }));
    }
  }, coded);
}
