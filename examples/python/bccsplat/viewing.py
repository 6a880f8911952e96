"""Viewing: the viewer for browsers and a volume, served on this machine alone: Volume.view, and `bcc4 view` of a wheel."""
from __future__ import annotations

import http.server
import os
import re
import threading
from typing import Any, Callable, Union

from .sources import OpenFile, RemoteFile

_TYPES = {".html": "text/html; charset=utf-8", ".css": "text/css; charset=utf-8", ".js": "text/javascript; charset=utf-8",
          ".mjs": "text/javascript; charset=utf-8", ".wasm": "application/wasm"}
_SERVED_AS = "file.bcc4"
# Bytes that are held of an answer.
_PIECE = 1 << 20

# offset, size -> bytes
Read = Callable[[int, int], bytes]


def find_page(folder: Union[str, "os.PathLike[str]", None] = None) -> str:
    """The folder of the viewer: as given, BCCSPLAT_WEB, inside the package as a wheel has it, or installed beside the library.
    FileNotFoundError where there is none."""
    from ._library import native
    here, library = os.path.dirname(os.path.abspath(__file__)), os.path.dirname(os.path.abspath(native._name))
    named = folder or os.environ.get("BCCSPLAT_WEB")
    beside = [os.path.join(library, up, "share", "bccsplat", "web") for up in ("..", os.path.join("..", ".."))]
    for place in [named] if named else [os.path.join(here, "web"), *beside]:
        if os.path.exists(os.path.join(place, "core.wasm")):
            return os.path.abspath(place)
    raise FileNotFoundError("%s: examples/web/build.sh FOLDER makes one, which page=FOLDER or BCCSPLAT_WEB=FOLDER shows" %
                            ("%s: no viewer is there (no core.wasm)" % os.fspath(named) if named else
                             "no viewer is installed with this package"))


def reader_of(source: Any) -> tuple[Callable[[], int], Read]:
    """The size, as it is now, and ranges of what a volume was opened from."""
    if isinstance(source, (str, os.PathLike)):
        path = os.path.abspath(os.fspath(source))

        def read_file(offset: int, size: int) -> bytes:
            with open(path, "rb") as file:
                file.seek(offset)
                return file.read(size)

        return lambda: os.path.getsize(path), read_file
    if not isinstance(source, (tuple, RemoteFile, OpenFile)):
        held = memoryview(source).cast("B")
        count = held.nbytes
        return lambda: count, lambda offset, size: bytes(held[offset:offset + size])
    stream: Any = source if isinstance(source, tuple) else source.stream()
    total, read_at = int(stream[0]), stream[1]

    def read_stream(offset: int, size: int) -> bytes:
        buffer = bytearray(min(size, total - offset))
        done = read_at(offset, memoryview(buffer))
        if done is None:
            raise OSError("bytes of the stream are not there yet")
        return bytes(buffer[:done])

    return lambda: total, read_stream


def range_of(header: str, size: int) -> tuple[int, int] | None:
    """First byte and the one behind the last of "bytes=A-B"; None: all of it, which several ranges mean, too."""
    told = re.fullmatch(r"bytes=(\d*)-(\d*)", header.strip(), re.I)
    if told is None or not (told[1] or told[2]) or (told[1] and told[2] and int(told[2]) < int(told[1])):
        return None
    if not told[1]:
        return max(0, size - int(told[2])), size
    return int(told[1]), min(int(told[2]) + 1, size) if told[2] else size


class _Answers(http.server.BaseHTTPRequestHandler):
    """Files of the page by their names, and ranges of the volume."""

    protocol_version = "HTTP/1.1"
    timeout = 30
    page: str
    source: tuple[Callable[[], int], Read]

    def do_GET(self) -> None:
        port: int = self.connection.getsockname()[1]
        # Pages of other sites whose own name was led to this machine (DNS rebinding) send that name.
        if self.headers.get("Host", "").lower() not in ("127.0.0.1:%d" % port, "localhost:%d" % port):
            return self.send_error(403, "Only as 127.0.0.1 or localhost, with the port")
        name = self.path.split("?")[0][1:] or "index.html"
        path = os.path.join(self.page, name)
        if name != _SERVED_AS and (any(c in name for c in "/\\:%") or name.startswith(".") or not os.path.isfile(path)):
            return self.send_error(404, "No such file")
        length, read = self.source if name == _SERVED_AS else reader_of(path)
        size = length()
        part = range_of(self.headers.get("Range", ""), size) if self.command == "GET" and "If-Range" not in self.headers else None
        begin, end = part or (0, size)
        if part and begin >= end:
            self.send_response(416)
            self.send_header("Content-Range", "bytes */%d" % size)
            end = begin
        else:
            self.send_response(206 if part else 200)
            if part:
                self.send_header("Content-Range", "bytes %d-%d/%d" % (begin, end - 1, size))
        self.send_header("Content-Type", _TYPES.get(os.path.splitext(name)[1], "application/octet-stream"))
        self.send_header("Accept-Ranges", "bytes")
        self.send_header("Cache-Control", "no-cache")
        self.send_header("Content-Length", str(end - begin))
        self.end_headers()
        while begin < end and self.command == "GET":
            piece = read(begin, min(_PIECE, end - begin))
            if not piece:
                self.close_connection = True  # fewer bytes than were told
                break
            self.wfile.write(piece)
            begin += len(piece)

    do_HEAD = do_GET

    def log_message(self, format: str, *arguments: Any) -> None:
        """Nothing is printed."""


class _Server(http.server.ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Of who has gone in the middle nobody is told."""


class Viewing:
    """The viewer and a volume at `url`, on this machine alone, until it is closed or the process ends. A notebook of this machine
    shows it; open() opens a browser."""

    def __init__(self, source: Any, page: Union[str, "os.PathLike[str]", None] = None, port: int = 0) -> None:
        answers = type("Answers", (_Answers,), {"page": find_page(page), "source": reader_of(source)})
        self._server = _Server(("127.0.0.1", port), answers)
        self._thread = threading.Thread(target=self._server.serve_forever, name="bccsplat-view", daemon=True)
        self._thread.start()

    @property
    def url(self) -> str:
        """The link that a browser opens."""
        return "http://127.0.0.1:%s/?url=%s" % (self._server.server_address[1], _SERVED_AS)

    def open(self) -> bool:
        """Opens it in the browser of this machine; whether one was found."""
        import webbrowser
        return webbrowser.open(self.url)

    def close(self) -> None:
        """Ends it."""
        if self._thread.is_alive():
            self._server.shutdown()
            self._thread.join()
        self._server.server_close()

    def wait(self) -> None:
        """Until Ctrl-C."""
        try:
            while self._thread.is_alive():
                self._thread.join(1)
        except KeyboardInterrupt:
            self.close()

    def __enter__(self) -> Viewing:
        return self

    def __exit__(self, *_exception: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return "<bccsplat.Viewing %s>" % self.url

    def _repr_html_(self) -> str:
        return '<iframe src="%s" width="100%%" height="600" style="border:0"></iframe>' % self.url
