#!/usr/bin/env node
// Light rigs of `gnomon decompose` in browsers' programs, against `gnomon reference` under the same lights.
//
//     npm install --prefix FOLDER three babylonjs gltf-validator playwright-core
//     tools/rig_checks.mjs --gnomon target/release/gnomon --env grace.hdr --output out/rigs --modules FOLDER/node_modules
//
// glTF goes through the Khronos validator. three.js and Babylon.js load theirs in a headless Chromium (GNOMON_CHROMIUM, else the system's). A white
// ball, which nothing shadows, tells whether directions, colours and units of lights and map are right: relative RMSE against the reference. A post
// under one light tells where its shadow falls: the angle between it and what the light's direction asks for. Pictures of boxes under the whole rig are for
// eyes: NAME_boxes.png.

import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { dirname, extname, join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { parseArgs } from "node:util";

const { values: options } = parseArgs({
  options: { gnomon: { type: "string" }, env: { type: "string" }, output: { type: "string" }, modules: { type: "string" } },
});
const modules = resolve(options.modules);
const folder = resolve(options.output);
mkdirSync(folder, { recursive: true });

const SIZE = 96;
const BALL = { eye: [3, 1.2, 2.2], target: [0, 0, 0], fov: 40 };
const BALL_BEHIND = { ...BALL, eye: [-2.6, -1, -2.8] };
/** Pixels of a ball that are left out along its rim: edges are sampled otherwise. */
const RIM = 2;
/** Most that a ball may be off, and the angle of a shadow [degrees]. */
const MOST_ERROR = 0.03;
const MOST_ANGLE = 3;

const gnomon = (...words) => execFileSync(options.gnomon, ["--quiet", ...words.map(String)], { stdio: ["ignore", "ignore", "inherit"] });
const load = (path) => import(pathToFileURL(join(modules, path)));

async function linear(path) {
  const { EXRLoader } = await load("three/examples/jsm/loaders/EXRLoader.js");
  const bytes = readFileSync(path);
  const { FloatType } = await load("three/build/three.module.js");
  const { data, width, height } = new EXRLoader().setDataType(FloatType).parse(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
  // Rows from the bottom, as WebGL reads them.
  return { data: [...data], width, height };
}

/** A ball of radius 1, smooth. */
function writeBall() {
  const [columns, rows] = [96, 48];
  const places = [];
  const faces = [];
  for (let j = 0; j <= rows; j++) {
    for (let i = 0; i <= columns; i++) {
      const [phi, theta] = [(2 * Math.PI * i) / columns, (Math.PI * j) / rows];
      places.push([Math.sin(theta) * Math.cos(phi), Math.cos(theta), Math.sin(theta) * Math.sin(phi)]);
      const at = j * (columns + 1) + i + 1;
      if (i < columns && j < rows) faces.push([at, at + 1, at + columns + 2], [at, at + columns + 2, at + columns + 1]);
    }
  }
  const lines = places.map((p) => `v ${p.join(" ")}\nvn ${p.join(" ")}`);
  writeFileSync(join(folder, "ball.obj"), `${lines.join("\n")}\n${faces.map((f) => `f ${f.map((i) => `${i}//${i}`).join(" ")}`).join("\n")}\n`);
  for (const [name, view] of [["ball", BALL], ["behind", BALL_BEHIND]]) {
    const camera = `[camera]\neye = [${view.eye}]\ntarget = [${view.target}]\nfov = ${view.fov}\n`;
    const material = 'material = "white"\n[material.white]\nbase_color = [1, 1, 1]\n';
    writeFileSync(join(folder, `${name}.toml`), `ground = "none"\n[[model]]\nfile = "ball.obj"\n${material}${camera}`);
  }
}

function serve() {
  const types = { ".js": "text/javascript", ".mjs": "text/javascript", ".json": "application/json", ".html": "text/html" };
  const tools = dirname(fileURLToPath(import.meta.url));
  const roots = { modules, rigs: folder, tools };
  const server = createServer((request, response) => {
    const [, root, ...rest] = decodeURIComponent(new URL(request.url, "http://localhost").pathname).split("/");
    const path = roots[root] && join(roots[root], ...rest);
    if (!path || !existsSync(path)) return response.writeHead(404).end();
    response.writeHead(200, { "content-type": types[extname(path)] ?? "application/octet-stream" }).end(readFileSync(path));
  });
  return new Promise((ready) => server.listen(0, "127.0.0.1", () => ready(server)));
}

/** Relative RMSE where both show the ball, but for its rim. */
function error(seen, truth) {
  let [squares, sum, count] = [0, 0, 0];
  const shows = (data, x, y) => Math.max(...data.slice(4 * (y * SIZE + x), 4 * (y * SIZE + x) + 3)) > 0;
  const steps = [-RIM, 0, RIM];
  for (let y = RIM; y < SIZE - RIM; y++) {
    for (let x = RIM; x < SIZE - RIM; x++) {
      const around = steps.flatMap((dy) => steps.map((dx) => [x + dx, y + dy]));
      if (!around.every(([x, y]) => shows(seen, x, y) && shows(truth.data, x, y))) continue;
      for (let c = 0; c < 3; c++) {
        const i = 4 * (y * SIZE + x) + c;
        squares += (seen[i] - truth.data[i]) ** 2;
        sum += truth.data[i];
        count += 1;
      }
    }
  }
  return Math.sqrt(squares / count) / (sum / count);
}

/** Angle between the shadow of the post in a picture from above and the light [degrees]: +x to the right, +z down, rows from the bottom. */
function shadowAngle(seen, towards) {
  const value = (x, y) => seen[4 * (y * SIZE + x)] + seen[4 * (y * SIZE + x) + 1] + seen[4 * (y * SIZE + x) + 2];
  const all = Array.from({ length: SIZE * SIZE }, (_, i) => value(i % SIZE, Math.floor(i / SIZE))).sort((a, b) => a - b);
  const ground = all[Math.floor(0.75 * all.length)];
  let [x, z, count] = [0, 0, 0];
  for (let j = 0; j < SIZE; j++) {
    for (let i = 0; i < SIZE; i++) {
      if (value(i, j) > 0.4 * ground) continue;
      x += i + 0.5 - SIZE / 2;
      z += SIZE / 2 - j - 0.5;
      count += 1;
    }
  }
  if (count < 20) throw new Error("there is no shadow");
  const cosine = -(x * towards[0] + z * towards[2]) / (Math.hypot(x, z) * Math.hypot(towards[0], towards[2]));
  return (Math.acos(Math.min(1, cosine)) * 180) / Math.PI;
}

async function inBrowser(page, base, name, file, count) {
  gnomon("decompose", options.env, "--format", name, "-o", join(folder, file));
  const same = ["--lights", "disks", "--light-count", count, "-o", join(folder, `${name}_lights.json`)];
  gnomon("decompose", options.env, ...same);
  const { lights } = JSON.parse(readFileSync(join(folder, `${name}_lights.json`)));
  await page.goto(`${base}/tools/rig_checks.html?${name}`);
  await page.waitForFunction(() => window.ready, null, { timeout: 60000 });
  const draw = (request) => page.evaluate((request) => window.draw(request), { url: `${base}/rigs/`, file, size: SIZE, ...request });
  const errors = [];
  for (const [scene, view] of [["ball", BALL], ["behind", BALL_BEHIND]]) {
    const truth = join(folder, `${name}_${scene}.exr`);
    const rig = ["--rig", join(folder, `${name}_lights.json`), "--background", "none"];
    gnomon("reference", join(folder, `${scene}.toml`), ...rig, "--size", `${SIZE}x${SIZE}`, "--spp", 2048, "-o", truth);
    errors.push(error(await draw({ what: "ball", view }), await linear(truth)));
  }
  const angles = [];
  for (const [index, light] of lights.entries()) {
    const length = Math.hypot(...light.direction);
    const towards = light.direction.map((value) => value / length);
    if (towards[1] < 0.35 || towards[1] > 0.95) continue;
    angles.push(shadowAngle(await draw({ what: "post", light: index }), towards));
  }
  const { data } = await linear(join(folder, `${name}_ball.exr`));
  const shining = data.filter((value, i) => i % 4 < 3 && value > 0);
  const exposure = 0.5 / (shining.reduce((a, b) => a + b) / shining.length);
  const png = await page.evaluate((request) => window.draw(request), { url: `${base}/rigs/`, file, size: 384, what: "boxes", exposure, view: { eye: [3.4, 2.6, 4.2], target: [0.1, 0.4, 0], fov: 40 } });
  writeFileSync(join(folder, `${name}_boxes.png`), Buffer.from(png.split(",")[1], "base64"));
  const shown = (values, digits) => values.map((value) => value.toFixed(digits)).join(", ");
  console.log(`${name}: ${lights.length} lights; balls off by ${shown(errors, 3)}; shadows turned by ${shown(angles, 2)} degrees`);
  return Math.max(...errors) <= MOST_ERROR && angles.length > 0 && Math.max(...angles) <= MOST_ANGLE;
}

async function gltf() {
  const { default: validator } = await load("gltf-validator/index.js");
  const path = join(folder, "rig.gltf");
  gnomon("decompose", options.env, "-o", path);
  const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(path)), { uri: "rig.gltf" });
  console.log(`gltf: ${issues.numErrors} errors, ${issues.numWarnings} warnings, ${issues.numInfos} hints`);
  issues.messages.forEach(({ code, pointer }) => console.log(`  ${code} ${pointer}`));
  return issues.numErrors + issues.numWarnings === 0;
}

writeBall();
let holds = await gltf();
const { chromium } = (await load("playwright-core/index.js")).default;
const places = [process.env.GNOMON_CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
const executablePath = places.find((path) => path && existsSync(path));
const browser = await chromium.launch({ executablePath, headless: true, args: ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--no-sandbox"] });
const server = await serve();
const page = await browser.newPage({ viewport: { width: 400, height: 400 } });
page.on("pageerror", (fault) => console.error(fault));
page.on("console", (line) => line.type() === "error" && console.error(line.text()));
const base = `http://127.0.0.1:${server.address().port}`;
holds = (await inBrowser(page, base, "three", "three_rig.json", 8)) && holds;
holds = (await inBrowser(page, base, "babylon", "rig.babylon", 4)) && holds;
await browser.close();
server.close();
process.exit(holds ? 0 : 1);
