#!/usr/bin/env python3
"""Emissive panels and lamps of `gnomon render` against Mitsuba 3.

    pip install mitsuba numpy pillow
    tools/lamp_checks.py --gnomon target/release/gnomon --output out/lamps

The scene is that of rig_checks.py, direct light only: a panel with a picture, the same panel plain, and a spot with an IES profile, each with an even faint
sky. Relative RMSE over the whole picture, and over what is not the panel itself or its edge.
"""

import argparse
import json
import math
import subprocess
from pathlib import Path

import numpy

from rig_checks import EYE, FOV, REFLECTANCE, TARGET, error, geometry, read

WIDTH, HEIGHT = 192, 144
SKY = 0.05
STRENGTH = 6.0
# Upper left corner of the panel, its sides to the right and down as its front is seen.
CORNER, RIGHT, DOWN = (-1.5, 1.7, 1.4), (0.0, 0.0, -1.0), (-0.4, -0.7, 0.0)
CUTS = ((30, 90), (40, 60), (30, 30))
LAMP, AIM = (-0.8, 2.2, 1.6), (0.0, 0.2, 0.0)
MOST = 0.04


def picture():
    """A few fields and a ramp, sRGB."""
    y, x = numpy.mgrid[0:64, 0:64] / 64
    pixels = numpy.stack([x, 0.3 + 0.5 * y, 1 - x], -1)
    pixels[(x < 0.4) & (y < 0.5)] = (1.0, 0.8, 0.2)
    pixels[(x > 0.7) & (y > 0.6)] = (0.0, 0.0, 0.0)
    return (pixels * 255).round().astype(numpy.uint8)


def panel_corners():
    corner, right, down = map(numpy.array, (CORNER, RIGHT, DOWN))
    return [corner + right * u + down * v for u, v in ((0, 0), (0, 1), (1, 1), (1, 0))]


def write_panel(folder, name, textured):
    """The panel as glTF: its front is seen from +x."""
    from PIL import Image

    Image.fromarray(picture()).save(folder / "panel.png")
    positions = numpy.array(panel_corners(), "<f4")
    uvs = numpy.array([(0, 0), (0, 1), (1, 1), (1, 0)], "<f4")
    data = positions.tobytes() + uvs.tobytes() + numpy.array([0, 1, 2, 0, 2, 3], "<u2").tobytes()
    (folder / "panel.bin").write_bytes(data)
    material = {"emissiveFactor": [1, 1, 1], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": STRENGTH}}}
    material["pbrMetallicRoughness"] = {"baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 1}
    if textured:
        material["emissiveTexture"] = {"index": 0}
    low, high = positions.min(0).tolist(), positions.max(0).tolist()
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "extensionsUsed": ["KHR_materials_emissive_strength"], "materials": [material],
        "images": [{"uri": "panel.png"}], "textures": [{"source": 0, "sampler": 0}],
        # As in the truth: else texels of the border are mixed with those of the other side.
        "samplers": [{"wrapS": 33071, "wrapT": 33071}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": low, "max": high},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteOffset": at, "byteLength": size} for at, size in ((0, 48), (48, 32), (80, 12))],
        "buffers": [{"uri": "panel.bin", "byteLength": len(data)}],
    }  # fmt: skip
    (folder / f"{name}.gltf").write_text(json.dumps(document))


def write_scene(folder, name, extra):
    vertices, quads = geometry()
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + ["f " + " ".join(str(i + 1) for i in q) for q in quads]
    (folder / "scene.obj").write_text("\n".join(lines) + "\n")
    (folder / f"{name}.toml").write_text(
        f'ground = "none"\n{extra}[[model]]\nfile = "scene.obj"\nmaterial = "matt"\n[material.matt]\nbase_color = {[REFLECTANCE] * 3}\n'
        f"[camera]\neye = {list(EYE)}\ntarget = {list(TARGET)}\nfov = {FOV}\n"
    )


