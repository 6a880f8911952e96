"""python_notebook_test.py TOP EXAMPLES SCRATCH: the notebook of examples/python, run by nbconvert, shows pictures. Exits with 77
without nbconvert or ipykernel; without matplotlib, which is said, its plot is left out."""
import base64
import json
import os
import re
import struct
import subprocess
import sys
import unittest

import python_support as support
from python_support import path, without

support.need("numpy", "nbconvert", "ipykernel")

# Bytes of a PNG a pixel: pictures of one colour have less than a tenth of it.
SEEN = .04


def converted(source, target, form, *more):
    done = subprocess.run([sys.executable, "-m", "nbconvert", "--log-level=WARN", "--to", form, *more, "--output", target, source],
                          capture_output=True, text=True, cwd=support.SCRATCH, env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})
    assert done.returncode == 0, done.stderr
    with open(os.path.join(support.SCRATCH, target), encoding="utf-8") as file:
        return file.read()


def images(cell):
    """The PNG files that a cell shows, in whatever form it does."""
    shown = [output["data"] for output in cell["outputs"] if "data" in output]
    texts = [data["image/png"] for data in shown if "image/png" in data]
    texts += re.findall(r'src="data:image/png;base64,([^"]+)"', "".join("".join(data.get("text/html", "")) for data in shown))
    return [base64.b64decode("".join(text)) for text in texts]


class Notebook(unittest.TestCase):
    def test_it_shows_pictures(self):
        with open(os.path.join(support.PYTHON, "look.ipynb"), encoding="utf-8") as file:
            notebook = json.load(file)
        for cell in notebook["cells"]:
            self.assertFalse(cell.get("outputs"), "outputs are not committed")
        missing, reason = without("matplotlib")
        if missing:
            print("skipped: %s, the plot was left out" % reason, file=sys.stderr)
            notebook["cells"] = [cell for cell in notebook["cells"] if not cell["id"].startswith("plot")]
        with open(path("look.ipynb"), "w", encoding="utf-8") as file:
            json.dump(notebook, file)
        ran = json.loads(converted("look.ipynb", "ran.ipynb", "notebook", "--execute"))
        cells = {cell["id"]: cell for cell in ran["cells"] if cell["cell_type"] == "code"}
        self.assertEqual([output for cell in cells.values() for output in cell["outputs"] if output["output_type"] == "error"], [])
        wanted = {"volume": (256, 256), "moment": (512, 512), "oblique": (512, 512)}
        for name, size in wanted.items():
            for image in images(cells[name]):
                self.assertEqual(struct.unpack(">II", image[16:24]), size, name)
                self.assertGreater(len(image), SEEN * size[0] * size[1], name)
            self.assertTrue(images(cells[name]), name)
        told = "".join("".join(output["data"].get("text/html", "")) for output in cells["volume"]["outputs"])
        self.assertIn("40 x 40 x 40, 20 frames", told)
        self.assertNotEqual(images(cells["moment"])[0], images(cells["oblique"])[0])
        if not missing:
            self.assertGreater(len(images(cells["plot"])[0]), 10000)
        page = converted("ran.ipynb", "ran.html", "html")
        self.assertGreaterEqual(page.count("data:image/png;base64,"), len(wanted) + (not missing))


if __name__ == "__main__":
    support.fresh_scratch()
    support.main()
