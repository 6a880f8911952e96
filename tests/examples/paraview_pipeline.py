"""paraview_pipeline.py PART TOP FOLDER: what paraview_pipeline_test.py runs in pvpython, over the files that it has put into
FOLDER."""
import os
import sys

import numpy as np
from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy

PART, TOP, FOLDER = sys.argv[1:]
MOMENT = 11.3
NEAR = 45  # dB that a picture is from that of the exported file


def path(name):
    return os.path.join(FOLDER, name)


def hold(condition, what):
    print("%s: %s: %s" % (PART, "holds" if condition else "DOES NOT HOLD", what), flush=True)
    if not condition:
        sys.exit(1)


def image_of(source, time):
    source.UpdatePipeline(time)
    return servermanager.Fetch(source)


def array_of(image, name):
    """Values [z, y, x]; None: there is no such array."""
    array = image.GetPointData().GetArray(name)
    return None if array is None else vtk_to_numpy(array).reshape(image.GetDimensions()[::-1])


def hold_values(image, name, file):
    """That an image has the values of a file of the tool, but for rounding."""
    found = array_of(image, name)
    off = np.abs(found - np.fromfile(path(file), np.float32).reshape(found.shape)).max()
    hold(off < 2e-6 and np.ptp(found) > .1, "%s has the values of %s: off by %.1e of %.2f" % (name, file, off, np.ptp(found)))


def values():
    reader = simple.OpenDataFile(path("default.bcc4"))
    hold([*reader.TimestepValues] == [.5 * n for n in range(12)] and reader.TimeUnit == "",
         "a file of an import without options opens, with its times and no unit")
    image = image_of(reader, 2.2)
    simple.Delete(reader)  # of files with different units ParaView shows none
    hold(image.GetBounds() == (0, 47, 0, 47, 0, 47) and array_of(image, "value").max() > .3, "and shows a moment")

    reader = simple.OpenDataFile(path("two.bcc4"))
    hold([*reader.TimestepValues] == [10 + .5 * n for n in range(12)] and reader.TimeUnit == "s", "times have their unit")
    label = simple.GetTimeKeeper().SMProxy.GetProperty("TimeLabel").GetElement(0)
    hold(label == "Time (s)", "which stands where ParaView shows its time: " + label)
    image = image_of(reader, MOMENT)
    hold(image.GetFieldData().GetAbstractArray("time_unit").GetValue(0) == "s", "and the data")
    hold(image.GetBounds() == (1, 95, 2, 96, 3, 97), "the image stands in the file's world")
    hold(reader.PointData.keys() == ["density", "heat"], "there are two channels")
    for name in ("density", "heat"):
        hold_values(image, name, name + ".raw")
        hold(np.array_equal(array_of(image, name), np.load(path(name + ".npy"))), "%s is what the package reads" % name)
        for beside in (11, 11.5):
            off = np.abs(array_of(image_of(reader, beside), name) - array_of(image, name)).max()
            hold(off > .01, "and not that of the frame at %g: off by %.2f" % (beside, off))

    reader = simple.OpenDataFile(path("two.bcc4"))
    box = [12, 29, 20, 20, 5, 40]
    region = image_of(simple.ExtractSubset(reader, VOI=box), MOMENT)
    hold([*region.GetExtent()] == box == [*reader.GetClientSideObject().GetOutputDataObject(0).GetExtent()],
         "of a region no more is made")
    hold(region.GetBounds() == (25, 59, 42, 42, 13, 83), "which stands in its place")
    hold_values(region, "heat", "region.raw")


def kinds():
    """Labels, missing data, and axes that are turned in the world."""
    reader = simple.OpenDataFile(path("labels.bcc4"))
    for time, frame in ((0, 0), (.5, 1), (1.3, 1), (1.7, 2), (2.5, 3)):
        found = array_of(image_of(reader, time), "value")
        hold(found.dtype.kind == "i" and [*found[3, 5]] == [frame] * 8 + [frame + 1] * 8,
             "labels at %g are integers of frame %d" % (time, frame))
    found = array_of(image_of(simple.OpenDataFile(path("missing.bcc4")), .5), "value")
    gone = np.zeros(found.shape, bool)
    gone[1:4, :, 12:] = True
    hold(np.array_equal(np.isnan(found), gone), "missing samples are NaN, and no others")
    turned = simple.OpenDataFile(path("turned.bcc4"))
    hold(image_of(turned, 0).GetBounds() == (-16, 10, 20, 42.5, 30, 63), "turned axes reach as far as the file says")
    surface = image_of(simple.Contour(turned, ContourBy=["POINTS", "blob"], Isosurfaces=[.5]), 0)
    centre = surface.GetCenter()
    hold(np.allclose(centre, (-4, 29, 48), atol=.1), "their surfaces stand in the world: about %.2f, %.2f, %.2f" % centre)


