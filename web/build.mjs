// Bundles the component and the page into dist/; the WebAssembly lies in wasm/ already.

import { build } from "esbuild";
import { copyFile, mkdir } from "node:fs/promises";

const options = { bundle: true, format: "esm", target: "es2022", minify: true, sourcemap: false, logLevel: "warning", outdir: "dist" };

await mkdir("dist", { recursive: true });
await build({ ...options, entryPoints: ["src/gnomon-viewer.ts", "src/session-worker.ts", "src/tracer-worker.ts"] });
await build({ ...options, entryPoints: ["src/page/page.ts", "src/page/page.css"] });
await Promise.all([
  ...["index.html", "poster.jpg"].map((file) => copyFile(`src/page/${file}`, `dist/${file}`)),
  copyFile("examples/two-viewers.html", "dist/two-viewers.html"),
  copyFile("wasm/gnomon_web_bg.wasm", "dist/gnomon_web_bg.wasm"),
]);
