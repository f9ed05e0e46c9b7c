"""What is around pictures: errors, arrays in and out, pickles, signals, forks, notebooks."""

import copy
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time

import gnomon
import numpy as np
import pytest
from conftest import QUICK, SIZE
from test_pictures import cube


def test_an_error_is_the_command_s_sentence(command, tmp_path):
    (tmp_path / "broken.glb").write_bytes(b"glTF no more")
    (tmp_path / "broken.hdr").write_bytes(b"#?RADIANCE\n\nno size")
    cases = [
        (lambda: gnomon.Scene.load("absent.glb"), ["render", "absent.glb", "--env", "room"]),
        (lambda: gnomon.Scene.load(tmp_path / "broken.glb"), ["render", tmp_path / "broken.glb", "--env", "room"]),
        (lambda: gnomon.Environment.load("absent.hdr"), ["render", "three-boxes", "--env", "absent.hdr"]),
        (
            lambda: gnomon.Environment.load(tmp_path / "broken.hdr"),
            ["render", "three-boxes", "--env", tmp_path / "broken.hdr"],
        ),
        (lambda: gnomon.Renderer("no such adapter"), ["render", "three-boxes", "--env", "room", "--adapter", "no such adapter"]),
    ]  # fmt: skip
    for call, arguments in cases:
        with pytest.raises(gnomon.Error) as raised:
            call()
        ran = command(*arguments, "-o", tmp_path / "x.exr")
        assert ran.returncode == 2
        assert ran.stderr.strip().removeprefix("gnomon: error: ") == str(raised.value)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda boxes: gnomon.Scene.load("three-boxes", shadow="pcss"), "there is no option `shadow`"),
        (lambda boxes: gnomon.Scene.load("three-boxes", light_count=-1), "it takes a whole number from 1"),
        (lambda boxes: gnomon.Scene.load("three-boxes", light_count=3, threshold=0.1), "exclude each other"),
        (lambda boxes: gnomon.Scene.load("three-boxes", shadows=object()), "cannot be a object"),
        (lambda boxes: gnomon.Scene.load(b"what is this"), "give format="),
        (lambda boxes: gnomon.Scene.load(3), "a path, the name of a built-in one, or bytes"),
        (lambda boxes: gnomon.Environment.load(np.zeros((4, 4, 3))), "twice as wide as high, not 4 x 4"),
        (lambda boxes: gnomon.Environment.load(np.zeros((0, 0, 3))), "twice as wide as high, not 0 x 0"),
        (lambda boxes: boxes.set_pose(1, "abc"), "parent_from_node must be an array of numbers: ValueError"),
        (lambda boxes: gnomon.reference(boxes, size=(-1, 4)), "whole pixels from 1, not (-1, 4)"),
        (lambda boxes: gnomon.Camera(eye=(0, 0, 1), target=(0, 0, 0), fov=40).intrinsics((0, 4)), "not (0, 4)"),
        (lambda boxes: gnomon.Environment.load(np.zeros((4, 8))), "must be an array (..., 3), not [4, 8]"),
        (lambda boxes: boxes.set_pose("nobody", np.eye(4)), "there is no node 'nobody'"),
        (lambda boxes: boxes.set_pose(99, np.eye(4)), "there is no node 99"),
        (lambda boxes: boxes.set_pose(1, np.full((4, 4), np.nan)), "must be finite"),
        (lambda boxes: boxes.set_pose(1, np.ones((4, 4))), "the last row of parent_from_node must be 0, 0, 0, 1"),
        (lambda boxes: boxes.set_material(0, roughness=7), "roughness must be 0 to 1"),
        (lambda boxes: boxes.set_material(0, model="phong"), "phong needs 'shininess'"),
        (lambda boxes: boxes.play("walk"), "there is no clip 'walk'"),
        (lambda boxes: boxes.add_mesh("m", np.zeros((3, 3)), [[0, 1, 3]]), "indices of the 3 vertices"),
        (lambda boxes: boxes.add_mesh("m", np.zeros((3, 3)), [[0, 1, 2]], normals=np.zeros((2, 3))), "2 normals of 3"),
        (lambda boxes: gnomon.Camera("eye=0,0,1"), "target is missing"),
        (lambda boxes: gnomon.Camera(eye=(0, 0, 1), target=(0, 0, 0)), "missing field `fov`"),
        (lambda boxes: gnomon.reference(boxes, size=SIZE), "brings no environment"),
        (lambda boxes: gnomon.reference(boxes, "front", gnomon.Environment.load("room")), "no camera 'front'"),
        (lambda boxes: gnomon.compare(np.zeros((2, 2, 3)), np.zeros((2, 3, 3))), "must be equally large"),
        (lambda boxes: gnomon.compare(np.full((2, 2, 3), np.nan), np.zeros((2, 2, 3))), "NaN"),
    ],
)
def test_what_cannot_be_is_told(boxes, call, sentence):
    with pytest.raises(gnomon.Error) as raised:
        call(boxes)
    assert sentence in str(raised.value) and "\n" not in str(raised.value)


