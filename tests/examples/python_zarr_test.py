"""python_zarr_test.py TOP EXAMPLES SCRATCH: a file as a read-only store of zarr, held to what zarr itself asks of stores."""
import json
import pickle
import unittest

import python_support as support
from python_support import path, waves

support.need("numpy", "zarr")
import numpy as np  # noqa: E402
import zarr  # noqa: E402
from zarr.errors import ReadOnlyError  # noqa: E402

import bccsplat  # noqa: E402
from bccsplat.zarr_store import Store  # noqa: E402


class Zarr(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        support.fresh_scratch()
        source = waves(5, 40, 44, 48)
        bccsplat.save(path("s.bcc4"), {"a": source, "b": 2 * source}, lattice="d4star", levels=2, dt=.1, start=3, time_unit="s",
                      spatial_unit="mm", spacing=(1, 2, 3), origin=(7, 8, 9), attributes={"made": "up"})
        cls.volume = bccsplat.open(path("s.bcc4"))
        cls.store = Store(path("s.bcc4"))

    def test_frames_and_levels(self):
        group = zarr.open_group(self.store, mode="r")
        self.assertEqual([group[name].shape for name in group], [(5, 2, 40, 44, 48), (5, 2, 20, 22, 24), (5, 2, 10, 11, 12)])
        for level in range(3):
            for channel in range(2):
                np.testing.assert_array_equal(group[str(level)][:, channel], self.volume.field(channel, level).read())
        np.testing.assert_array_equal(group["0"][2, 1, 3:9, ::7, -1], self.volume.field(1)[2, 3:9, ::7].__getitem__((..., -1)))
        np.testing.assert_array_equal(zarr.open_consolidated(self.store)["1"][4, 1], self.volume.field(1, 1)[4])

    def test_metadata_of_ngff(self):
        attrs = dict(zarr.open_group(self.store, mode="r").attrs)
        scales, = attrs["multiscales"]
        self.assertEqual(scales["version"], "0.4")
        self.assertEqual([(axis["name"], axis["type"], axis.get("unit")) for axis in scales["axes"]],
                         [("t", "time", "second"), ("c", "channel", None), *((n, "space", "millimeter") for n in "zyx")])
        for level, dataset in enumerate(scales["datasets"]):
            self.assertEqual(dataset["path"], str(level))
            scale, shift = dataset["coordinateTransformations"]
            np.testing.assert_allclose(scale["scale"], [.1, 1, *(np.array([3, 2, 1]) * 2**level)])
            np.testing.assert_allclose(shift["translation"], [3, 0, 9, 8, 7])
        self.assertEqual([channel["label"] for channel in attrs["omero"]["channels"]], ["a", "b"])
        np.testing.assert_allclose(attrs["bcc4"]["times"], self.volume.times())
        self.assertEqual(attrs["bcc4"]["attributes"]["made"], "up")

    def test_axes_that_run_backwards(self):
        affine = np.diag([-2., 3, 4, 1])
        affine[0, 3] = 30
        bccsplat.save(path("back.bcc4"), waves(1, 4, 4, 4), affine=affine)
        scale, shift = json.loads(Store(path("back.bcc4"))[".zattrs"])["multiscales"][0]["datasets"][0]["coordinateTransformations"]
        self.assertEqual(shift["translation"][-1] + 3 * scale["scale"][-1], 24)
        self.assertEqual(scale["scale"][2:4], [4, 3])

    def test_large_frames_are_cut_at_bricks(self):
        bccsplat.save(path("large.bcc4"), waves(1, 40, 260, 300))
        store = Store(path("large.bcc4"))
        chunks = json.loads(store["0/.zarray"])["chunks"]
        self.assertLessEqual(np.prod(chunks), 1 << 21)
        self.assertLess(chunks[4], 300)
        self.assertEqual(len(store["0/0/0/0/0/1"]), 4 * np.prod(chunks))  # at the end, as large as others
        field = zarr.open_group(store, mode="r")["0"][0, 0]
        np.testing.assert_allclose(field, bccsplat.open(path("large.bcc4"))[0], atol=2e-6)
        before = store.file.volume.info().bytes_read
        self.assertEqual(store.getsize("0/0/0/0/0/0"), 4 * np.prod(chunks))
        self.assertEqual(store.file.volume.info().bytes_read, before)

    def test_the_protocol_of_stores(self):
        """What zarr.tests.test_storage asks of a store that was opened for reading, such as a ZipStore."""
        store = self.store
        self.assertTrue(store.is_readable() and store.is_listable())
        self.assertFalse(store.is_writeable() or store.is_erasable())
        with store as entered:
            self.assertIs(entered, store)
        keys = list(store)
        self.assertEqual((len(keys), set(keys), set(keys)), (len(store), set(store.keys()), {key for key, _ in store.items()}))
        self.assertEqual(len(keys), len(set(keys)))
        for key in keys:
            self.assertIn(key, store)
            self.assertEqual(store[key], store.get(key))
            self.assertIsInstance(store[key], bytes)
            self.assertEqual(store.getsize(key), len(store[key]))
        for key in ("foo", "0/0/0/0/0", "0/0/0/0/0/1", "0/5/0/0/0/0", "3/.zarray", "0/00/0/0/0/0", "0/-1/0/0/0/0", "", 3, None):
            self.assertNotIn(key, store)
            with self.assertRaises(KeyError):
                store[key]
            self.assertEqual(store.get(key, b"x"), b"x")
        self.assertEqual(set(store.listdir()), {".zattrs", ".zgroup", ".zmetadata", "0", "1", "2"})
        self.assertEqual(set(store.listdir("0")), {".zarray", ".zattrs", "0", "1", "2", "3", "4"})
        self.assertEqual((store.listdir("0/1"), store.listdir("/0/1/1/0/0/"), store.listdir("9"), store.listdir("0/9"),
                          store.listdir("0/0/0/0/0/0")), (["0", "1"], ["0"], [], [], []))
        found = {"/".join(filter(None, (folder, name))) for folder in self.folders() for name in store.listdir(folder)}
        self.assertEqual({key for key in found if key in store}, set(keys))
        self.assertEqual(store.getsize(), sum(len(store[key]) for key in keys if "/" not in key))
        again = pickle.loads(pickle.dumps(store))
        self.assertEqual((list(again), again[keys[-1]]), (keys, store[keys[-1]]))
        store.close()

    def folders(self, folder=""):
        yield folder
        for name in self.store.listdir(folder):
            child = "/".join(filter(None, (folder, name)))
            if child not in self.store:
                yield from self.folders(child)

    def test_nothing_can_be_written(self):
        group, key = zarr.open_group(self.store, mode="r+"), "0/0/0/0/0/0"
        before = self.store[key]
        for write in (lambda: self.store.__setitem__(key, b""), lambda: self.store.__delitem__(key), self.store.clear,
                      lambda: self.store.pop(key), self.store.popitem, lambda: self.store.update({key: b""}),
                      lambda: self.store.setdefault("x", b""), lambda: self.store.rmdir("0"), lambda: self.store.rename("0", "1"),
                      lambda: group.create_group("x"), lambda: group["0"].__setitem__(0, 1), lambda: group.attrs.update(a=1),
                      lambda: zarr.open_group(self.store, mode="w")):
            with self.assertRaises(ReadOnlyError):
                write()
        self.assertEqual(self.store[key], before)


if __name__ == "__main__":
    support.main()
