"""The render server, asked by plain requests and, where it is installed, by Drake's own client."""

import base64
import hashlib
import http.client
import importlib.util
import json
import socket
import struct
import subprocess
import sys
import threading
import zlib

import gnomon
import gnomon.serve
import numpy as np
import pytest
from conftest import QUICK, skip
from test_pictures import cube

SIZE = (48, 36)
PLACES = [(-0.8, 0.3, 0), (0.8, -0.2, -0.4)]
# Row and column of the middles of their tops, 2.5 and 2.9 m below a camera of 40 pixels.
LEFT, RIGHT = (13, 11), (20, 35)


def gltf(label=(300, 7)):
    """Two boxes in a scene with +z up, coloured as Drake colours labels, and a camera 3 m above that looks down, all of it below one node as in
    Drake's scenes. No turn about an axis takes it to itself."""
    vertices, triangles = cube()
    corners = (vertices - 0.5).astype("<f4")
    indices = triangles.astype("<u2")
    data = corners.tobytes() + indices.tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    material = [
        {"pbrMetallicRoughness": {"baseColorFactor": [(n & 255) / 255, (n >> 8) / 255, 0, 1]}} for n in label
    ]
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [3]}],
        "nodes": [
            {"mesh": 0, "translation": PLACES[0]},
            {"mesh": 1, "translation": PLACES[1]},
            {"camera": 0, "translation": [0, 0, 3]},
            {"children": [0, 1, 2]},
        ],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.01, "zfar": 10, "aspectRatio": 4 / 3}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": n}]} for n in (0, 1)],
        "materials": material,
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [-0.5] * 3, "max": [0.5] * 3},
            {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 96},
            {"buffer": 0, "byteOffset": 96, "byteLength": 72},
        ],
        "buffers": [{"uri": uri, "byteLength": len(data)}],
    }


SCENE = json.dumps(gltf()).encode()
LENS = {"focal_x": 40, "focal_y": 40, "center_x": 24, "center_y": 18, "near": 0.01, "far": 10, "fov_x": 1, "fov_y": 1}


def fields(**changed):
    whole = {"scene": SCENE, "image_type": "color", "width": SIZE[0], "height": SIZE[1], **LENS, **changed}
    if whole["scene"] is not None:
        whole.setdefault("scene_sha256", hashlib.sha256(whole["scene"]).hexdigest())
    return {name: value for name, value in whole.items() if value is not None}


def encoded(form, boundary="frontier"):
    parts = b""
    for name, value in form.items():
        file = '; filename="scene.gltf"' if name == "scene" else ""
        value = value if isinstance(value, bytes) else str(value).encode()
        parts += f'--{boundary}\r\nContent-Disposition: form-data; name="{name}"{file}\r\n\r\n'.encode() + value + b"\r\n"
    return parts + f"--{boundary}--\r\n".encode()


@pytest.fixture(scope="module")
def server(renderer, room):
    server = gnomon.serve.Server(("127.0.0.1", 0), room, **QUICK)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield server
    server.shutdown()
    thread.join()
    server.server_close()


@pytest.fixture()
def post(server):
    def post(form, path="/render", body=None, kind="multipart/form-data; boundary=frontier"):
        connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=120)
        connection.request("POST", path, encoded(form) if body is None else body, {"Content-Type": kind})
        answer = connection.getresponse()
        return answer.status, answer.getheader("Content-Type"), answer.read()

    return post


def labels_of(data):
    """Labels of a PNG file of 8-bit colours that no filter was used on."""
    place, rows = 8, b""
    while place < len(data):
        (length,) = struct.unpack(">I", data[place : place + 4])
        kind, part = data[place + 4 : place + 8], data[place + 8 : place + 8 + length]
        if kind == b"IHDR":
            width, height, bits, color = struct.unpack(">IIBB", part[:10])
            assert (bits, color) == (8, 2)
        rows += part if kind == b"IDAT" else b""
        place += 12 + length
    lines = np.frombuffer(zlib.decompress(rows), np.uint8).reshape(height, 1 + 3 * width)
    red, green, blue = np.moveaxis(lines[:, 1:].reshape(height, width, 3).astype(int), 2, 0)
    assert not blue.any()
    return red + 256 * green


@pytest.mark.parametrize(
    "arguments", [["--env", "nope"], ["--env-rotation", "nan"], ["--adapter", "nosuch"], ["--port", "99999"], ["--host", "192.0.2.1"]]
)
def test_arguments_that_are_no_good_are_one_line(renderer, arguments, capsys):
    with pytest.raises(SystemExit) as ended:
        gnomon.serve.main(["--env", "room", "--port", "0", *arguments])
    said = capsys.readouterr().err
    assert ended.value.code == 2 and said.startswith("python -m gnomon.serve: error: ") and said.count("\n") == 1, said