class OnlyDlpack:
    """An array of another library."""

    def __init__(self, array):
        self.array = array

    def __dlpack__(self, **options):
        return self.array.__dlpack__(**options)

    def __dlpack_device__(self):
        return self.array.__dlpack_device__()


def test_maps_are_arrays_of_any_library():
    random = np.random.default_rng(1).random((8, 16, 3), dtype="float32")
    for given in [random, random.astype("float64"), random[:, ::-1][:, ::-1], random.tolist(), OnlyDlpack(random)]:
        environment = gnomon.Environment.load(given, strength=2)
        assert np.allclose(environment.radiance, 2 * random, rtol=1e-6)
    assert np.from_dlpack(environment.radiance).shape == (8, 16, 3)
    random[0, 0] = np.nan
    cleaned = gnomon.Environment.load(random)
    assert cleaned.warnings == ["1 texels that are no radiance were changed"] and not cleaned.radiance[0, 0].any()


def test_lights_hold_the_flux_of_their_map(room):
    lights = gnomon.fit(room, light_count=12)
    assert len(lights) == len(lights.directions) == len(lights.solid_angles) == 12
    assert np.allclose(np.linalg.norm(lights.directions, axis=1), 1, atol=1e-6)

    def flux(map):
        height, width = map.shape[:2]
        rows = np.cos(np.linspace(0, np.pi, height + 1))
        return np.einsum("yxc,y->c", map.astype("float64"), (rows[:-1] - rows[1:]) * 2 * np.pi / width)

    held = (lights.radiance * lights.solid_angles[:, None]).sum(axis=0) + flux(lights.residual)
    assert np.allclose(held, flux(room.radiance), rtol=1e-3)
    turned = gnomon.fit(room.rotated(90), light_count=12)
    c, s = 0, 1
    assert np.allclose(turned.directions, lights.directions @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]), atol=1e-5)


def test_scenes_environments_and_cameras_are_pickled(renderer, room, boxes):
    vertices, triangles = cube()
    boxes.set_joint(1, 20, axis=(0, 1, 0))
    boxes.set_material(0, base_color=0.2)
    boxes.add_mesh("cube", vertices, triangles, base_color=(0.1, 0.2, 0.3), roughness=0.4, pose=np.eye(4))
    boxes.set_vertices("cube", 0.5 * vertices)
    camera = gnomon.Camera(eye=(2, 2, 2), target=(0, 0.3, 0), fov=50)
    environment = gnomon.Environment.load(np.random.default_rng(2).random((8, 16, 3)), tint=(1, 0.5, 0.5)).rotated(30)
    scene = pickle.loads(pickle.dumps(boxes))
    again = pickle.loads(pickle.dumps([camera, environment]))
    picture = renderer.render(boxes, camera, environment, SIZE, **QUICK)
    assert np.array_equal(renderer.render(scene, *again, SIZE, **QUICK), picture)
    # What was turned goes on counting from where it was loaded.
    scene.set_joint(1, 0)
    assert np.allclose(scene.pose(1), gnomon.Scene.load("three-boxes").pose(1))
    copied = copy.deepcopy(boxes)
    copied.set_joint(1, 0)
    assert not np.allclose(copied.pose(1), boxes.pose(1))
    with pytest.raises(TypeError):
        pickle.dumps(renderer)


