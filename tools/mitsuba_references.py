#!/usr/bin/env python3
"""Truth pictures by Mitsuba 3 for `gnomon-lab convolution --only maps --truth FOLDER`.

    pip install mitsuba numpy
    tools/mitsuba_references.py --data ../shared/data --output truth

Writes SCENE_ENVIRONMENT.exr (linear RGB, 128 x 96 pixels unless told otherwise) for the scenes three_boxes and bunny under the
environments of that experiment, and maps/ENVIRONMENT.exr, the 512 x 256 latitude-longitude maps they were lit by, which
`gnomon reference SCENE.glb --env maps/ENVIRONMENT.exr` takes as they are. Conventions are those of CONVENTIONS.md and of
reference/renders.json of the test data: direct light only, the environment visible, a box filter, every surface a two-sided
Lambert one of reflectance 0.5 with flat normals. Pictures that exist are kept.
"""

import argparse
import json
import struct
from pathlib import Path

import mitsuba
import numpy

mitsuba.set_variant("scalar_rgb")

WIDTH, HEIGHT = 512, 256
SCENES = {"three_boxes": "scenes/three_boxes.glb", "bunny": "scenes/bunny_on_ground.glb"}
ENVIRONMENTS = {
    "grace": "reference/env_grace_latlong_512x256.exr",
    "stpeters": "reference/env_stpeters_latlong_512x256.exr",
    "galileo": "reference/env_galileo_latlong_512x256.exr",
    "kitchen": "env/debevec_kitchen_cross.hdr",
    "rnl": "env/debevec_rnl_cross.hdr",
    "studio": "env/cc0_studio_small_03_1k.hdr",
    "sunny": "env/cc0_spiaggia_di_mondello_1k.hdr",
}


def read_picture(path):
    """Linear RGB, rows from the top. Radiance files are divided by their EXPOSURE, which Mitsuba does not do."""
    bitmap = mitsuba.Bitmap(str(path)).convert(mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.Float32, False)
    exposure = 1.0
    if path.suffix == ".hdr":
        header = path.read_bytes()[:4096].split(b"\n\n")[0].decode("ascii", "replace")
        for line in header.splitlines():
            if line.startswith("EXPOSURE="):
                exposure *= float(line.removeprefix("EXPOSURE="))
    return numpy.array(bitmap, dtype=numpy.float64) / exposure


def directions(u, v):
    """Unit directions of latitude-longitude coordinates."""
    phi, theta = 2 * numpy.pi * u, numpy.pi * v
    return numpy.sin(theta) * numpy.sin(phi), numpy.cos(theta), -numpy.sin(theta) * numpy.cos(phi)


def cross_lookup(cross, x, y, z):
    """The texel of a vertical cross (3 x 4 faces) in each direction."""
    size = cross.shape[1] // 3
    ax, ay, az = abs(x), abs(y), abs(z)
    # Face column and row, then s to the right and t down; the face below all is +z turned by 180 degrees.
    faces = [
        ((ay >= ax) & (ay >= az) & (y > 0), 1, 0, x / ay, -z / ay),
        ((ay >= ax) & (ay >= az) & (y <= 0), 1, 2, x / ay, z / ay),
        ((ay < numpy.maximum(ax, az)) & (ax > az) & (x > 0), 2, 1, z / ax, -y / ax),
        ((ay < numpy.maximum(ax, az)) & (ax > az) & (x <= 0), 0, 1, -z / ax, -y / ax),
        ((ay < numpy.maximum(ax, az)) & (ax <= az) & (z <= 0), 1, 1, x / az, -y / az),
        ((ay < numpy.maximum(ax, az)) & (ax <= az) & (z > 0), 1, 3, x / az, y / az),
    ]
    found = numpy.zeros(x.shape + (3,))
    for inside, column, row, s, t in faces:
        texel = lambda place: numpy.clip((0.5 + 0.5 * place[inside]) * size, 0, size - 1).astype(int)
        found[inside] = cross[row * size + texel(t), column * size + texel(s)]
    return found


def latlong_map(path):
    """A 512 x 256 map whose texels are means over their areas."""
    picture = read_picture(path)
    height, width = picture.shape[:2]
    if width * 4 == height * 3:
        samples = 6
        u = (numpy.arange(WIDTH * samples) + 0.5) / (WIDTH * samples)
        v = (numpy.arange(HEIGHT * samples) + 0.5) / (HEIGHT * samples)
        v, u = numpy.meshgrid(v, u, indexing="ij")
        fine = cross_lookup(picture, *directions(u, v))
    elif width == 2 * height and width % WIDTH == 0:
        fine, samples = picture, width // WIDTH
    else:
        raise SystemExit(f"{path}: neither a vertical cross nor a latitude-longitude map of {WIDTH} n x {HEIGHT} n texels")
    rows = fine.shape[0]
    area = numpy.sin(numpy.pi * (numpy.arange(rows) + 0.5) / rows)[:, None, None]
    boxes = lambda values: values.reshape(HEIGHT, samples, WIDTH, samples, -1).sum(axis=(1, 3))
    return boxes(fine * area) / boxes(numpy.broadcast_to(area, fine.shape[:2] + (1,)))


def emitter(radiance):
    """Mitsuba reads the columns of a map as areas, as we do, but puts its first and last row on the poles."""
    place = numpy.clip(numpy.arange(HEIGHT) / (HEIGHT - 1) * HEIGHT - 0.5, 0, HEIGHT - 1)
    low = numpy.minimum(place.astype(int), HEIGHT - 2)
    share = (place - low)[:, None, None]
    rows = (1 - share) * radiance[low] + share * radiance[low + 1]
    return {"type": "envmap", "bitmap": mitsuba.Bitmap(rows.astype(numpy.float32))}


