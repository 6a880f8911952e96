"""python_torch_test.py TOP EXAMPLES SCRATCH: crops of a file by a DataLoader of torch: in this process and in workers, forked, spawned
and persistent."""
import multiprocessing
import os
import subprocess
import sys
import unittest

import python_support as support
from python_support import path, waves

support.need("numpy", "torch")
import bccsplat  # noqa: E402
import numpy as np  # noqa: E402
import torch  # noqa: E402
from torch.utils.data import DataLoader  # noqa: E402
from torch_crops import Crops  # noqa: E402  of the examples

SIZE, COUNT = (3, 6, 7, 8), 21
METHODS = [name for name in ("fork", "spawn") if name in multiprocessing.get_all_start_methods()]


class Torch(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        support.fresh_scratch()
        cls.array = waves(20, 12, 14, 16)
        bccsplat.save(path("train.bcc4"), cls.array, abs_error=.01)

    def epochs(self, loader, count=2):
        """The places of each epoch; values are those of the array there."""
        found = []
        for _ in range(count):
            places = []
            for crops, at in loader:
                self.assertEqual((crops.dtype, tuple(crops.shape[1:])), (torch.float32, SIZE))
                for crop, (t, z, y, x) in zip(crops, at.tolist()):
                    right = self.array[t:t + SIZE[0], z:z + SIZE[1], y:y + SIZE[2], x:x + SIZE[3]]
                    np.testing.assert_allclose(crop.numpy(), right, atol=.0101)
                    places.append((t, z, y, x))
            self.assertEqual(len(places), COUNT)
            self.assertGreater(len({*places}), COUNT * 3 // 4)  # no worker has those of another
            found.append(places)
        self.assertNotEqual(*found)
        return found

    def loader(self, dataset=None, **options):
        return DataLoader(dataset or Crops(path("train.bcc4"), SIZE, COUNT), batch_size=4, **options)

    def test_in_this_process_and_in_workers(self):
        def seeded(seed, **options):
            torch.manual_seed(seed)
            return self.epochs(self.loader(**options))

        alone = seeded(5)
        self.assertEqual(seeded(5), alone)
        self.assertNotEqual(seeded(6), alone)
        workers = {"num_workers": 2, "multiprocessing_context": METHODS[0]}
        new, kept = seeded(5, **workers), seeded(5, **workers, persistent_workers=True)
        self.assertEqual(new[0], kept[0])
        for method in METHODS:
            self.assertEqual(seeded(5, num_workers=2, multiprocessing_context=method, persistent_workers=True), kept)

    def test_a_file_that_this_process_has_open(self):
        for method in METHODS:
            dataset = Crops(path("train.bcc4"), SIZE, COUNT)
            next(iter(dataset))
            self.epochs(self.loader(dataset, num_workers=2, multiprocessing_context=method, persistent_workers=True))

    def test_errors_of_workers_come_out(self):
        for method in METHODS:
            with self.assertRaisesRegex(FileNotFoundError, "none.bcc4: cannot open"):
                list(self.loader(Crops(path("none.bcc4"), SIZE, COUNT), num_workers=1, multiprocessing_context=method))

    def test_the_program(self):
        done = subprocess.run([sys.executable, "-B", os.path.join(support.PYTHON, "torch_crops.py"), path("train.bcc4"), "9", "2"],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.count("2 batches of crops (4, 12, 14, 16)") + done.stdout.count("3 batches"), 2, done.stdout)


if __name__ == "__main__":
    support.main()
