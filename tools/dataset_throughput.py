"""How fast a data set is drawn by the command, by Python, by Ray and by Open Job Description, and whether all of them draw the same.

    python tools/dataset_throughput.py --gnomon target/debug/gnomon            # 2,000 items, every way, some minutes each
    python tools/dataset_throughput.py --items 100 --only command ray

Each way draws the whole set into a folder of its own. `killed` draws it once more by each of the three engines, which is killed three times at a
random time with all its processes and begun again. `overhead` draws the same items by the command and by Python in turns. Needs the package gnomon, and ray and
openjd-cli for theirs.
"""

import argparse
import hashlib
import os
import random
import resource
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MANIFEST = """
items = {items}
seed = 7
layers = ["depth", "object"]

[scene]
file = {{ list = ["three-boxes", "column"] }}

[environment]
file = {{ any = ["room", "sky"] }}
rotation = {{ min = 0.0, max = 360.0 }}
strength = {{ min = 0.5, max = 2.0 }}

[camera]
azimuth = {{ min = 0.0, max = 360.0 }}
elevation = {{ min = 5.0, max = 60.0 }}
distance = 1.2
fov = 40.0

[[material]]
material = 0
base_color = {{ min = [0.1, 0.1, 0.1], max = [0.9, 0.9, 0.9] }}

[display]
size = [96, 72]
"""
PYTHON = "import sys, gnomon; sys.exit(bool(gnomon.Dataset(sys.argv[1]).write(sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))))"
RAY = """
import sys
import gnomon.ray
import ray
ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
sys.exit(bool(gnomon.ray.write(sys.argv[1], sys.argv[2], workers=2)))
"""
TURNS = 5
"""Of each way where its overhead is measured."""
OVERHEAD_ITEMS = 100
KILLS = 3


class Ways:
    """Commands that draw a manifest's items into a folder."""

    def __init__(self, program, manifest, items):
        self.program, self.manifest, self.items = str(program), str(manifest), items

    def command(self, folder, last=None):
        last = self.items - 1 if last is None else last
        return [self.program, "--quiet", "dataset", self.manifest, "-o", folder, "--range", f"0..{last}"]

    def python(self, folder, last=None):
        last = self.items - 1 if last is None else last
        return [sys.executable, "-c", PYTHON, self.manifest, folder, "0", str(last)]

    def ray(self, folder):
        return [sys.executable, "-W", "ignore", "-c", RAY, self.manifest, folder]

    def openjd(self, folder):
        Path(folder).mkdir(exist_ok=True)
        template = str(ROOT / "integrations/openjd/dataset.yaml")
        given = [f"Manifest={self.manifest}", f"Output={folder}", f"Items=0-{self.items - 1}"]
        return ["openjd", "run", template, *(part for value in given for part in ("-p", value))]


def digest(folder):
    """Of all files of a folder, by their names: what each holds, and how many there are."""
    names = sorted(name for name in os.listdir(folder) if not name.startswith("."))
    total = hashlib.sha256()
    for name in names:
        total.update(name.encode() + hashlib.sha256((Path(folder) / name).read_bytes()).digest())
    return f"{len(names)} files {total.hexdigest()[:16]}"


def run(arguments):
    """Runs to the end: seconds by the clock, and of processors, children included."""
    start, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{arguments[0]} failed:\n{done.stdout[-2000:]}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.monotonic() - start, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def children(process):
    """Numbers of all processes below one (Linux)."""
    parents = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            parents.setdefault(int(stat.read_text().rpartition(")")[2].split()[1]), []).append(int(stat.parent.name))
        except (OSError, ValueError):
            continue
    found = parents.get(process, [])
    return found + [below for child in found for below in children(child)]


def whole(folder):
    return len(list(Path(folder).glob("*.json")))


def killed(ways, name, folder):
    """Draws a set by an engine that is killed at random times, with all its processes, and begun again."""
    generator, engine = random.Random(time.time_ns()), getattr(ways, name)
    for _ in range(KILLS):
        process = subprocess.Popen(engine(folder), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        before, stop = whole(folder) if Path(folder).exists() else 0, None
        while process.poll() is None and (stop is None or time.monotonic() < stop):
            # The time counts from the first item on, so that none is killed before it does anything.
            if stop is None and Path(folder).exists() and whole(folder) > before:
                stop = time.monotonic() + generator.uniform(0, ways.items / 60)
            time.sleep(0.02)
        if process.poll() is not None:
            raise SystemExit(f"{name} ended before it was killed")
        for number in [*children(process.pid), process.pid]:
            try:
                os.kill(number, signal.SIGKILL)
            except ProcessLookupError:
                pass
        process.wait()
        print(f"  {name} killed: {before} items when it began, {whole(folder)} when it died", flush=True)
    run(engine(folder))


def overhead(ways, scratch):
    """Python against the command, in turns."""
    count = min(OVERHEAD_ITEMS, ways.items)
    seconds = {"command": [], "python": []}
    for turn in range(TURNS):
        for name in seconds:
            folder = str(scratch / f"{name}{turn}")
            seconds[name].append(run(getattr(ways, name)(folder, count - 1)))
            shutil.rmtree(folder)
    for what, column in (("clock", 0), ("processors", 1)):
        command, python = (statistics.median(pair[column] for pair in seconds[name]) for name in seconds)
        share = 100 * (python / command - 1)
        print(f"overhead by {what}: command {command:.2f} s, Python {python:.2f} s for {count} items: {share:+.1f} %", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--gnomon", type=Path, default=shutil.which("gnomon") or ROOT / "target/release/gnomon", help="the command")
    parser.add_argument("--items", type=int, default=2000)
    every = ["command", "python", "ray", "openjd", "killed", "overhead"]
    parser.add_argument("--only", nargs="+", choices=every, default=every)
    given = parser.parse_args()
    # The job runs the command by its name.
    os.environ["PATH"] = f"{given.gnomon.resolve().parent}:{os.environ['PATH']}"
    digests = {}
    with tempfile.TemporaryDirectory() as scratch:
        scratch = Path(scratch)
        manifest = scratch / "set.toml"
        manifest.write_text(MANIFEST.format(items=given.items))
        ways = Ways(given.gnomon.resolve(), manifest, given.items)
        for name in given.only:
            folder = str(scratch / name)
            if name == "overhead":
                overhead(ways, scratch)
                continue
            if name == "killed":
                for engine in ("command", "ray", "openjd"):
                    killed(ways, engine, f"{folder}-{engine}")
                    digests[f"killed {engine}"] = digest(f"{folder}-{engine}")
                    print(f"{engine}, killed {KILLS} times: {digests[f'killed {engine}']}", flush=True)
                continue
            clock, processors = run(getattr(ways, name)(folder))
            digests[name] = digest(folder)
            print(f"{name}: {given.items / clock:.1f} items/s, {clock:.0f} s, {processors:.0f} s of processors; {digests[name]}", flush=True)
    if len(set(digests.values())) > 1:
        raise SystemExit("the digests differ")


if __name__ == "__main__":
    main()