def truth(mitsuba, light, spp):
    vertices, quads = geometry()

    def mesh(name, points, faces, bsdf, **more):
        path = more.pop("folder") / f"{name}.ply"
        header = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\nproperty float s\nproperty float t\n"
        header += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
        rows = [" ".join(map(str, point)) for point in points] + ["3 " + " ".join(map(str, face)) for face in faces]
        path.write_text(header + "\n".join(rows) + "\n")
        return {"type": "ply", "filename": str(path), "face_normals": True, "bsdf": bsdf, **more}

    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    points = [(*vertices[i], 0, 0) for t in triangles for i in t]
    faces = [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(len(triangles))]
    matt = lambda value: {"type": "twosided", "nested": {"type": "diffuse", "reflectance": {"type": "rgb", "value": value}}}
    folder, textured = light.pop("folder"), light.pop("textured", None)
    scene = {
        "type": "scene", "integrator": {"type": "direct"},
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": SKY}},
        "scene": mesh("scene", points, faces, matt(REFLECTANCE), folder=folder),
        "sensor": {
            "type": "perspective", "fov": FOV, "fov_axis": "x",
            "to_world": mitsuba.ScalarTransform4f().look_at(list(EYE), list(TARGET), [0, 1, 0]),
            "film": {"type": "hdrfilm", "width": WIDTH, "height": HEIGHT, "rfilter": {"type": "box"}, "pixel_format": "rgb"},
            "sampler": {"type": "multijitter", "sample_count": spp},
        },
        **light,
    }  # fmt: skip
    if textured is not None:
        radiance = {"type": "rgb", "value": STRENGTH}
        if textured:
            srgb = picture() / 255
            values = numpy.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4) * STRENGTH
            radiance = {"type": "bitmap", "bitmap": mitsuba.Bitmap(values.astype(numpy.float32)), "raw": True, "wrap_mode": "clamp"}
        corners = [(*map(float, p), u, v) for p, (u, v) in zip(panel_corners(), ((0, 0), (0, 1), (1, 1), (1, 0)))]
        scene["panel"] = mesh("panel", corners, [(0, 1, 2), (0, 2, 3)], {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}, folder=folder, emitter={"type": "area", "radiance": radiance})
    return numpy.array(mitsuba.render(mitsuba.load_dict(scene)), dtype=numpy.float64)[:, :, :3]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--gnomon", default="gnomon")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--spp", type=int, default=512)
    arguments = parser.parse_args()
    folder = arguments.output
    folder.mkdir(parents=True, exist_ok=True)

    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    mitsuba.Bitmap(numpy.full((32, 64, 3), SKY, numpy.float32)).write(str(folder / "sky.exr"))
    steps = sorted({0, *(cut for _, cut in CUTS)})
    candela = [sum(value * max(0.0, 1 - angle / cut) for value, cut in CUTS) for angle in steps]
    profile = f"IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 {len(steps)} 1 1 2 0 0 0\n1 1 10\n{' '.join(map(str, steps))}\n0\n{' '.join(map(str, candela))}\n"
    (folder / "lamp.ies").write_text(profile)
    to_lamp = mitsuba.ScalarTransform4f().look_at(list(LAMP), list(AIM), [0, 1, 0])
    spot = lambda value, cut: {"type": "spot", "to_world": to_lamp, "intensity": {"type": "rgb", "value": value}, "cutoff_angle": cut - 1e-3, "beam_width": 1e-3}
    lamp = f'[[light]]\nshape = "spot"\nradius = 0.01\nposition = {list(LAMP)}\ntarget = {list(AIM)}\nprofile = "lamp.ies"\n'
    cases = {
        "plain": ({"textured": False}, '[[model]]\nfile = "plain.gltf"\n'),
        "picture": ({"textured": True}, '[[model]]\nfile = "picture.gltf"\n'),
        "profile": ({f"spot{cut}": spot(float(value), cut) for value, cut in CUTS}, lamp),
    }
    for name, (light, extra) in cases.items():
        if name != "profile":
            write_panel(folder, name, name == "picture")
        write_scene(folder, name, extra)
        true = truth(mitsuba, {"folder": folder, **light}, arguments.spp)
        mitsuba.Bitmap(true.astype(numpy.float32)).write(str(folder / f"{name}_truth.exr"))
        # Where the plain panel is seen; of one with a picture parts are dark.
        if name == "plain":
            panel = true.max(axis=2) > 1.2
        if name == "profile":
            panel = numpy.zeros(true.shape[:2], bool)
        rest = ~numpy.logical_or.reduce([numpy.roll(panel, (y, x), (0, 1)) for y in range(-2, 3) for x in range(-2, 3)])
        for technique in ("auto", "rays"):
            path = folder / f"{name}_{technique}.exr"
            command = ["render", folder / f"{name}.toml", "--env", folder / "sky.exr", "--shadows", technique, "--size", f"{WIDTH}x{HEIGHT}", "--check", 0, "-o", path]
            subprocess.run([arguments.gnomon, "--quiet", *map(str, command)], check=True)
            shown = read(path)
            whole, lit = error(shown, true, numpy.ones(panel.shape, bool)), error(shown, true, rest)
            print(f"{name}, shadows {technique}: {lit:.4f}, with the panel itself {whole:.4f}" + ("" if lit <= MOST else " (too much)"))


if __name__ == "__main__":
    main()
