"""Pictures: the command's, bit by bit, whatever was drawn before and on whichever thread."""

import json
import threading

import gnomon
import numpy as np
import pytest
from conftest import QUICK, SIZE, flags

CUBE = """v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
"""


def cube():
    """Vertices and triangles of that file."""
    vertices = [line.split()[1:] for line in CUBE.splitlines() if line.startswith("v")]
    quads = [[int(i) - 1 for i in line.split()[1:]] for line in CUBE.splitlines() if line.startswith("f")]
    triangles = [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])]
    return np.array(vertices, "float32"), np.array(triangles)


@pytest.fixture()
def draw(renderer, room):
    def draw(scene, environment=room, **options):
        return renderer.render(scene, environment=environment, size=SIZE, **QUICK, **options)

    return draw


def test_an_array_is_the_command_s_picture(draw, command, boxes, tmp_path):
    scenes = {"three-boxes": boxes}
    (tmp_path / "cube.obj").write_text(CUBE)
    scenes[tmp_path / "cube.obj"] = gnomon.Scene.load(tmp_path / "cube.obj", up="z", unit="cm")
    for name, scene in scenes.items():
        out = tmp_path / "picture.exr"
        file_options = ["--up", "z", "--unit", "cm"] if name != "three-boxes" else []
        ran = command(
            "render", name, "--env", "room", "--env-rotation", 40, "--env-strength", 2, "--size", "96x72", "--check", 0,
            "-o", out, *file_options, *flags(QUICK),
        )  # fmt: skip
        assert ran.returncode == 0, ran.stderr
        environment = gnomon.Environment.load("room", rotation=40, strength=2)
        radiance = draw(scene, environment=environment)
        assert radiance.shape == (72, 96, 3) and radiance.dtype == np.float32 and radiance.flags.writeable
        assert np.array_equal(radiance, gnomon.read(out)), name
        assert radiance.std() > 0


def test_a_batch_and_any_order_give_the_same_bits(renderer, draw, boxes, room):
    turned = room.rotated(90)
    moved = boxes.copy()
    pose = moved.pose(1)
    pose[1, 3] += 0.5
    moved.set_pose(1, pose)
    singly = [draw(boxes), draw(moved, environment=turned), draw(boxes, environment=turned)]
    told = []
    batch = renderer.render_batch(
        [boxes, moved, boxes], None, [room, turned, turned], size=SIZE, progress=told.append, **QUICK
    )
    assert batch.shape == (3, 72, 96, 3)
    assert np.array_equal(batch, np.stack(singly))
    assert told == sorted(told) and told[-1] == 1.0
    assert not np.array_equal(batch[1], batch[2]), "the pose counts"
    backwards = renderer.render_batch([boxes, moved, boxes], None, [turned, turned, room], size=SIZE, **QUICK)
    assert np.array_equal(backwards[::-1], batch)
    with pytest.raises(gnomon.Error, match="2 cameras do not go with 3 pictures"):
        renderer.render_batch([boxes] * 3, [boxes.camera()] * 2, room)


def test_arrays_make_the_scene_that_a_file_makes(draw, tmp_path):
    (tmp_path / "cube.obj").write_text(CUBE)
    vertices, triangles = cube()
    made = gnomon.Scene(ground="fade")
    made.add_mesh("cube", vertices, triangles)
    assert made.bounds == ([0, 0, 0], [1, 1, 1])
    from_file = gnomon.Scene.load(tmp_path / "cube.obj")
    of_bytes = gnomon.Scene.load(CUBE.encode(), format="obj")
    picture = draw(from_file)
    assert np.array_equal(draw(made), picture)
    assert np.array_equal(draw(of_bytes), picture)
    # Moved vertices are another file's, and back they are the first one's.
    made.set_vertices("cube", vertices * 2)
    (tmp_path / "large.obj").write_text("\n".join(double(line) for line in CUBE.splitlines()))
    assert np.array_equal(draw(made), draw(gnomon.Scene.load(tmp_path / "large.obj")))
    made.set_vertices("cube", vertices)
    assert np.array_equal(draw(made), picture)


def double(line):
    return " ".join(str(2 * int(word)) if word.isdigit() and line[0] == "v" else word for word in line.split())


def test_materials_and_joints_count_from_the_file(draw, boxes, tmp_path):
    grey = draw(boxes)
    name = boxes.materials[0]
    before = boxes.material(name)
    boxes.set_material(name, base_color=(0.8, 0.1, 0.1))
    assert boxes.material(name)["base_color"] == pytest.approx((0.8, 0.1, 0.1))
    assert {**boxes.material(name), "base_color": 0} == {**before, "base_color": 0}
    assert not np.array_equal(draw(boxes), grey)
    boxes.set_material(name, **before)
    assert np.array_equal(draw(boxes), grey)
    boxes.set_joint(1, 90, axis=(0, 1, 0))
    boxes.set_joint(1, 30, axis=(0, 1, 0))
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    turn = gnomon.Scene.load("three-boxes").pose(1) @ np.array([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1]])
    assert np.allclose(boxes.pose(1), turn, atol=1e-6)


