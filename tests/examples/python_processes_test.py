"""python_processes_test.py TOP EXAMPLES SCRATCH: volumes, slices and errors in other processes, by fork and spawn, and what
Ctrl-C ends."""
import concurrent.futures
import copy
import multiprocessing
import os
import pickle
import subprocess
import sys
import unittest

import python_support as support
from python_support import path, waves

support.need("numpy")
import numpy as np  # noqa: E402

import bccsplat  # noqa: E402

# Seconds from Ctrl-C to the prompt: of the clock, or of the processor where others load the machine.
ANSWERED = .3
METHODS = [name for name in ("fork", "spawn") if name in multiprocessing.get_all_start_methods()]
SOURCE = waves(6, 8, 9, 10)


def mean(volume):
    return float(volume[2.5].mean())


def value(cut):
    return float(cut.evaluate([[3.5, 4, 5]])[0])


def total(field):
    return float(field[1].sum())


def failing(volume):
    return volume.at(99)


def missing(name):
    return bccsplat.open(name)


class Others(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        bccsplat.save(path("run.bcc4"), SOURCE, dt=.5)
        cls.volume = bccsplat.open(path("run.bcc4"))

    def test_an_error_of_a_text_alone(self):
        with self.assertRaises(FileNotFoundError) as caught:
            missing(path("none.bcc4"))
        again = type(caught.exception)("Caught in worker 1: " + str(caught.exception))  # as torch raises it
        self.assertEqual(str(again), "Caught in worker 1: " + str(caught.exception))
        self.assertEqual((again.status, str(pickle.loads(pickle.dumps(again)))), (caught.exception.status, str(again)))
        self.assertEqual(bccsplat.Error("why").status, bccsplat.Status.INTERNAL)

    def test_a_pool(self):
        for method in METHODS:
            with multiprocessing.get_context(method).Pool(2) as pool:
                self.assertEqual(pool.map(mean, [self.volume] * 3), [mean(self.volume)] * 3)
                cuts = [self.volume.slice(time=1.2), self.volume.slice(plane=(0, 0, 0, 1, -2)), self.volume.slice(frame=2.4, spacing=.5)]
                np.testing.assert_allclose(pool.map(value, cuts), [value(cut) for cut in cuts], atol=1e-6)
                self.assertEqual(pool.map(total, [self.volume.field()]), [total(self.volume.field())])
                for work, given, kind, status in ((failing, self.volume, bccsplat.Error, "OUT_OF_DOMAIN"),
                                                  (missing, path("none.bcc4"), FileNotFoundError, "FILE_NOT_FOUND")):
                    # Without its own way through pickle the error ends the thread that collects, and get() waits for ever.
                    with self.assertRaises(kind) as caught:
                        pool.apply_async(work, (given,)).get(60)
                    self.assertEqual((caught.exception.status.name, caught.exception.name), (status, "BCCSPLAT_ERROR_" + status))
                self.assertEqual(pool.map(mean, [self.volume]), [mean(self.volume)])  # it goes on

    def test_an_executor(self):
        for method in METHODS:
            with concurrent.futures.ProcessPoolExecutor(2, multiprocessing.get_context(method)) as pool:
                with self.assertRaisesRegex(bccsplat.Error, "time 99 is outside the series"):
                    pool.submit(failing, self.volume).result(60)
                self.assertEqual(pool.submit(mean, self.volume).result(60), mean(self.volume))

    def test_errors_are_the_same_there(self):
        for work, given in ((failing, self.volume), (missing, path("none.bcc4"))):
            with self.assertRaises(bccsplat.Error) as caught:
                work(given)
            here = caught.exception
            for there in pickle.loads(pickle.dumps(here)), copy.copy(here):
                self.assertEqual((type(there), str(there), there.status, there.name), (type(here), str(here), here.status, here.name))
                self.assertIs(type(there.status), bccsplat.Status)
        with self.assertRaises(bccsplat.WouldBlock) as caught:
            bccsplat.open((1 << 20, lambda offset, buffer: None))
        self.assertTrue(caught.exception.ranges)
        self.assertEqual(pickle.loads(pickle.dumps(caught.exception)).ranges, caught.exception.ranges)

    def test_errors_of_files_are_those_of_python(self):
        with self.assertRaises(FileExistsError):
            bccsplat.save(path("run.bcc4"), SOURCE)
        with self.assertRaises(FileNotFoundError):
            bccsplat.open(path("none.bcc4"))
        if os.geteuid():  # root may read everything
            os.chmod(path("run.bcc4"), 0)
            self.addCleanup(os.chmod, path("run.bcc4"), 0o644)
            with self.assertRaises(PermissionError):
                bccsplat.open(path("run.bcc4"))
        from bccsplat.errors import kind_of_status
        forbidden = kind_of_status(bccsplat.abi.ERROR_PERMISSION_DENIED)(bccsplat.abi.ERROR_PERMISSION_DENIED, "N", "t")
        self.assertIsInstance(forbidden, PermissionError)
        self.assertEqual(str(forbidden), "t (N)")

    def test_copies_share(self):
        again, deep = copy.copy(self.volume), copy.deepcopy(self.volume)
        again.close()
        np.testing.assert_array_equal(deep[2], self.volume[2])
        self.assertEqual(copy.copy(self.volume.slice(time=1)).info().dims[:], self.volume.slice(time=1).info().dims[:])

    def test_what_cannot_be_sent_says_so(self):
        with open(path("run.bcc4"), "rb") as file:
            content = file.read()
        renderer = bccsplat.Renderer(bccsplat.default_device())
        for thing, text in ((bccsplat.open(content), "call bccsplat.open there"), (renderer, "renderer cannot be sent"),
                            (bccsplat.CancelToken(), "cancel token cannot be sent"), (bccsplat.default_device(), "device cannot")):
            with self.assertRaisesRegex(TypeError, text):
                pickle.dumps(thing)


PROLOGUE = """
import os, signal, sys, threading, time
import numpy as np
import bccsplat
sent = []
def later(seconds):
    def send():
        time.sleep(seconds)
        sent.append((time.monotonic(), time.process_time()))
        os.kill(os.getpid(), signal.SIGINT)
    threading.Thread(target=send, daemon=True).start()
def noise(frames, n):
    return np.random.default_rng(1).normal(size=(frames, n, n, n)).astype(np.float32)
def answered(work, seconds=.5):
    later(seconds)
    try:
        work()
    except KeyboardInterrupt:
        print("%.3f %.3f" % (time.monotonic() - sent[-1][0], time.process_time() - sent[-1][1]), flush=True)
    else:
        print("it ended before", flush=True)
"""

ENDED = {
    "save": """
a = noise(4, 112)
answered(lambda: bccsplat.save("noise.bcc4", a, abs_error=.01))
print(os.path.exists("noise.bcc4"))
""",
    "plan": """
a = noise(4, 112)
answered(lambda: bccsplat.save("noise.bcc4", a, psnr=50))
print(os.path.exists("noise.bcc4"))
""",
    "show": """
v = bccsplat.open("large.bcc4")
def show():
    while True:
        v.show(1, width=3000, height=3000, quality="best")
answered(show, 1)
print(v[1].shape == (112, 112, 112))
""",
    "reading": """
v = bccsplat.open("large.bcc4", cache_bytes=1 << 20)
def read():
    while True:
        v.field().read()
answered(read, 1)
print(v[1].shape == (112, 112, 112))
""",
    "evaluate": """
v = bccsplat.open("large.bcc4")
points = np.random.default_rng(1).random((1000000, 4)) * [111, 111, 111, 2]
def evaluate():
    while True:
        v.evaluate(points)
answered(evaluate, 1)
print(v[1].shape == (112, 112, 112))
""",
    "zarr": """
import zarr
from bccsplat.zarr_store import Store
group = zarr.open(Store("large.bcc4"), mode="r")
def export():
    while True:
        zarr.copy_all(group, zarr.group(zarr.MemoryStore()))
answered(export, 1)
print(True)
""",
}


class CtrlC(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        bccsplat.save(path("large.bcc4"), np.random.default_rng(1).normal(size=(3, 112, 112, 112)).astype(np.float32), lattice="cc")

    def run_python(self, text):
        done = subprocess.run([sys.executable, "-B", "-c", PROLOGUE + text], capture_output=True, text=True, cwd=support.SCRATCH,
                              timeout=120)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout.split("\n")

    def answered(self, name):
        seconds, after, *_ = self.run_python(ENDED[name])
        self.assertNotIn("ended", seconds)
        clock, processor = map(float, seconds.split())
        self.assertLess(min(clock, processor), ANSWERED, "%s: %s" % (name, seconds))
        print("Ctrl-C in %s: %g s, of the processor %g" % (name, clock, processor))
        return after

    def test_saving_leaves_no_file(self):
        self.assertEqual(self.answered("save"), "False")
        self.assertEqual(self.answered("plan"), "False")

    def test_what_was_interrupted_goes_on(self):
        for name in ("show", "reading", "evaluate"):
            self.assertEqual(self.answered(name), "True")

    @unittest.skipIf(*support.without("zarr"))
    def test_export(self):
        self.assertEqual(self.answered("zarr"), "True")

    def test_others_hear_of_it_too(self):
        """What had asked for signals still gets them, and a handler that is not Python's own is left alone."""
        lines = self.run_python("""
import socket
a, b = socket.socketpair()
b.setblocking(False)
signal.set_wakeup_fd(b.fileno())
x = noise(4, 112)
answered(lambda: bccsplat.save("noise.bcc4", x, abs_error=.01))
a.settimeout(5)
print(a.recv(8)[0] == signal.SIGINT, signal.set_wakeup_fd(-1) == b.fileno())
heard = []
signal.signal(signal.SIGINT, lambda *_: heard.append(1))
later(.2)
bccsplat.save("small.bcc4", x[:, :96, :96, :96], abs_error=.05)
print(heard, bccsplat.open("small.bcc4").shape)
""")
        self.assertEqual(lines[1:3], ["True True", "[1] (4, 96, 96, 96)"])

    def test_nothing_is_printed_at_the_end(self):
        lines = self.run_python("""
v = bccsplat.open("large.bcc4")
f, cut, r = v.field(), v.slice(time=1), bccsplat.Renderer(bccsplat.default_device())
r.set_slice(cut)
def deep():
    v[1]
    raise KeyboardInterrupt
try:
    deep()
except KeyboardInterrupt as kept:
    held = kept
threading.Thread(target=lambda: [v.field().read() for _ in range(100)], daemon=True).start()
time.sleep(.2)
print("end")
""")
        self.assertEqual(lines[0], "end")


if __name__ == "__main__":
    support.fresh_scratch()
    support.main()
