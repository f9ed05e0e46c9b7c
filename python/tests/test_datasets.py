"""Data sets: the command's files, items as arrays, and the engines that run them on many machines."""

import json
import os
import re
import shutil
import subprocess
import time

import gnomon
import numpy as np
import pytest
from conftest import ROOT, skip

MANIFEST = """
items = 8
layers = ["depth", "object"]

[scene]
file = { list = ["three-boxes", "column"] }

[environment]
file = "room"
rotation = { min = 0.0, max = 360.0 }

[camera]
azimuth = { min = 0.0, max = 360.0 }

[fit]
method = "disks"
light_count = 4

[render]
ambient = "unshadowed"
shadow_resolution = 64
supersample = 1

[display]
size = [48, 36]
"""


@pytest.fixture()
def manifest(renderer, tmp_path):
    path = tmp_path / "set.toml"
    path.write_text(MANIFEST)
    return path


@pytest.fixture()
def whole(manifest, tmp_path):
    """The set as one process draws it: bytes of its files by name."""
    assert gnomon.Dataset(manifest).write(tmp_path / "whole") == []
    return contents(tmp_path / "whole")


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir() if not path.name.startswith(".")}


def test_items_are_the_command_s(manifest, whole, command, tmp_path):
    ran = command("dataset", manifest, "-o", tmp_path / "parts", "--range", "0..2")
    assert ran.returncode == 0, ran.stderr
    dataset = gnomon.Dataset(manifest)
    assert len(dataset) == 8
    told = []
    assert dataset.write(tmp_path / "parts", progress=told.append) == [] and told[-1] == 1.0
    assert contents(tmp_path / "parts") == whole
    arrays, record = dataset.draw(5)
    assert np.array_equal(arrays["radiance"], gnomon.read(tmp_path / "whole/000005.exr"))
    line = json.loads(whole["000005.json"])
    assert {key: line[key] for key in record} == record
    with pytest.raises(gnomon.Error, match="it has no items 4 to 8"):
        dataset.write(tmp_path / "parts", 4, 8)
    # What the lines say of boxes is what the layers show.
    camera = gnomon.Camera(world_from_camera=record["camera"]["world_from_camera"], fov=90)
    for thing in record["objects"]:
        is_seen = arrays["object"] == thing["label"]
        assert thing["visible"]["pixels"] == is_seen.sum()
        if is_seen.any():
            rows, columns = np.nonzero(is_seen)
            left, top, right, bottom = thing["visible"]["box_2d"]
            assert (left, top, right, bottom) == (columns.min() - 0.5, rows.min() - 0.5, columns.max() + 0.5, rows.max() + 0.5)
            corners = np.array(np.meshgrid(*np.transpose(thing["box_3d"]), [1])).reshape(4, -1)
            depths = camera.project((np.array(thing["world_from_object"]) @ corners)[:3].T, (48, 36))[:, 2]
            seen = arrays["depth"][is_seen]
            assert depths.min() - 1e-4 < seen.min() and seen.max() < depths.max() + 1e-4


def test_a_lost_device_is_opened_anew(manifest, whole, tmp_path):
    dataset = gnomon.Dataset(manifest)
    arrays, _ = dataset.draw(3)
    dataset._lose_device()
    again, _ = dataset.draw(3)
    assert np.array_equal(arrays["radiance"], again["radiance"])
    dataset._lose_device()
    assert dataset.write(tmp_path / "lost") == [] and contents(tmp_path / "lost") == whole


def test_items_that_fail_are_given(manifest, tmp_path):
    manifest.write_text(MANIFEST.replace('"column"', '"absent.glb"').replace("items = 8", "items = 2"))
    [(item, sentence)] = gnomon.Dataset(manifest).write(tmp_path / "out")
    assert item == 1 and sentence.startswith("there is no scene")


@pytest.mark.filterwarnings("ignore")
def test_a_ray_cluster_draws_the_same_and_survives_a_dead_worker(manifest, whole, tmp_path, monkeypatch):
    monkeypatch.setenv("RAY_ENABLE_UV_RUN_RUNTIME_ENV", "0")
    try:
        import ray

        import gnomon.ray as cluster
    except ImportError:
        skip("the package ray is not installed")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        assert cluster.write(manifest, tmp_path / "ray", workers=2, part=2) == []
        assert contents(tmp_path / "ray") == whole
        rows = cluster.items(str(manifest), workers=2, batch_size=2).take_all()
        assert sorted(row["item"] for row in rows) == list(range(8))
        for row in rows:
            assert json.loads(row["record"])["item"] == row["item"]
            expected = gnomon.read(tmp_path / f"whole/{row['item']:06}.exr")
            assert np.array_equal(row["radiance"], expected) and row["object"].shape == (36, 48)
        worker = cluster.Worker.remote(str(manifest))
        drawing = worker.write.remote(str(tmp_path / "killed"), 0, 7)
        while not list(tmp_path.glob("killed/*.json")):
            time.sleep(0.01)
        ray.kill(worker, no_restart=False)
        assert ray.get(drawing) == []
        assert contents(tmp_path / "killed") == whole
    finally:
        ray.shutdown()


def on_path(monkeypatch, command_program):
    folder = os.path.dirname(os.path.abspath(command_program))
    monkeypatch.setenv("PATH", f"{folder}:{os.environ['PATH']}")


def test_open_job_description_runs_it_in_chunks(manifest, whole, command, tmp_path, monkeypatch):
    if not shutil.which("openjd"):
        skip("openjd-cli is not installed")
    on_path(monkeypatch, os.environ.get("GNOMON_COMMAND", str(ROOT / "target/debug/gnomon")))
    job = ["openjd", "run", ROOT / "integrations/openjd/dataset.yaml", "-p", f"Manifest={manifest}"]
    job += ["-p", f"Output={tmp_path / 'jobs'}", "-p", "Items=0-7", "-p", "Chunk=3"]
    (tmp_path / "jobs").mkdir()
    ran = subprocess.run([str(part) for part in job], capture_output=True, text=True, timeout=600)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert contents(tmp_path / "jobs") == whole


def test_the_tasks_of_a_slurm_array_draw_all_of_it(manifest, whole, command, tmp_path, monkeypatch):
    on_path(monkeypatch, os.environ.get("GNOMON_COMMAND", str(ROOT / "target/debug/gnomon")))
    script = ROOT / "integrations/slurm/dataset.sbatch"
    assert re.search(r"^#SBATCH ", script.read_text(), re.MULTILINE)
    for task in range(3):
        # As Slurm sets them for --array=0-2.
        array = {"SLURM_ARRAY_TASK_ID": task, "SLURM_ARRAY_TASK_COUNT": 3, "SLURM_ARRAY_TASK_MIN": 0}
        environment = {**os.environ, **{key: str(value) for key, value in array.items()}}
        subprocess.run([script, manifest, tmp_path / "slurm", "8"], env=environment, check=True, timeout=600)
    assert contents(tmp_path / "slurm") == whole
