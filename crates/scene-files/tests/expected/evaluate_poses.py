"""Writes poses.json: where the corners of animated models are, for tests/poses.rs.

An evaluation of its own, from the glTF 2.0 specification alone, in double precision with NumPy. It shares nothing with
the crate that it checks. With --blender it also compares itself with Blender's importer and deformers (pip install bpy), at
times that are keys of the clip: between keys Blender mixes quaternions by component, not along the arc.

    python3 evaluate_poses.py MODELS_FOLDER poses.json [--blender]
"""

import base64
import json
import struct
import sys
from pathlib import Path

import numpy as np

# File, clip (number in the file). Every model of the test data that has a skin, morph targets or moving nodes.
CLIPS = [
    ("AnimatedMorphCube.glb", 0),
    ("BoxAnimated.glb", 0),
    ("BrainStem.glb", 0),
    ("Fox.glb", 0),
    ("Fox.glb", 2),
    ("RiggedSimple.glb", 0),
    ("RobotExpressive.glb", 0),
    ("SimpleSkin.gltf", 0),
    ("sparse_morph_cube.glb", 0),
]
SHARES = [0.0313, 0.2117, 0.4771, 0.6839, 0.9523]
CORNERS = 120

COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Model:
    """A glTF document and its buffers (section 3.6)."""

    def __init__(self, path):
        data = path.read_bytes()
        binary = None
        if data[:4] == b"glTF":
            offset, text = 12, None
            while offset < len(data):
                length, kind = struct.unpack_from("<I4s", data, offset)
                chunk = data[offset + 8 : offset + 8 + length]
                if kind == b"JSON":
                    text = chunk
                elif kind == b"BIN\0":
                    binary = chunk
                offset += 8 + length
        else:
            text = data
        self.json = json.loads(text)
        self.buffers = []
        for buffer in self.json["buffers"]:
            uri = buffer.get("uri")
            if uri is None:
                self.buffers.append(binary)
            elif uri.startswith("data:"):
                self.buffers.append(base64.b64decode(uri.split(",", 1)[1]))
            else:
                self.buffers.append((path.parent / uri).read_bytes())

    def view(self, index):
        view = self.json["bufferViews"][index]
        start = view.get("byteOffset", 0)
        return self.buffers[view["buffer"]][start : start + view["byteLength"]], view.get("byteStride")

    def accessor(self, index):
        """Elements as an array of rows; normalized integers as section 3.6.2.2 has them."""
        entry = self.json["accessors"][index]
        kind = np.dtype(COMPONENTS[entry["componentType"]])
        width, count = WIDTHS[entry["type"]], entry["count"]
        rows = np.zeros((count, width), kind)
        if "bufferView" in entry:
            data, stride = self.view(entry["bufferView"])
            stride = stride or width * kind.itemsize
            for row in range(count):
                rows[row] = np.frombuffer(data, kind, width, entry.get("byteOffset", 0) + row * stride)
        if "sparse" in entry:
            sparse = entry["sparse"]
            data, _ = self.view(sparse["indices"]["bufferView"])
            kind_of_index = np.dtype(COMPONENTS[sparse["indices"]["componentType"]])
            where = np.frombuffer(data, kind_of_index, sparse["count"], sparse["indices"].get("byteOffset", 0))
            data, _ = self.view(sparse["values"]["bufferView"])
            values = np.frombuffer(data, kind, sparse["count"] * width, sparse["values"].get("byteOffset", 0))
            rows[where] = values.reshape(-1, width)
        if entry.get("normalized"):
            return np.maximum(rows / float(np.iinfo(kind).max), -1.0)
        return rows.astype(np.float64) if kind.kind == "f" else rows.astype(np.int64)


def rotation_matrix(q):
    x, y, z, w = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def arc(a, b, t):
    """Spherical interpolation (appendix C.4)."""
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    cosine = a @ b
    if cosine < 0:
        b, cosine = -b, -cosine
    angle = np.arccos(min(cosine, 1.0))
    if angle < 1e-9:
        return a
    return (np.sin((1 - t) * angle) * a + np.sin(t * angle) * b) / np.sin(angle)


