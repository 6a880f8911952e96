"""python_remote_test.py TOP EXAMPLES SCRATCH: volumes from URLs, objects of fsspec and open files. A local server delays every
answer and counts the requests."""
import http.server
import io
import os
import pickle
import threading
import time
import unittest

import python_support as support
from python_support import path, waves, without

support.need("numpy")
import numpy as np  # noqa: E402

import bccsplat  # noqa: E402

DELAY = .05


class Ranges(http.server.BaseHTTPRequestHandler):
    """Serves the files of the scratch folder, by ranges unless their name says no."""

    protocol_version = "HTTP/1.1"
    asked = []

    def do_HEAD(self):
        self.answer(False)

    def do_GET(self):
        self.answer(True)

    def answer(self, body):
        time.sleep(DELAY)
        name = path(os.path.basename(self.path))
        if not os.path.exists(name):
            self.send_response(404)
            self.send_header("Content-Length", "0")
            self.end_headers()
            return
        with open(name, "rb") as file:
            content = file.read()
        said, whole = self.headers.get("Range"), len(content)
        if said and "whole" not in name:
            first, last = said.removeprefix("bytes=").split("-")
            content = content[int(first):int(last or whole - 1) + 1]
            self.send_response(206)
            self.send_header("Content-Range", "bytes %s-%s/%d" % (first, last, whole))
        else:
            self.send_response(200)
            self.send_header("Accept-Ranges", "bytes")
        if body:
            self.asked.append(len(content))
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        if body:
            self.wfile.write(content)

    def log_message(self, *_said):
        pass


class Files(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.source = waves(60, 24, 48, 48)
        bccsplat.save(path("series.bcc4"), cls.source, dt=.5, lattice="d4star", levels=1)
        cls.local = bccsplat.open(path("series.bcc4"))

    def test_open_files(self):
        with open(path("series.bcc4"), "rb") as file:
            content = file.read()
            file.seek(7)
            for source in file, io.BytesIO(content):
                volume = bccsplat.open(source)
                np.testing.assert_array_equal(volume[3.5], self.local[3.5])
            self.assertEqual(file.tell(), 7)
        with open(path("series.bcc4"), encoding="latin-1") as file:
            with self.assertRaisesRegex(TypeError, "mode 'rb'"):
                bccsplat.open(file)

    @unittest.skipIf(*without("fsspec"))
    def test_objects_of_fsspec(self):
        import fsspec
        with open(path("series.bcc4"), "rb") as file:
            fsspec.filesystem("memory").pipe("/there.bcc4", file.read())
        for source in "memory://there.bcc4", fsspec.open("memory://there.bcc4"), "file://" + path("series.bcc4"):
            np.testing.assert_array_equal(bccsplat.open(source)[3.5], self.local[3.5])
        with fsspec.open("memory://there.bcc4") as file:
            np.testing.assert_array_equal(bccsplat.open(file)[3.5], self.local[3.5])
        sent = pickle.loads(pickle.dumps(bccsplat.open("memory://there.bcc4")))
        np.testing.assert_array_equal(sent[3.5], self.local[3.5])
        with self.assertRaises(FileNotFoundError):
            bccsplat.open("memory://none.bcc4")


@unittest.skipIf(*without("fsspec"))
@unittest.skipIf(*without("aiohttp"))
class Server(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        bccsplat.save(path("series.bcc4"), waves(60, 24, 48, 48), dt=.5, lattice="d4star", levels=1, overwrite=True)
        cls.local = bccsplat.open(path("series.bcc4"))
        os.link(path("series.bcc4"), path("whole.bcc4"))
        cls.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Ranges)
        threading.Thread(target=cls.server.serve_forever, daemon=True).start()
        cls.url = "http://127.0.0.1:%d/" % cls.server.server_port

    @classmethod
    def tearDownClass(cls):
        cls.server.shutdown()
        cls.server.server_close()

    def counted(self, work):
        """What it returns, the requests for bytes that it took, and their bytes."""
        Ranges.asked.clear()
        found = work()
        return found, len(Ranges.asked), sum(Ranges.asked)

    def test_only_ranges_are_read(self):
        size = os.path.getsize(path("series.bcc4"))
        volume, opening, read = self.counted(lambda: bccsplat.open(self.url + "series.bcc4"))
        frame, first, more = self.counted(lambda: volume[3.5])
        np.testing.assert_array_equal(frame, self.local[3.5])
        _, again, _ = self.counted(lambda: volume[3.5])
        print("over HTTP, %d bytes: opening %d requests, %d bytes; a moment %d, %d" % (size, opening, read, first, more))
        self.assertLessEqual(opening, 4)
        self.assertLessEqual(first, 8)
        self.assertEqual(again, 0)
        self.assertLess(read + more, size / 2)

    @unittest.skipIf(*without("xarray"))
    def test_a_dataset(self):
        import xarray as xr

        from bccsplat.xarray_backend import BccsplatBackend
        right = xr.open_dataset(path("series.bcc4"), engine=BccsplatBackend)
        ds, opening, _ = self.counted(lambda: xr.open_dataset(self.url + "series.bcc4", engine=BccsplatBackend))
        self.assertLessEqual(opening, 4)
        at, asked, _ = self.counted(lambda: ds.isel(x=slice(3, 40)).bcc4.at(1.25))
        self.assertEqual(asked, 0)  # whether it is the file's is told without reading it
        np.testing.assert_array_equal(at.value, right.isel(x=slice(3, 40)).bcc4.at(1.25).value)
        loaded = ds.load()
        whole = os.path.getsize(path("series.bcc4"))
        _, asked, read = self.counted(lambda: loaded.bcc4.at(1.25))
        self.assertLessEqual(read, whole / 4)
        sent = pickle.loads(pickle.dumps(ds))
        np.testing.assert_array_equal(sent.value[5], right.value[5])

    def test_what_goes_wrong_is_said(self):
        with self.assertRaises(FileNotFoundError):
            bccsplat.open(self.url + "none.bcc4")
        with self.assertRaises(bccsplat.Error) as caught:
            bccsplat.open(self.url + "whole.bcc4")
        self.assertRegex(str(caught.exception.__cause__), "the whole file where a part was asked for")


if __name__ == "__main__":
    support.fresh_scratch()
    support.main()
