"""python_view_test.py TOP EXAMPLES SCRATCH: Volume.view serves the viewer and the bytes of a volume to this machine alone, and
`bcc4 view` of the package does. The viewer itself is tested in tests/web: here a page stands for it."""
import http.client
import os
import signal
import subprocess
import sys
import threading
import unittest
import urllib.error
import urllib.request

import python_support as support
from python_support import path, waves

support.need("numpy")

import bccsplat  # noqa: E402
from bccsplat.viewing import range_of  # noqa: E402


def asked(viewing, name, headers={}, method="GET"):
    """Status, headers and bytes of an answer."""
    connection = http.client.HTTPConnection(viewing.url.split("/")[2], timeout=20)
    connection.request(method, "/" + name, headers=headers)
    answer = connection.getresponse()
    found = answer.status, {key.lower(): value for key, value in answer.getheaders()}, answer.read()
    connection.close()
    return found


class View(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        os.makedirs(path("page"))
        for name, text in (("core.wasm", "code"), ("index.html", "<p>page"), ("page.mjs", "1")):
            with open(path("page/" + name), "w", encoding="utf-8") as file:
                file.write(text)
        bccsplat.save(path("v.bcc4"), waves(3, 20, 20, 20))
        with open(path("v.bcc4"), "rb") as file:
            cls.bytes = file.read()
        cls.volume = bccsplat.open(path("v.bcc4"))

    def test_the_page_and_ranges_of_the_file(self):
        with self.volume.view(page=path("page")) as viewing:
            self.assertRegex(viewing.url, r"^http://127\.0\.0\.1:\d+/\?url=file\.bcc4$")
            self.assertIn(viewing.url, viewing._repr_html_())
            self.assertEqual(asked(viewing, "?url=file.bcc4")[2], b"<p>page")
            self.assertEqual(asked(viewing, "core.wasm")[1]["content-type"], "application/wasm")
            self.assertIn("javascript", asked(viewing, "page.mjs")[1]["content-type"])
            status, headers, found = asked(viewing, "file.bcc4")
            self.assertEqual((status, found, "content-range" in headers), (200, self.bytes, False))
            status, headers, found = asked(viewing, "file.bcc4", {"Range": "bytes=10-19"})
            self.assertEqual((status, found, headers["content-range"]), (206, self.bytes[10:20], "bytes 10-19/%d" % len(self.bytes)))
            self.assertEqual(asked(viewing, "file.bcc4", {"Range": "bytes=-7"})[2], self.bytes[-7:])
            status, headers, found = asked(viewing, "file.bcc4", {"Range": "bytes=%d-" % len(self.bytes)})
            self.assertEqual((status, headers["content-range"], found), (416, "bytes */%d" % len(self.bytes), b""))
            self.assertEqual(asked(viewing, "file.bcc4", method="HEAD")[1]["content-length"], str(len(self.bytes)))
            self.assertEqual(asked(viewing, "file.bcc4", {"Range": "bytes=1-2", "If-Range": '"x"'})[0], 200)
        with self.assertRaises(OSError):
            asked(viewing, "file.bcc4")

    def test_nothing_else_is_served(self):
        with open(path("secret"), "w", encoding="utf-8") as file:
            file.write("secret")
        with self.volume.view(page=path("page")) as viewing:
            for name in ("../secret", "%2e%2e/secret", "/etc/passwd", ".hidden", "none.js", "..%2fsecret"):
                self.assertEqual(asked(viewing, name)[0], 404, name)
            self.assertEqual(asked(viewing, "file.bcc4", {"Host": "evil.example:80"})[0], 403)
            self.assertEqual(asked(viewing, "file.bcc4", method="POST")[0], 501)

    def test_bytes_open_files_and_streams(self):
        def read_at(offset, buffer):
            found = self.bytes[offset:offset + len(buffer)]
            buffer[:len(found)] = found
            return len(found)

        with open(path("v.bcc4"), "rb") as file:
            for source in self.bytes, file, (len(self.bytes), read_at):
                with bccsplat.open(source).view(page=path("page")) as viewing:
                    self.assertEqual(asked(viewing, "file.bcc4")[2], self.bytes)
                    self.assertEqual(asked(viewing, "file.bcc4", {"Range": "bytes=5-5"})[2], self.bytes[5:6])

    def test_ranges(self):
        for header, found in (("bytes=0-", (0, 10)), ("bytes=3-4", (3, 5)), ("bytes=3-99", (3, 10)), ("bytes=-4", (6, 10)),
                              ("bytes=-99", (0, 10)), ("bytes=12-", (12, 10)), ("bytes=4-3", None), ("bytes=1-2,4-5", None),
                              ("bytes=-", None), ("", None), ("pages=1-2", None)):
            self.assertEqual(range_of(header, 10), found, header)

    def test_without_a_viewer_it_says_how_to_make_one(self):
        with self.assertRaisesRegex(FileNotFoundError, "no core.wasm.*build.sh"):
            self.volume.view(page=support.SCRATCH)
        os.environ["BCCSPLAT_WEB"] = path("page")
        try:
            self.volume.view().close()
        finally:
            del os.environ["BCCSPLAT_WEB"]

    def test_nothing_stays(self):
        before = threading.active_count()
        for _ in range(5):
            viewing = self.volume.view(page=path("page"))
            viewing.close()
            viewing.close()
        self.assertEqual(threading.active_count(), before)

    def test_by_the_command(self):
        def run(*arguments):
            code = "import sys; sys.argv = ['bcc4', *sys.argv[1:]]; from bccsplat.tool import main; main()"
            return subprocess.Popen([sys.executable, "-B", "-c", code, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                    text=True, env={**os.environ, "BCCSPLAT_WEB": path("page")})

        with run("view", path("v.bcc4")) as running:
            link = running.stdout.readline().strip()
            with urllib.request.urlopen(link.replace("?url=", "")) as answer:
                self.assertEqual(answer.read(), self.bytes)
            running.send_signal(signal.SIGINT)
            self.assertEqual((running.wait(20), "Ctrl-C ends" in running.stderr.read()), (0, True))
        for arguments, text in (((path("none.bcc4"),), "none.bcc4"), ((path("v.bcc4"), "--page", support.SCRATCH), "no core.wasm"),
                                ((path("v.bcc4"), "--port", "99999"), "port")):
            with run("view", *arguments) as running:
                self.assertNotEqual(running.wait(60), 0)
                said = running.stderr.read()
                self.assertIn(text, said)
                self.assertNotIn("Traceback", said)


if __name__ == "__main__":
    support.fresh_scratch()
    support.main()