def test_colour_depth_and_labels_are_those_of_the_scene(post, tmp_path):
    status, kind, image = post(fields())
    assert (status, kind) == (200, "image/png")
    (tmp_path / "color.png").write_bytes(image)
    color = gnomon.read(tmp_path / "color.png")
    assert color.shape == (36, 48, 3)
    status, kind, image = post(fields(image_type="depth", min_depth=2.6, max_depth=2.95))
    assert (status, kind) == (200, "image/tiff")
    depth = np.frombuffer(image[-4 * 48 * 36 :], "<f4").reshape(36, 48)
    assert depth[RIGHT] == pytest.approx(2.9, abs=1e-4) and depth[LEFT] == 0
    # No ground lies under them.
    assert np.isinf(depth[18, 24]) and np.isinf(depth[0, 0])
    status, kind, image = post(fields(image_type="label"))
    assert (status, kind) == (200, "image/png")
    labels = labels_of(image)
    assert set(np.unique(labels)) == {300, 7, gnomon.serve.EMPTY}
    glowing = gltf()
    for material in glowing["materials"]:
        material["emissiveFactor"] = [1, 1, 1]
    status, _, image = post(fields(image_type="label", scene=json.dumps(glowing).encode()))
    assert status == 200 and (labels_of(image) == labels).all(), "lights of surfaces that glow change no label"
    assert (labels[LEFT], labels[RIGHT], labels[18, 24]) == (300, 7, gnomon.serve.EMPTY)
    # The label on the left has a green byte.
    assert color[LEFT][1] > color[RIGHT][1]


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"scene": None}, "scene is missing"),
        ({"scene": b"no scene"}, "scene"),
        ({"scene_sha256": "00"}, "scene_sha256"),
        ({"image_type": "normal"}, "color, depth or label"),
        ({"image_type": "depth"}, "min_depth is missing"),
        ({"width": 0}, "width must be a number from 1 to 4096"),
        ({"height": 1e9}, "height must be"),
        ({"width": "nan"}, "width must be"),
        ({"focal_x": -1}, "focal_x must be"),
        ({"scene": json.dumps({**gltf(), "buffers": [{"uri": "/etc/passwd", "byteLength": 168}]}).encode()}, "passwd"),
        ({"scene": json.dumps({**gltf(), "nodes": [], "scenes": [{}]}).encode()}, "no camera"),
    ],
)
def test_a_bad_request_is_told(post, changed, sentence):
    status, kind, text = post(fields(**changed))
    assert status == 400 and kind == "text/plain" and sentence in text.decode() and text.count(b"\n") == 1