def sample(model, sampler, path, time):
    """A sampler's value at a time (appendix C)."""
    times = model.accessor(sampler["input"])[:, 0]
    values = model.accessor(sampler["output"])
    how = sampler.get("interpolation", "LINEAR")
    values = values.reshape(len(times), 3 if how == "CUBICSPLINE" else 1, -1)
    middle = 1 if how == "CUBICSPLINE" else 0
    if time <= times[0]:
        value = values[0, middle]
    elif time >= times[-1]:
        value = values[-1, middle]
    else:
        k = int(np.searchsorted(times, time, side="right")) - 1
        length = times[k + 1] - times[k]
        t = (time - times[k]) / length
        if how == "STEP":
            value = values[k, 0]
        elif how == "LINEAR":
            a, b = values[k, 0], values[k + 1, 0]
            value = arc(a, b, t) if path == "rotation" else (1 - t) * a + t * b
        else:
            value = (
                (2 * t**3 - 3 * t**2 + 1) * values[k, 1]
                + length * (t**3 - 2 * t**2 + t) * values[k, 2]
                + (3 * t**2 - 2 * t**3) * values[k + 1, 1]
                + length * (t**3 - t**2) * values[k + 1, 0]
            )
    return value / np.linalg.norm(value) if path == "rotation" else value


def corners(model, clip, time):
    """World positions of all triangle corners: the scene's nodes depth first, their primitives in order."""
    document = model.json
    nodes = [dict(node) for node in document["nodes"]]
    if time is not None:
        animation = document["animations"][clip]
        for channel in animation["channels"]:
            target = channel["target"]
            if "node" in target:
                sampler = animation["samplers"][channel["sampler"]]
                value = sample(model, sampler, target["path"], time)
                nodes[target["node"]][target["path"]] = value
    world, order = {}, []

    def visit(index, parent):
        node = nodes[index]
        local = np.eye(4)
        if "matrix" in node:
            local = np.array(node["matrix"], float).reshape(4, 4).T
        else:
            turn = np.array(node.get("rotation", [0, 0, 0, 1]), float)
            local[:3, :3] = rotation_matrix(turn) * np.array(node.get("scale", [1, 1, 1]), float)
            local[:3, 3] = node.get("translation", [0, 0, 0])
        world[index] = parent @ local
        order.append(index)
        for child in node.get("children", []):
            visit(child, world[index])

    for root in document["scenes"][document.get("scene", 0)]["nodes"]:
        visit(root, np.eye(4))
    found = []
    for index in order:
        node = nodes[index]
        if "mesh" not in node:
            continue
        mesh = document["meshes"][node["mesh"]]
        weights = node.get("weights", mesh.get("weights", []))
        for primitive in mesh["primitives"]:
            found.append(primitive_corners(model, node, primitive, weights, world, world[index]))
    return np.concatenate(found)


def primitive_corners(model, node, primitive, weights, world, world_from_node):
    attributes = primitive["attributes"]
    positions = model.accessor(attributes["POSITION"]).astype(float)
    for weight, target in zip(weights, primitive.get("targets", [])):
        if "POSITION" in target:
            positions = positions + weight * model.accessor(target["POSITION"])
    homogeneous = np.concatenate([positions, np.ones((len(positions), 1))], axis=1)
    if "skin" in node and "JOINTS_0" in attributes:
        skin = model.json["skins"][node["skin"]]
        binds = [np.eye(4)] * len(skin["joints"])
        if "inverseBindMatrices" in skin:
            binds = [row.reshape(4, 4).T for row in model.accessor(skin["inverseBindMatrices"])]
        bones = np.array([world[joint] @ bind for joint, bind in zip(skin["joints"], binds)])
        joints, shares, number = [], [], 0
        while f"JOINTS_{number}" in attributes:
            joints.append(model.accessor(attributes[f"JOINTS_{number}"]))
            shares.append(model.accessor(attributes[f"WEIGHTS_{number}"]).astype(float))
            number += 1
        joints, shares = np.concatenate(joints, axis=1), np.concatenate(shares, axis=1)
        shares = shares / shares.sum(axis=1, keepdims=True)
        placed = np.einsum("vj,vjrc,vc->vr", shares, bones[joints], homogeneous)[:, :3]
    else:
        placed = (homogeneous @ world_from_node.T)[:, :3]
    if "indices" in primitive:
        return placed[model.accessor(primitive["indices"])[:, 0]]
    return placed


