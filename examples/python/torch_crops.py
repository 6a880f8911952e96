"""torch_crops.py RUN.bcc4 [CROPS] [WORKERS]: random crops of a series as batches of a DataLoader of torch.

Workers may be forked, spawned or persistent: each opens the file by its path and has its share of the crops, other crops in each
epoch, all of which torch.manual_seed tells. What one crop decodes serves the others of its slab.
"""
import sys

import bccsplat
import torch
from torch.utils.data import DataLoader, IterableDataset, get_worker_info


class Crops(IterableDataset):
    """Pairs of a crop [t, z, y, x], float32, and the place of its first sample; `count` of them in an epoch."""

    def __init__(self, path, size, count):
        self.path, self.size, self.count, self.volume, self.epoch = path, size, count, None, 0

    def __len__(self):
        return self.count

    def __iter__(self):
        worker = get_worker_info()
        number, of = (worker.id, worker.num_workers) if worker else (0, 1)
        self.volume = self.volume or bccsplat.open(self.path, device=bccsplat.Device(threads=1))
        self.epoch += 1
        seed = torch.initial_seed() - number + self.epoch  # the same in all workers
        for place, crop in self.volume.crops(self.size, seed=seed, count=self.count, part=(number, of)):
            yield torch.from_numpy(crop), torch.tensor(place)

    def __getstate__(self):
        return {**self.__dict__, "volume": None}


if __name__ == "__main__":
    path, crops, workers = sys.argv[1], *map(int, [*sys.argv[2:], 64, 2][:2])
    size = [min(n, whole) for n, whole in zip((4, 32, 32, 32), bccsplat.open(path).shape)]
    loader = DataLoader(Crops(path, size, crops), batch_size=8, num_workers=workers, persistent_workers=workers > 0)
    for epoch in range(2):
        batches = [batch.mean() for batch, _ in loader]
        print("epoch %d: %d batches of crops %s, mean %.4g" % (epoch, len(batches), tuple(size), sum(batches) / len(batches)))