def test_other_threads_go_on_and_progress_can_stop_the_work(boxes, room):
    counted, done = [0], threading.Event()

    def count():
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    counter = threading.Thread(target=count)
    counter.start()
    gnomon.reference(boxes, None, room, (192, 144), samples=64)
    done.set()
    counter.join()
    assert counted[0] > 5

    def stop(share):
        raise ValueError(f"at {share}")

    with pytest.raises(ValueError, match="at 0"):
        gnomon.reference(boxes, None, room, (512, 384), samples=4096, progress=stop)


@pytest.mark.parametrize(
    "work",
    [
        "gnomon.reference(boxes, None, room, (2048, 1536), samples=1 << 20)",
        "gnomon.check(noise, boxes, None, room, pixels=1 << 20)",
    ],
)
def test_ctrl_c_stops(work):
    code = f"""if True:
        import gnomon
        import numpy as np
        boxes, room = gnomon.Scene.load("three-boxes"), gnomon.Environment.load("room")
        noise = np.random.default_rng(1).random((768, 1024, 3))
        print("ready", flush=True)
        try:
            {work}
        except KeyboardInterrupt:
            print("stopped", flush=True)
    """
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    assert (out, process.returncode) == ("stopped\n", 0)


def in_child(queue):
    try:
        gnomon.Environment.load("room")
        queue.put("loaded")
    except gnomon.Error as error:
        queue.put(str(error))


@pytest.mark.skipif(sys.platform != "linux", reason="no fork")
@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
@pytest.mark.parametrize(("method", "answer"), [("fork", "this process was forked"), ("spawn", "loaded")])
def test_a_forked_process_is_told(room, method, answer):
    context = multiprocessing.get_context(method)
    queue = context.Queue()
    child = context.Process(target=in_child, args=(queue,))
    child.start()
    assert queue.get(timeout=60).startswith(answer)
    child.join()


def test_notebooks_show_pictures(room, tmp_path):
    lights = gnomon.fit(room, light_count=8)
    for shown in [room, lights, gnomon.show(room.radiance, exposure=1)]:
        assert shown._repr_png_().startswith(b"\x89PNG")
    assert gnomon.tone_map(np.ones((2, 3, 3)), tone_mapping="linear").tolist() == [[[255] * 3] * 3] * 2
    gnomon.write(tmp_path / "a.exr", room.radiance)
    assert np.array_equal(gnomon.read(tmp_path / "a.exr"), room.radiance)
    assert "three-boxes" in repr(gnomon.Scene.load("three-boxes")) and "room" in repr(room) and "8 lights" in repr(lights)


def test_the_stubs_name_what_there_is():
    import ast
    from pathlib import Path

    tree = ast.parse((Path(gnomon.__file__).parent / "__init__.pyi").read_text())
    named = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef | ast.FunctionDef)}
    assert set(gnomon.__all__) <= named.keys()
    for name in gnomon.__all__:
        if isinstance(named[name], ast.ClassDef) and not issubclass(getattr(gnomon, name), Exception):
            public = {member for member in vars(getattr(gnomon, name)) if not member.startswith("_")}
            members = {node.name for node in named[name].body if isinstance(node, ast.FunctionDef)}
            assert public == {member for member in members if not member.startswith("_")}, name