def read_glb(path):
    """World-space triangle corners (n x 3 x 3), and the camera as (world from camera, horizontal field of view in degrees)."""
    data = path.read_bytes()
    length = struct.unpack("<I", data[12:16])[0]
    document, binary = json.loads(data[20 : 20 + length]), data[20 + length + 8 :]

    def accessor(index):
        item = document["accessors"][index]
        view = document["bufferViews"][item["bufferView"]]
        kind = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}[item["componentType"]]
        columns = {"SCALAR": 1, "VEC3": 3}[item["type"]]
        start = view.get("byteOffset", 0) + item.get("byteOffset", 0)
        packed = numpy.dtype(kind).itemsize * columns
        stride = view.get("byteStride", packed)
        rows = [binary[start + i * stride : start + i * stride + packed] for i in range(item["count"])]
        return numpy.frombuffer(b"".join(rows), kind).reshape(-1, columns)

    triangles, camera = [], None

    def visit(index, world_from_parent):
        nonlocal camera
        node = document["nodes"][index]
        if "matrix" in node:
            local = numpy.array(node["matrix"]).reshape(4, 4).T
        else:
            x, y, z, w = node.get("rotation", [0, 0, 0, 1])
            local = numpy.eye(4)
            local[:3, :3] = [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ]
            local[:3, :3] *= node.get("scale", [1, 1, 1])
            local[:3, 3] = node.get("translation", [0, 0, 0])
        world = world_from_parent @ local
        if "mesh" in node:
            for primitive in document["meshes"][node["mesh"]]["primitives"]:
                corners = accessor(primitive["attributes"]["POSITION"]) @ world[:3, :3].T + world[:3, 3]
                indices = accessor(primitive["indices"]).ravel() if "indices" in primitive else slice(None)
                triangles.append(corners[indices].reshape(-1, 3, 3))
        if "camera" in node and camera is None:
            lens = document["cameras"][node["camera"]]["perspective"]
            fov_x = 2 * numpy.arctan(numpy.tan(0.5 * lens["yfov"]) * lens.get("aspectRatio", 4 / 3))
            camera = world, float(numpy.degrees(fov_x))
        for child in node.get("children", []):
            visit(child, world)

    for root in document["scenes"][document.get("scene", 0)]["nodes"]:
        visit(root, numpy.eye(4))
    if camera is None:
        raise SystemExit(f"{path} has no camera")
    return numpy.concatenate(triangles), camera


def render(scene, radiance, width, height, samples, seed):
    """Direct light on a scene, linear RGB."""
    triangles, (world_from_camera, fov_x) = scene
    mesh = mitsuba.Mesh("scene", 3 * len(triangles), len(triangles), props=two_sided_lambert())
    parameters = mitsuba.traverse(mesh)
    parameters["vertex_positions"] = triangles.ravel().astype(numpy.float32)
    parameters["faces"] = numpy.arange(3 * len(triangles), dtype=numpy.uint32)
    parameters.update()
    eye, back, up = world_from_camera[:3, 3], world_from_camera[:3, 2], world_from_camera[:3, 1]
    loaded = mitsuba.load_dict({
        "type": "scene",
        "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0},
        "environment": emitter(radiance),
        "mesh": mesh,
        "sensor": {
            "type": "perspective",
            "fov": fov_x,
            "fov_axis": "x",
            "near_clip": 1e-3,
            "to_world": mitsuba.ScalarTransform4f().look_at(list(eye), list(eye - back), list(up)),
            "film": {
                "type": "hdrfilm",
                "width": width,
                "height": height,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": "multijitter", "sample_count": samples},
        },
    })
    return mitsuba.Bitmap(mitsuba.render(loaded, spp=samples, seed=seed))


def two_sided_lambert():
    """Properties of a mesh: vertices are unshared, so that normals are flat."""
    properties = mitsuba.Properties()
    properties["bsdf"] = mitsuba.load_dict({
        "type": "twosided",
        "nested": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}},
    })
    return properties


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, required=True, help="folder of the test data")
    parser.add_argument("--output", type=Path, required=True, help="folder for the pictures; made if missing")
    parser.add_argument("--size", default="128x96", help="pixels, WIDTHxHEIGHT")
    parser.add_argument("--samples", type=int, default=1024, help="samples a pixel")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--scenes", default=",".join(SCENES))
    parser.add_argument("--environments", default=",".join(ENVIRONMENTS))
    options = parser.parse_args()
    width, height = (int(side) for side in options.size.split("x"))
    (options.output / "maps").mkdir(parents=True, exist_ok=True)
    for environment in options.environments.split(","):
        radiance = latlong_map(options.data / ENVIRONMENTS[environment])
        mitsuba.Bitmap(radiance.astype(numpy.float32)).write(str(options.output / "maps" / f"{environment}.exr"))
        for name in options.scenes.split(","):
            target = options.output / f"{name}_{environment}.exr"
            if target.exists():
                continue
            scene = read_glb(options.data / SCENES[name])
            picture = render(scene, radiance, width, height, options.samples, options.seed)
            unfinished = target.with_suffix(".part.exr")
            picture.write(str(unfinished))
            unfinished.rename(target)
            mean = numpy.array(picture).mean()
            print(f"{target}: mean radiance {mean:.5f}", flush=True)


if __name__ == "__main__":
    main()
