"""Data sets on a Ray cluster: Ray schedules, starts again what has died, and holds back what nobody takes yet.

>>> import gnomon.ray
>>> failed = gnomon.ray.write("boxes.toml", "/shared/boxes", workers=8)      # files, as `gnomon dataset` writes them
>>> rows = gnomon.ray.items("boxes.toml", workers=8)                         # arrays, as a ray.data.Dataset
>>> for batch in rows.iter_batches(batch_size=32):
...     train(batch["radiance"])

The manifest and the files that it names have to be at the same place on every machine.
"""

import json

import numpy as np
import ray
import ray.data
from ray.util import ActorPool

from . import Dataset

__all__ = ["Worker", "items", "write"]

# A part that died with its worker is drawn by another one; what was whole is kept.
RETRIES = 5
# Ray hands out blocks: enough of them to keep every worker busy.
MOST_BLOCKS = 1000


@ray.remote(max_restarts=-1, max_task_retries=RETRIES)
class Worker:
    """An actor that keeps a graphics device, and on it the scene and the lights of the item before."""

    def __init__(self, manifest, adapter=None):
        self.dataset = Dataset(manifest, adapter)

    def draw(self, item):
        """An item's arrays and what is known beside them."""
        return self.dataset.draw(item)

    def write(self, output, first, last, shards=None, overwrite=False):
        """Draws the items that are not in the folder yet; what failed, item by item."""
        return self.dataset.write(output, first, last, shards=shards, overwrite=overwrite)


def write(manifest, output, *, workers=None, part=32, shards=None, overwrite=False, adapter=None, **resources):
    """Draws a whole data set to a folder that all machines share, in parts of so many items (with ``shards``, of one shard).

    ``workers`` is their number, as many as the cluster has processors or graphics processors where it is left out; ``resources`` are options
    of each actor, as ``num_gpus=1``. Returns what failed: item and sentence.
    """
    count = len(Dataset(manifest, adapter))
    part = shards or part
    resources = {"num_cpus": 1, **resources}
    if workers is None:
        of = "GPU" if resources.get("num_gpus") else "CPU"
        workers = max(1, int(ray.cluster_resources().get(of, 1) // resources[f"num_{of.lower()}s"]))
    parts = [(first, min(first + part, count) - 1) for first in range(0, count, part)]
    # ActorPool hands out a part when a worker is free.
    pool = ActorPool([Worker.options(**resources).remote(manifest, adapter) for _ in range(min(workers, len(parts)))])
    drawn = pool.map_unordered(lambda worker, ends: worker.write.remote(str(output), *ends, shards, overwrite), parts)
    return sorted(failed for of_part in drawn for failed in of_part)


class _Draw:
    """Item numbers to arrays."""

    def __init__(self, manifest, adapter):
        self.dataset = Dataset(manifest, adapter)

    def __call__(self, batch):
        drawn = [self.dataset.draw(int(item)) for item in batch["item"]]
        names = drawn[0][0].keys()
        arrays = {name: np.stack([arrays[name] for arrays, _ in drawn]) for name in names}
        return {"item": batch["item"], **arrays, "record": [json.dumps(record) for _, record in drawn]}


def items(manifest, *, workers=2, batch_size=8, adapter=None, **resources):
    """The items as a ``ray.data.Dataset``: ``item``, ``radiance`` (height, width, 3), the manifest's layers, and ``record``, a line of JSON. They are drawn as they are
    taken."""
    count = len(Dataset(manifest, adapter))
    # Numbers from here: a task that reads them would wait for a processor until the last worker has ended, which waits for the numbers.
    blocks = min(MOST_BLOCKS, -(-count // batch_size))
    numbers = ray.data.from_items([{"item": item} for item in range(count)], override_num_blocks=blocks)
    return numbers.map_batches(
        _Draw,
        fn_constructor_args=(manifest, adapter),
        batch_size=batch_size,
        compute=ray.data.ActorPoolStrategy(size=workers),
        **{"num_cpus": 1, **resources},
    )