def test_what_is_no_request_is_refused_and_hurts_no_other(server, post, monkeypatch):
    assert post(fields(), path="/etc/passwd")[0] == 404
    assert post({}, body=b"x", kind="text/plain")[0] == 400
    assert post({}, body=encoded(fields())[:300])[0] == 400
    monkeypatch.setattr(gnomon.serve, "LARGEST_BODY", 100)
    assert post(fields())[0] == 413
    monkeypatch.undo()
    # Two clients that say nothing, and requests that do beside them.
    monkeypatch.setattr(gnomon.serve.Handler, "timeout", 1)
    silent = [socket.create_connection(("127.0.0.1", server.server_port)) for _ in range(2)]
    silent[0].sendall(b"POST /render HTTP/1.1\r\nContent-Length: 1000\r\n\r\nnot yet")
    expected = post(fields())
    found = []
    threads = [threading.Thread(target=lambda: found.append(post(fields()))) for _ in range(6)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert found == [expected] * 6 and expected[0] == 200
    assert b"408" in silent[0].recv(100)
    [client.close() for client in silent]
    monkeypatch.setattr(server, "places", threading.BoundedSemaphore(1))
    with server.places:
        assert post(fields())[0] == 503
    assert post(fields()) == expected


def damaged(generator):
    """A body that is no request, or a request that was damaged on its way."""
    body = bytearray(encoded(fields(image_type="label")))
    kind = generator.integers(4)
    if kind == 0:
        return bytes(body[: generator.integers(len(body))])
    if kind == 1:
        return generator.bytes(int(generator.integers(4096)))
    for place in generator.integers(len(body), size=8 if kind == 2 else 1000):
        body[place] = generator.integers(256)
    return bytes(body)


def peak(process):
    """Most memory that a process has had [bytes]."""
    with open(f"/proc/{process.pid}/status") as status:
        return next(int(line.split()[1]) << 10 for line in status if line.startswith("VmHWM"))


@pytest.fixture()
def process(renderer):
    """A server in a process of its own, and its port."""
    command = [sys.executable, "-m", "gnomon.serve", "--env", "room", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            yield process, int(process.stdout.readline().split("/render")[0].rpartition(":")[2])
        finally:
            process.kill()


@pytest.mark.skipif(sys.platform != "linux", reason="memory is read from /proc")
def test_two_hundred_bad_requests_hurt_no_other(process):
    process, port = process

    def post(body, length=None):
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
        head = {"Content-Type": "multipart/form-data; boundary=frontier", "Content-Length": length or len(body)}
        connection.request("POST", "/render", body, head)
        answer = connection.getresponse()
        return answer.status, answer.read()

    good = encoded(fields(image_type="label"))
    expected = post(good)
    assert expected[0] == 200
    before = peak(process)
    silent = [socket.create_connection(("127.0.0.1", port)) for _ in range(10)]
    [client.sendall(b"POST /render HTTP/1.1\r\nContent-Length: 100000000\r\n\r\n") for client in silent[:5]]
    generator = np.random.default_rng(4)
    bodies = [damaged(generator) for _ in range(160)]
    found, drawn = [], []

    def ask(part):
        found.extend(post(body) for body in bodies[part::4])
        # Much is announced and little is sent.
        found.extend(post(b"x" * 100_000, 1 << size) for size in range(29, 37))
        drawn.extend(post(good) for _ in range(4))

    threads = [threading.Thread(target=ask, args=(part,)) for part in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert drawn == [expected] * 16
    # Damage to what counts for nothing, as the file's name, leaves a request.
    refused = [text for status, text in found if 400 <= status < 500]
    assert {status for status, _ in found} <= {200, 400, 413} and len(refused) > 180 and len(found) == 192
    assert all(text.count(b"\n") == 1 and len(text) < 1000 for text in refused)
    assert peak(process) - before < 100 << 20
    [client.close() for client in silent]
    # More connections than are held at once.
    crowd = [socket.create_connection(("127.0.0.1", port)) for _ in range(gnomon.serve.CONNECTIONS + 8)]
    assert b"503" in crowd[-1].recv(100)
    [client.close() for client in crowd]
    assert post(good) == expected
    process.kill()
    assert process.stderr.read() == ""


# The client keeps the interpreter's lock while it waits: it is another process.
CLIENT = """
import sys

import numpy as np
from pydrake.geometry import (
    Box, ClippingRange, ColorRenderCamera, DepthRange, DepthRenderCamera, GeometryInstance, MakeRenderEngineGltfClient,
    PerceptionProperties, RenderCameraCore, RenderEngineGltfClientParams, RenderLabel, Rgba, SceneGraph,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.sensors import CameraInfo

graph = SceneGraph()
params = RenderEngineGltfClientParams(base_url=sys.argv[1], render_endpoint="render")
graph.AddRenderer("gnomon", MakeRenderEngineGltfClient(params))
source = graph.RegisterSource("test")
for place, label in [((-0.8, 0.3, 0), 300), ((0.8, -0.2, -0.4), 7)]:
    properties = PerceptionProperties()
    properties.AddProperty("phong", "diffuse", Rgba(0.8, 0.2, 0.1, 1))
    properties.AddProperty("label", "id", RenderLabel(label))
    box = GeometryInstance(RigidTransform(place), Box(1, 1, 1), str(label))
    box.set_perception_properties(properties)
    graph.RegisterAnchoredGeometry(source, box)
query = graph.get_query_output_port().Eval(graph.CreateDefaultContext())
core = RenderCameraCore("gnomon", CameraInfo(48, 36, 40, 40, 24, 18), ClippingRange(0.01, 10), RigidTransform())
# Drake's cameras look along +z, with +y down.
pose = RigidTransform(RotationMatrix.MakeXRotation(np.pi), (0, 0, 3))
frame = graph.world_frame_id()
np.savez(
    sys.argv[2],
    color=query.RenderColorImage(ColorRenderCamera(core), frame, pose).data,
    depth=query.RenderDepthImage(DepthRenderCamera(core, DepthRange(0.1, 2.95)), frame, pose).data,
    labels=query.RenderLabelImage(ColorRenderCamera(core), frame, pose).data,
    empty=int(RenderLabel.kEmpty),
)
"""


def test_drake_s_client_draws_with_it(server, tmp_path):
    if not importlib.util.find_spec("pydrake"):
        skip("the package drake is not installed")
    address, images = f"http://127.0.0.1:{server.server_port}", tmp_path / "images.npz"
    subprocess.run([sys.executable, "-c", CLIENT, address, images], check=True, timeout=120)
    images = np.load(images)
    color, depth, labels = (images[name] for name in ("color", "depth", "labels"))
    assert images["empty"] == gnomon.serve.EMPTY
    assert color.shape == (36, 48, 4) and color[LEFT][0] > color[LEFT][2]
    assert abs(depth[LEFT] - 2.5) < 1e-3 and abs(depth[RIGHT] - 2.9) < 1e-3 and np.isinf(depth[18, 24])
    assert (labels[LEFT], labels[RIGHT], labels[18, 24]) == (300, 7, gnomon.serve.EMPTY)
