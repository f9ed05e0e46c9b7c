#!/usr/bin/env python3
"""Layers of `gnomon render` in other programs' readers.

    pip install OpenEXR numpy bpy    # those that are there are checked
    tools/layer_checks.py --gnomon target/release/gnomon --output out/layers

OpenEXR's own library finds each layer by its name, the parts of the light add up to the picture, and mattes agree with labels. Blender's Image
node has a socket for each layer.
"""

import argparse
import importlib.util
import json
import subprocess
import sys
from pathlib import Path

LAYERS = "depth,normal,albedo,position,uv,object,material,crypto-object,crypto-material,shadow,diffuse,specular,lights"
NAMES = ["R", "Z", "N.X", "albedo.R", "P.X", "uv.U", "object.X", "material.X", "CryptoObject00.R", "CryptoMaterial02.A", "shadow.R", "diffuse.R", "specular.R"]
SUM = 1e-4


def check_openexr(path):
    import numpy
    import OpenEXR

    file = OpenEXR.File(str(path), separate_channels=True)
    header, channels = file.header(), file.channels()
    assert all(name in channels for name in NAMES), sorted(channels)
    assert channels["object.X"].pixels.dtype == numpy.uint32 and channels["R"].pixels.dtype == numpy.float32
    parts = [name[:-2] for name in channels if name.endswith(".R") and name.split("-")[0] in ("light", "lights", "ambient.R", "emission.R", "reflections.R", "background.R")]
    color = lambda name: numpy.stack([channels[f"{name}.{c}" if name else c].pixels for c in "RGB"], -1)
    off = abs(sum(color(part) for part in parts) - color("")).max() / color("").mean()
    manifest = next(json.loads(text) for name, text in header.items() if name.endswith("/manifest") and header[name.replace("manifest", "name")] == "CryptoObject")
    hashes = {number: int(code, 16) for number, code in enumerate(manifest.values())}
    first, share = channels["CryptoObject00.R"].pixels.view(numpy.uint32), channels["CryptoObject00.G"].pixels
    whole = share == 1.0
    pairs = set(zip(channels["object.X"].pixels[whole].tolist(), first[whole].tolist()))
    assert len(pairs) == len({label for label, _ in pairs}) and {code for _, code in pairs} <= set(hashes.values()), pairs
    print(f"OpenEXR: {len(channels)} channels; {len(parts)} parts of light add up within {off:.1e} of the mean; {len(pairs)} objects by their mattes")
    return off <= SUM


def check_blender(path):
    """In a process of its own."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    image = bpy.data.images.load(str(path))
    tree = bpy.data.node_groups.new("layers", "CompositorNodeTree")
    node = tree.nodes.new("CompositorNodeImage")
    node.image = image
    names = [socket.name for socket in node.outputs]
    matte = tree.nodes.new("CompositorNodeCryptomatteV2")
    matte.source, matte.image = "IMAGE", image
    print(f"Blender: {image.type}, {len(names)} sockets: {', '.join(names)}; mattes of {matte.layer_name}")
    wanted = ["N", "albedo", "P", "CryptoObject00", "shadow", "diffuse", "specular", "light-000", "ambient"]
    assert matte.layer_name.startswith("Crypto")
    assert image.type == "MULTILAYER" and all(name in names for name in wanted), names


def main():
    if sys.argv[1:2] == ["--blender"]:
        return check_blender(Path(sys.argv[2]))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--gnomon", default="gnomon")
    parser.add_argument("--output", type=Path, required=True)
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    path = arguments.output / "layers.exr"
    subprocess.run([arguments.gnomon, "--quiet", "render", "three-boxes", "--env", "room", "--size", "160x120", "--layers", LAYERS, "-o", str(path)], check=True)
    has = lambda module: importlib.util.find_spec(module) is not None
    holds = check_openexr(path) if has("OpenEXR") else print("OpenEXR: skipped, it is not installed") is None
    if has("bpy"):
        holds &= subprocess.run([sys.executable, __file__, "--blender", str(path)]).returncode == 0
    else:
        print("Blender: skipped, there is no bpy")
    sys.exit(0 if holds else 1)


if __name__ == "__main__":
    main()