def stopped():
    """Progress and cancel, as ParaView's own handler sees them."""
    reader = simple.OpenDataFile(path("two.bcc4"))
    handler, made = servermanager.ActiveConnection.Session.GetProgressHandler(), reader.GetClientSideObject()
    handler.SetProgressInterval(0)
    told, passed_on = [], []
    watches = [(handler, handler.AddObserver("ProgressEvent", lambda *_: passed_on.append(handler.GetLastProgress()))),
               (made, made.AddObserver("ProgressEvent", lambda *_: told.append(made.GetProgress())))]
    reader.UpdatePipeline(MOMENT)
    for watched, watch in watches:
        watched.RemoveObserver(watch)
    hold(told == sorted(told) and len({*told}) > 8, "progress is told: %d steps" % len({*told}))
    hold(passed_on == sorted(passed_on) and any(0 < percent < 100 for percent in passed_on),
         "and passed on as often as ParaView's handler likes: %s" % passed_on)
    reached = []

    def stop(*_):
        reached.append(made.GetProgress())
        made.SetAbortExecute(made.GetProgress() > .3)

    watch = made.AddObserver("ProgressEvent", stop)
    image = image_of(reader, 12.2)
    made.RemoveObserver(watch)
    last = max(part for part in reached if part < 1)  # the pipeline says 1 at the end of what was stopped as well
    hold(image.GetPointData().GetNumberOfArrays() == 0 and .3 < last < .6, "what is stopped ends at %.2f, without values" % last)
    made.SetAbortExecute(0)
    image = image_of(reader, 12.2)
    hold(array_of(image, "heat") is not None and array_of(image, "heat").max() > .3, "who asks again gets all")


def picture_of(source, name, time=MOMENT):
    """Pixels of a moment of smoke, off-screen, from a side that tells left from right."""
    view = simple.CreateView("RenderView")
    view.ViewSize, view.OrientationAxesVisibility, view.UseColorPaletteForBackground = [320, 320], 0, 0
    view.Background, view.ViewTime = [0, 0, 0], time
    shown = simple.Show(source, view)
    shown.SetRepresentationType("Volume")
    simple.ColorBy(shown, ("POINTS", "density"))
    simple.GetColorTransferFunction("density").RescaleTransferFunction(0, 1)
    simple.GetOpacityTransferFunction("density").Points = [0, 0, .5, 0, .05, 0, .5, 0, 1, .9, .5, 0]
    shown.SetScalarBarVisibility(view, False)
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [190, 120, 190], [48, 45, 50], [0, 1, 0]
    simple.SaveScreenshot(path(name), view)
    simple.Delete(view)
    from vtkmodules.vtkIOImage import vtkPNGReader
    png = vtkPNGReader()
    png.SetFileName(path(name))
    png.Update()
    return vtk_to_numpy(png.GetOutput().GetPointData().GetScalars()) / 255


def decibels(a, b):
    return float(-10 * np.log10(max(np.mean((a - b) ** 2), 1e-12)))


def picture():
    found = picture_of(simple.OpenDataFile(path("two.bcc4")), "plugin.png")
    exported = simple.OpenDataFile(path("density.vti"))
    exported.UpdatePipeline()
    name = exported.PointData.keys()[0]
    if name != "density":
        exported = simple.Calculator(exported, Function='"%s"' % name, ResultArrayName="density")
    there = decibels(found, picture_of(exported, "exported.png"))
    hold(np.ptp(found) > .5 and (found.max(axis=1) > .1).mean() > .02, "smoke is seen")
    hold(there > NEAR, "the picture is %.1f dB from that of the exported moment" % there)
    beside = decibels(found, picture_of(simple.OpenDataFile(path("two.bcc4")), "frame.png", 11))
    hold(beside < NEAR, "and %.1f dB from that of the frame before it" % beside)


def oblique():
    reader = simple.OpenDataFile(path("oblique.bcc4"))
    at = [0.0, 0.0, 0.0]
    image_of(reader, 0).TransformIndexToPhysicalPoint([6, 7, 6], at)
    hold(np.allclose(at, (.6, 9.2, 6)), "oblique axes keep their directions: %s" % at)


def refused():
    reader = simple.OpenDataFile(path("none.bcc4"))
    reader.UpdatePipeline()
    hold(reader.PointData.keys() == [], "a file that is none shows nothing")


simple.LoadPlugin(os.path.join(TOP, "examples", "paraview_plugin.py"), ns=globals())
{"values": values, "kinds": kinds, "stopped": stopped, "picture": picture, "oblique": oblique, "refused": refused}[PART]()
print("DONE", PART, flush=True)