@pytest.mark.skipif(sys.platform != "linux", reason="memory is read from /proc")
def test_scene_after_scene_takes_no_more_memory(room):
    code = """if True:
        import sys
        import gnomon
        import numpy as np
        sys.path.insert(0, sys.argv[1])
        from conftest import QUICK
        renderer, room, random = gnomon.Renderer(), gnomon.Environment.load("room"), np.random.default_rng(1)
        for number in range(31):
            scene = gnomon.Scene.load(["three-boxes", "column"][number % 2])
            scene.add_mesh("soup", random.random((12000, 3)), np.arange(12000).reshape(-1, 3))
            renderer.render(scene, None, room, (48, 36), layers=["depth"], **QUICK)
            if number in (10, 30):
                with open("/proc/self/status") as status:
                    print(next(line.split()[1] for line in status if line.startswith("VmRSS")))
    """
    ran = subprocess.run([sys.executable, "-c", code, os.path.dirname(__file__)], capture_output=True, text=True, timeout=120)
    assert ran.returncode == 0, ran.stderr
    early, late = map(int, ran.stdout.split())
    # Kept, the meshes of twenty scenes would be more than that.
    assert late - early < 8 << 10


def test_a_lost_device_is_told_once_and_opened_anew(boxes, room):
    own = gnomon.Renderer()
    before = own.render(boxes, None, room, SIZE, **QUICK)
    own._lose_device()
    with pytest.raises(gnomon.DeviceLost, match="device"):
        own.render(boxes, None, room, SIZE, **QUICK)
    assert np.array_equal(own.render(boxes, None, room, SIZE, **QUICK), before)


def test_strength_and_tint_are_factors_and_fit_nothing(boxes, room):
    own = gnomon.Renderer()
    before = own.render(boxes, None, room, SIZE, **QUICK)
    lights = own.lights
    strong = room.graded(strength=2)
    assert np.array_equal(own.render(boxes, None, strong, SIZE, **QUICK), 2 * before)
    assert np.array_equal(own.lights.radiance, 2 * lights.radiance)
    assert np.array_equal(strong.graded(strength=1, tint=(1, 0.5, 0)).radiance, room.radiance * np.float32([1, 0.5, 0]))
    assert np.array_equal(pickle.loads(pickle.dumps(strong)).radiance, 2 * room.radiance)
    assert np.array_equal(gnomon.fit(strong, light_count=6).radiance, 2 * gnomon.fit(room, light_count=6).radiance)
    truth, double = (gnomon.reference(boxes, None, light, (16, 12), samples=16) for light in (room, strong))
    assert np.array_equal(double, 2 * truth)
    for wrong, sentence in [({"strength": -1}, "strength"), ({"rotation": 3}, "there are: strength, tint")]:
        with pytest.raises(gnomon.Error, match=sentence):
            room.graded(**wrong)
    # Light that is limited becomes lights beside the map, of an array as of a file.
    sun = np.full((8, 16, 3), 0.5, np.float32)
    sun[1, 3] = 1000
    clamped = gnomon.Environment.load(sun, clamp=2)
    assert clamped.radiance.max() <= 2 and len(gnomon.fit(clamped, light_count=6)) > 6



@pytest.mark.skipif(sys.platform != "linux", reason="drivers are named to Vulkan's loader")
def test_without_a_driver_all_but_drawing_works():
    code = """if True:
        import gnomon
        boxes, room = gnomon.Scene.load("three-boxes"), gnomon.Environment.load("room")
        print(len(gnomon.fit(room, light_count=6)), gnomon.reference(boxes, None, room, (8, 6), samples=1).shape)
        try:
            gnomon.Renderer()
        except gnomon.Error as error:
            print(error)
    """
    nothing = {"VK_DRIVER_FILES": "/nonexistent", "VK_ICD_FILENAMES": "/nonexistent", "LIBGL_DRIVERS_PATH": "/nonexistent"}
    environment = {**os.environ, **nothing, "__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent"}
    ran = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=60)
    assert ran.returncode == 0, ran.stderr
    worked, told = ran.stdout.splitlines()
    assert worked == "6 (6, 8, 3)" and "adapter" in told


def test_a_renderer_says_which_adapter_it_took(renderer):
    adapter = renderer.adapter
    assert adapter["usable"] and adapter["reason"] and adapter["name"] in {a["name"] for a in gnomon.adapters()}
    assert adapter["name"] in repr(renderer)