def test_threads_share_a_renderer_and_have_their_own(draw, boxes, room):
    expected = draw(boxes)
    other = gnomon.Renderer()
    found = []

    def work(render):
        found.append(render())

    renders = [lambda: draw(boxes), lambda: draw(boxes), lambda: other.render(boxes, None, room, SIZE, **QUICK)]
    threads = [threading.Thread(target=work, args=(render,)) for render in renders]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert len(found) == 3 and all(np.array_equal(picture, expected) for picture in found)


def test_points_are_projected_to_where_they_are_drawn(renderer, room):
    # A small cube against nothing: its picture's middle is its projected middle.
    vertices, triangles = cube()
    scene = gnomon.Scene()
    scene.add_mesh("dot", 0.1 * (vertices - 0.5) + (0.4, 0.3, -0.2), triangles)
    camera = gnomon.Camera(eye=(1, 2, 3), target=(0, 0, 0), fov=40, shift=(0.05, -0.1))
    options = {**QUICK, "background": "none"}
    seen = renderer.render(scene, camera, room, SIZE, **options).sum(axis=2) > 0
    rows, columns = np.nonzero(seen)
    [[column, row, depth]] = camera.project([(0.4, 0.3, -0.2)], SIZE)
    assert abs(columns.mean() - column) < 0.6 and abs(rows.mean() - row) < 0.6
    assert depth == pytest.approx(np.dot([0.6, 1.7, 3.2], np.array([1, 2, 3]) / np.sqrt(14)), rel=1e-5)
    point = camera.intrinsics(SIZE) @ (np.linalg.inv(camera.world_from_camera) @ (0.4, 0.3, -0.2, 1))[:3] * (1, -1, -1)
    projected = camera.intrinsics(SIZE) @ ((np.linalg.inv(camera.world_from_camera) @ (0.4, 0.3, -0.2, 1))[:3] * (1, -1, -1))
    assert projected[:2] / projected[2] == pytest.approx([column, row], abs=1e-3), point


def test_layers_are_arrays_of_their_own_kind(renderer, room):
    vertices, triangles = cube()
    scene = gnomon.Scene()
    node = scene.add_mesh("cube", vertices - 0.5, triangles)
    camera = gnomon.Camera(eye=(0, 0, 3), target=(0, 0, 0), fov=40)
    plain = renderer.render(scene, camera, room, SIZE, **QUICK)
    drawn = renderer.render(scene, camera, room, SIZE, layers=["depth", "object", "normal"], **QUICK)
    assert list(drawn) == ["radiance", "depth", "object", "normal"] and np.array_equal(drawn["radiance"], plain)
    assert drawn["depth"].shape == drawn["object"].shape == (72, 96) and drawn["object"].dtype == np.uint32
    is_cube = drawn["object"] == node + 1
    # Its front face is 2.5 m away, and as wide as OpenCV's matrix says.
    assert np.allclose(drawn["depth"][is_cube], 2.5, atol=1e-5) and np.isinf(drawn["depth"][~is_cube]).all()
    assert np.allclose(drawn["normal"][is_cube], (0, 0, 1), atol=1e-6)
    side = camera.intrinsics(SIZE)[0, 0] / 2.5
    assert abs(is_cube.sum() / side**2 - 1) < 0.05
    batch = renderer.render_batch([scene] * 2, camera, room, SIZE, layers=["object"], **QUICK)
    assert batch["object"].shape == (2, 72, 96) and np.array_equal(batch["object"][1], drawn["object"])
    with pytest.raises(gnomon.Error, match="there is no layer 'depht'; there are: depth, normal"):
        renderer.render(scene, camera, room, SIZE, layers=["depht"])


def test_the_reference_agrees_and_a_check_tells_the_error(renderer, boxes, room):
    radiance = renderer.render(boxes, None, room, SIZE)
    told = []
    truth, variance = gnomon.reference(boxes, None, room, SIZE, samples=64, variance=True, progress=told.append)
    assert truth.shape == variance.shape == (72, 96, 3) and told[-1] == 1.0
    assert np.array_equal(truth, gnomon.reference(boxes, None, room, SIZE, samples=64))
    error = gnomon.compare(radiance, truth)["relative_rmse"]
    checked = gnomon.check(radiance, boxes, None, room, pixels=64)
    # The tracer's own noise is in the one and not in the other.
    noise = np.sqrt(variance.mean(dtype="float64")) / truth.mean(dtype="float64")
    own = np.sqrt(max(error**2 - noise**2, 0))
    assert own < 0.05 and abs(checked["relative_rmse"] - own) < 4 * checked["uncertainty"] + 0.01
    mask = np.zeros((72, 96), bool)
    mask[:10] = True
    assert gnomon.compare(radiance, truth, mask)["pixels"] == 960


def test_a_camera_goes_with_the_node_that_carries_it():
    hand = {"name": "hand", "translation": [0, 1, 0], "children": [1]}
    eye = {"name": "eye", "camera": 0, "translation": [0, 0, 2]}
    lens = {"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}
    file = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [hand, eye], "cameras": [lens]}
    scene = gnomon.Scene.load(json.dumps(file).encode(), format="gltf")
    assert np.allclose(scene.camera("eye").world_from_camera, scene.world_pose("eye"))
    scene.set_joint("hand", 90, axis=(0, 1, 0))
    assert np.allclose(scene.camera("eye").eye, (2, 1, 0), atol=1e-6)
    scene.set_pose("eye", np.eye(4))
    assert np.allclose(scene.camera("eye").world_from_camera, scene.world_pose("hand"), atol=1e-6)
