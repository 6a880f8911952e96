"""The moments that scenes look at, each a file of a folder, of which the oldest go when they are too many."""
import hashlib
import os
import time

from .series import open_series

SUFFIX = ".bcc4.vdb"  # of the files that are moments, among others in a folder
_series = {}  # of files as they are, by path, size and time of change


def series_of(path, package, tool):
    """The open series of a file; opened anew where the file has changed."""
    try:
        found = os.stat(path)
        key = found.st_size, found.st_mtime_ns, package, tool
    except OSError:
        key = None  # opening it tells why
    if path not in _series or _series[path][0] != key:
        _series.pop(path, None)
        _series[path] = key, open_series(path, package, tool)
    return _series[path]


def forget():
    """Closes all series."""
    _series.clear()


def file_of(folder, key, series, frame, wanted, shown, most_bytes):
    """The path of a moment as an OpenVDB file, which is written unless it is there. Blender keeps what it has read by the
    path, so that another moment, and another file, have other names. wanted: channels, level and threshold; shown: files
    that stay."""
    given = wanted.channels, wanted.level, wanted.threshold
    told = repr((series.path, series.way, key, round(frame, 6), *given))
    name = "%s.%s%s" % (os.path.splitext(os.path.basename(series.path))[0], hashlib.sha256(told.encode()).hexdigest()[:20], SUFFIX)
    path = os.path.join(folder, name)
    if os.path.exists(path):
        os.utime(path, ns=(time.time_ns(), os.stat(path).st_mtime_ns))  # it was looked at, and has not changed
        return path
    os.makedirs(folder, exist_ok=True)
    series.write(path, round(frame, 6), *given)
    thin(folder, {*shown, path}, most_bytes)
    return path


def thin(folder, kept, most_bytes):
    """Removes the moments of a folder that were looked at longest ago, but for those that are kept, until the others are of
    no more bytes."""
    files = [entry for entry in os.scandir(folder) if entry.name.endswith(SUFFIX) and entry.path not in kept]
    files.sort(key=lambda entry: -entry.stat().st_atime_ns)
    total = 0
    for entry in files:
        total += entry.stat().st_size
        if total > most_bytes:
            os.remove(entry.path)