def duration(model, clip):
    samplers = model.json["animations"][clip]["samplers"]
    return max(float(model.accessor(sampler["input"]).max()) for sampler in samplers)


def short(values):
    return [float(f"{value:.7g}") for value in values]


def entries(folder):
    for name, clip in CLIPS:
        model = Model(folder / name)
        length = duration(model, clip)
        poses = []
        for time in [None] + [round(share * length, 4) for share in SHARES]:
            found = corners(model, clip, time)
            stride = max(1, len(found) // CORNERS)
            poses.append(
                {
                    "time": time,
                    "min": short(found.min(axis=0)),
                    "max": short(found.max(axis=0)),
                    "corners": [short(corner) for corner in found[::stride]],
                }
            )
        yield {
            "model": name,
            "clip": clip,
            "duration": length,
            "count": len(found),
            "stride": stride,
            "poses": poses,
        }


def compare_with_blender(folder):
    """Prints the largest distance between this evaluation's bounds and Blender's, over the model's size."""
    import bpy

    for name, clip in CLIPS:
        model = Model(folder / name)
        bpy.ops.wm.read_factory_settings(use_empty=True)
        # With other rules for the direction of bones the importer places rigid meshes on scaled bones wrongly.
        bpy.ops.import_scene.gltf(filepath=str(folder / name), bone_heuristic="FORTUNE")
        scene = bpy.context.scene
        rate = scene.render.fps / scene.render.fps_base
        # Each clip is a track of its own on every object that it moves. Tracks begin at frame 1: play the action itself.
        wanted = model.json["animations"][clip].get("name")
        blocks = list(bpy.data.objects) + [mesh.shape_keys for mesh in bpy.data.meshes if mesh.shape_keys]
        for block in blocks:
            data = block.animation_data
            if data is None:
                continue
            data.action = None
            for track in data.nla_tracks:
                track.mute = True
                if wanted is None or track.name == wanted:
                    data.action = track.strips[0].action
                    data.action_slot = track.strips[0].action_slot
        sampler = model.json["animations"][clip]["samplers"][0]
        keys = model.accessor(sampler["input"])[:, 0]
        worst = 0.0
        for share in SHARES:
            time = float(keys[int(share * len(keys))])
            frame = time * rate
            scene.frame_set(int(np.floor(frame)), subframe=frame - np.floor(frame))
            graph = bpy.context.evaluated_depsgraph_get()
            points = []
            for item in scene.objects:
                # The importer draws bones with a mesh of its own, in a collection that is not shown.
                if item.type != "MESH" or item.name.startswith("Icosphere"):
                    continue
                evaluated = item.evaluated_get(graph)
                shape = evaluated.to_mesh()
                flat = np.zeros(3 * len(shape.vertices))
                shape.vertices.foreach_get("co", flat)
                matrix = np.array(evaluated.matrix_world)
                points.append(flat.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3])
                evaluated.to_mesh_clear()
            points = np.concatenate(points)
            # Blender's z is up.
            points = np.stack([points[:, 0], points[:, 2], -points[:, 1]], axis=1)
            ours = corners(model, clip, time)
            size = np.linalg.norm(ours.max(axis=0) - ours.min(axis=0))
            apart = max(
                np.abs(points.min(axis=0) - ours.min(axis=0)).max(),
                np.abs(points.max(axis=0) - ours.max(axis=0)).max(),
            )
            # Every strided corner has a vertex of Blender's at the same place.
            for corner in ours[:: max(1, len(ours) // CORNERS)]:
                apart = max(apart, np.sqrt(((points - corner) ** 2).sum(axis=1).min()))
            worst = max(worst, apart / size)
        print(f"{name}, clip {clip}: {worst:.1e} of the model's size from Blender", file=sys.stderr)


def main():
    folder, output = Path(sys.argv[1]), Path(sys.argv[2])
    lines = ",\n".join(json.dumps(entry, separators=(",", ":")) for entry in entries(folder))
    output.write_text(f"[\n{lines}\n]\n")
    if "--blender" in sys.argv:
        compare_with_blender(folder)


main()
