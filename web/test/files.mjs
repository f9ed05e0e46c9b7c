// Models and maps for tests, made by code.

/** A box, from its lowest corner and its size. */
export function box([x, y, z], [w, h, d]) {
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => `v ${x + (i & 1) * w} ${y + ((i >> 1) & 1) * h} ${z + (i >> 2) * d}`);
  const faces = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"].map((face) => `f ${face}`);
  return [...corners, ...faces].join("\n") + "\n";
}

/** A Radiance map: a dim sky, and a bright window. */
export function window_map(width = 64, height = 32) {
  const rgbe = (value) => {
    const exponent = Math.ceil(Math.log2(value + 1e-9));
    return [Math.min(255, Math.round((value / 2 ** exponent) * 255.9)), exponent + 128];
  };
  const bytes = [];
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      const bright = x > 10 && x < 18 && y > 8 && y < 13;
      const [mantissa, exponent] = rgbe(bright ? 40 : y < height / 2 ? 0.5 : 0.2);
      bytes.push(mantissa, mantissa, Math.min(255, mantissa), exponent);
    }
  }
  return Buffer.concat([Buffer.from(`#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${height} +X ${width}\n`), Buffer.from(bytes)]);
}

/** A triangle as a glTF that holds its own buffer. */
export function gltf() {
  const positions = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]);
  const uri = `data:application/octet-stream;base64,${Buffer.from(positions.buffer).toString("base64")}`;
  return JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] }],
    bufferViews: [{ buffer: 0, byteLength: 36 }], buffers: [{ byteLength: 36, uri }],
  });
}

/** Damaged files of every kind, each with a name: 30 of them. */
export function damaged() {
  const good = { "box.obj": Buffer.from(box([0, 0, 0], [1, 1, 1])), "sky.hdr": window_map(), "triangle.gltf": Buffer.from(gltf()) };
  const cut = (bytes, share) => bytes.subarray(0, Math.floor(bytes.length * share));
  const noise = (length, seed) => Buffer.from(Array.from({ length }, (_, i) => (Math.imul(i + seed, 2654435761) >>> 24) & 255));
  const files = [];
  for (const share of [0, 0.01, 0.1, 0.5, 0.9]) {
    files.push([`cut-${share}.hdr`, cut(good["sky.hdr"], share)], [`cut-${share}.gltf`, cut(good["triangle.gltf"], share)]);
  }
  for (const [i, extension] of ["glb", "gltf", "obj", "ply", "stl", "toml", "hdr", "exr", "zip", "bin"].entries()) {
    files.push([`noise.${extension}`, noise(400, 7 * i)]);
  }
  files.push(
    ["empty.glb", []], ["empty.obj", []], ["empty.ply", []], ["empty.exr", []], ["empty.toml", []],
    ["far.obj", "v 1 2 3\nf 1 2 9\n"], ["nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"],
    ["huge.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2000000000 +X 2000000000\n"],
    ["missing.gltf", JSON.stringify({ asset: { version: "2.0" }, buffers: [{ byteLength: 9, uri: "not-there.bin" }], bufferViews: [{ buffer: 0, byteLength: 9 }], accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3" }], meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }], nodes: [{ mesh: 0 }], scenes: [{ nodes: [0] }] })],
    ["old.gltf", JSON.stringify({ asset: { version: "1.0" } })],
  );
  return files;
}
