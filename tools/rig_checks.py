#!/usr/bin/env python3
"""Light rigs of `gnomon decompose` in the programs that they are for, against `gnomon reference` under the same lights.

    pip install mitsuba numpy usd-core mujoco bpy    # those that are there are checked
    tools/rig_checks.py --gnomon target/release/gnomon --env grace.hdr --output out/rigs

The scene is a matt floor with a slanted box and a post, direct light only. For each program: relative RMSE against the reference under the
rig's lights, which tells whether axes and units are right, and against that under the whole map, which adds the fit's own error.
"""

import argparse
import importlib.util
import math
import subprocess
import sys
from pathlib import Path

import numpy

WIDTH, HEIGHT, FOV = 64, 48, 40.0
EYE, TARGET = (3.4, 2.6, 4.2), (0.1, 0.4, 0.0)
REFLECTANCE = 0.5
BOXES = [((-0.7, 0.0, -0.5), (0.5, 0.8, 0.4), 25.0), ((0.9, 0.0, 0.5), (1.0, 1.4, 0.6), 0.0)]


def box(low, high, degrees):
    """Corners and quads of a box turned about +y."""
    sin, cos = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    corners = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    corners = [(cos * x + sin * z, y, cos * z - sin * x) for x, y, z in corners]
    return corners, [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def geometry():
    """Vertices and quads of the scene, y up."""
    vertices = [(-4, 0, 4), (4, 0, 4), (4, 0, -4), (-4, 0, -4)]
    quads = [(0, 1, 2, 3)]
    for low, high, degrees in BOXES:
        corners, faces = box(low, high, degrees)
        quads += [tuple(len(vertices) + index for index in face) for face in faces]
        vertices += corners
    return vertices, quads


def write_scene(folder):
    vertices, quads = geometry()
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + ["f " + " ".join(str(i + 1) for i in q) for q in quads]
    (folder / "scene.obj").write_text("\n".join(lines) + "\n")
    (folder / "scene.toml").write_text(
        f"ground = \"none\"\n[[model]]\nfile = \"scene.obj\"\nmaterial = \"matt\"\n[material.matt]\nbase_color = {[REFLECTANCE] * 3}\n"
        f"[camera]\neye = {list(EYE)}\ntarget = {list(TARGET)}\nfov = {FOV}\n"
    )


def run(gnomon, *arguments):
    subprocess.run([gnomon, "--quiet", *map(str, arguments)], check=True)


def read(path):
    import mitsuba

    bitmap = mitsuba.Bitmap(str(path)).convert(mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.Float32, False)
    return numpy.array(bitmap, dtype=numpy.float64)


def error(picture, truth, mask):
    """Relative RMSE over pixels that show the scene."""
    return float(numpy.sqrt(numpy.mean((picture[mask] - truth[mask]) ** 2)) / numpy.mean(truth[mask]))


def inside(mask):
    """Pixels whose neighbours are in the mask, too: at its edge the lights themselves are seen."""
    padded = numpy.pad(mask, 1)
    shifts = [padded[1 + y : padded.shape[0] - 1 + y, 1 + x : padded.shape[1] - 1 + x] for x in (-1, 0, 1) for y in (-1, 0, 1)]
    return numpy.logical_and.reduce(shifts)


def mitsuba_picture(folder, rig, spp=256):
    import mitsuba

    vertices, quads = geometry()
    path = folder / "scene.ply"
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    # Flat faces: no vertex is shared.
    points = [vertices[i] for t in triangles for i in t]
    header = (
        f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = [f"{x} {y} {z}" for x, y, z in points] + [f"3 {3 * i} {3 * i + 1} {3 * i + 2}" for i in range(len(triangles))]
    path.write_text(header + "\n".join(rows) + "\n")
    text = Path(rig).read_text().replace(
        "</scene>",
        f"""<integrator type="direct"/>
<sensor type="perspective"><float name="fov" value="{FOV}"/><string name="fov_axis" value="x"/>
<transform name="to_world"><lookat origin="{EYE[0]}, {EYE[1]}, {EYE[2]}" target="{TARGET[0]}, {TARGET[1]}, {TARGET[2]}" up="0, 1, 0"/></transform>
<sampler type="multijitter"><integer name="sample_count" value="{spp}"/></sampler>
<film type="hdrfilm"><integer name="width" value="{WIDTH}"/><integer name="height" value="{HEIGHT}"/><rfilter type="box"/>
<string name="pixel_format" value="rgb"/></film></sensor>
<shape type="ply"><string name="filename" value="scene.ply"/><boolean name="face_normals" value="true"/>
<bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="{REFLECTANCE}"/></bsdf></bsdf></shape>
</scene>""",
    )
    whole = folder / "mitsuba_scene.xml"
    whole.write_text(text)
    return numpy.array(mitsuba.render(mitsuba.load_file(str(whole))), dtype=numpy.float64)[:, :, :3]


def blender_picture(folder, rig, spp=256):
    """In a process of its own: Cycles and Mitsuba do not share one."""
    subprocess.run([sys.executable, __file__, "--blender", str(folder), str(rig), str(spp)], check=True)
    return read(folder / "blender.exr")


def render_in_blender(folder, rig, spp):
    import bpy
    from mathutils import Vector

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    exec(compile(Path(rig).read_text(), str(rig), "exec"), {"__file__": str(rig), "__name__": "__main__"})
    # As glTF's importer turns it.
    z_up = lambda v: (v[0], -v[2], v[1])
    vertices, quads = geometry()
    mesh = bpy.data.meshes.new("scene")
    mesh.from_pydata([z_up(v) for v in vertices], [], quads)
    material = bpy.data.materials.new("matt")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (REFLECTANCE,) * 3 + (1.0,)
    material.node_tree.links.new(diffuse.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs[0])
    mesh.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("scene", mesh))
    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit, lens.angle = "HORIZONTAL", math.radians(FOV)
    camera = bpy.data.objects.new("camera", lens)
    eye, target = Vector(z_up(EYE)), Vector(z_up(TARGET))
    camera.location = eye
    camera.rotation_mode = "QUATERNION"
    camera.rotation_quaternion = (target - eye).to_track_quat("-Z", "Y")
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.max_bounces = spp, False, 0
    scene.cycles.use_adaptive_sampling, scene.cycles.pixel_filter_type = False, "BOX"
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0.0
    scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = 0
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = WIDTH, HEIGHT, 100
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(Path(folder) / "blender.exr")
    bpy.ops.render.render(write_still=True)


def check_usd(rig):
    from pxr import Usd, UsdLux

    stage = Usd.Stage.Open(str(rig))
    lights = [prim for prim in stage.Traverse() if prim.HasAPI(UsdLux.LightAPI)]
    for prim in lights:
        light = UsdLux.LightAPI(prim)
        assert light.GetIntensityAttr().HasAuthoredValue(), prim.GetPath()
        assert light.GetIntensityAttr().Get() >= 0 and max(light.GetColorAttr().Get()) <= 1.0001
        for attribute in prim.GetAuthoredAttributes():
            assert attribute.Get() is not None and prim.GetPrimDefinition().GetSchemaAttributeSpec(attribute.GetName()) or (
                attribute.GetName().startswith("xformOp:")
            ), attribute.GetPath()
    return len(lights)


def check_mujoco(rig):
    import mujoco

    return mujoco.MjModel.from_xml_path(str(rig)).nlight


def main():
    if sys.argv[1:2] == ["--blender"]:
        return render_in_blender(Path(sys.argv[2]), sys.argv[3], int(sys.argv[4]))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--gnomon", default="gnomon")
    parser.add_argument("--env", required=True)
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--spp", type=int, default=256)
    arguments, fit = parser.parse_known_args()
    folder = arguments.output
    folder.mkdir(parents=True, exist_ok=True)
    write_scene(folder)
    has = lambda module: importlib.util.find_spec(module) is not None
    truth = ["reference", folder / "scene.toml", "--size", f"{WIDTH}x{HEIGHT}", "--spp", arguments.spp]
    run(arguments.gnomon, *truth, "--env", arguments.env, "-o", folder / "whole.exr")

    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    mask = None
    for name, extension, module, picture in [
        ("mitsuba", "xml", "mitsuba", mitsuba_picture),
        ("blender", "py", "bpy", blender_picture),
    ]:
        rig = folder / f"{name}.{extension}"
        run(arguments.gnomon, "decompose", arguments.env, "--format", name, "-o", rig, *fit)
        run(arguments.gnomon, "decompose", arguments.env, "-o", folder / f"{name}.json", *fit)
        run(arguments.gnomon, *truth, "--rig", folder / f"{name}.json", "-o", folder / f"{name}_lights.exr")
        if not has(module):
            print(f"{name}: no {module}")
            continue
        shown = picture(folder, rig, arguments.spp)
        lights, whole = read(folder / f"{name}_lights.exr"), read(folder / "whole.exr")
        if mask is None:
            # What the camera sees behind the scene is another matter.
            run(arguments.gnomon, *truth, "--env", arguments.env, "--background", "none", "-o", folder / "bare.exr")
            mask = inside(read(folder / "bare.exr").sum(axis=2) > 0)
        print(f"{name}: {error(shown, lights, mask):.4f} against the same lights, {error(shown, whole, mask):.4f} against the map;"
              f" the lights themselves {error(lights, whole, mask):.4f}")
    for name, extension, module, check in [("usd", "usda", "pxr", check_usd), ("usd-distant", "usda", "pxr", check_usd), ("mujoco", "xml", "mujoco", check_mujoco)]:
        rig = folder / f"{name}_rig.{extension}"
        run(arguments.gnomon, "decompose", arguments.env, "--format", name, "-o", rig, *fit)
        print(f"{name}: {check(rig)} lights" if has(module) else f"{name}: no {module}")


if __name__ == "__main__":
    main()
