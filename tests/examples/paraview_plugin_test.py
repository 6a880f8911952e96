"""paraview_plugin_test.py TOP EXAMPLES SCRATCH: in plain VTK the reader's image has the file's geometry, times and values, on
frames and between, a region of it, labels as integers, and goes through a VTK pipeline; it tells how far it is, and can be
stopped. paraview_pipeline_test.py has the same in ParaView. Exits with 77 without VTK."""
import os
import sys

try:
    import numpy as np
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkOutputWindow
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline as pipeline
    from vtkmodules.vtkFiltersCore import vtkContourFilter
except ImportError as error:
    print("skipped:", error)
    sys.exit(77)
from bccsplat import Channel, Device, Volume, Writer

top, _examples, scratch = sys.argv[1:]
sys.path.insert(0, os.path.join(top, "examples"))
from paraview_plugin import Bcc4Reader  # noqa: E402

os.makedirs(scratch, exist_ok=True)
path = os.path.join(scratch, "two_channels.bcc4")
z, y, x = np.mgrid[0:12, 0:14, 0:16].astype(np.float32)
times = [0.0, 0.5, 1.5, 2.0, 4.0]
turned = np.array([[0, -2.0, 0, 10], [1.5, 0, 0, 20], [0, 0, 3, 30], [0, 0, 0, 1]])  # x of the index runs along world y
oblique = np.array([[1.2, -1.2, 0, 10], [.9, 1.6, 0, 20], [0, 0, 3, 30], [0, 0, 0, 1.0]])


def in_file(values):
    """An image's values in the order of the turned file: x of the image runs against its y, y along its x."""
    return values[..., ::-1].transpose(0, 2, 1)


def write(device, affine):
    with Writer(device, path, (16, 14, 12, len(times)), overwrite=True, affine=affine, time_unit="s",
                channels=[Channel("density"), Channel("heat", air=20)]) as writer:
        for i, time in enumerate(times):
            blob = np.exp(-((x - 6 - i) ** 2 + (y - 7) ** 2 + (z - 6) ** 2) / 12)
            writer.add_frame(blob, time)
            writer.add_frame(20 + 5 * blob, time, channel=1)


with Device() as device:
    write(device, turned)
    volume = Volume(device, path)

    reader = Bcc4Reader()
    reader.SetFileName(path)
    reader.UpdateInformation()
    information = reader.GetOutputInformation(0)
    assert list(information.Get(pipeline.TIME_STEPS())) == times == reader.GetTimestepValues()
    assert list(information.Get(pipeline.WHOLE_EXTENT())) == [0, 13, 0, 15, 0, 11]
    for time in (0.0, 1.5, 1.0, 3.3, 4.0):
        image = reader.UpdateTimeStep(time)
        assert image.GetDimensions() == (14, 16, 12) and image.GetSpacing() == (2, 1.5, 3)
        for name, channel in (("density", 0), ("heat", 1)):
            values = in_file(vtk_to_numpy(image.GetPointData().GetArray(name)).reshape(12, 16, 14))
            expected = volume.slice(time=time, channel=channel).sample_grid()
            assert np.array_equal(values, expected), (time, name)
            assert values.max() > 0.5
        at = [0.0, 0.0, 0.0]
        image.TransformIndexToPhysicalPoint([13 - 4, 3, 5], at)
        assert np.allclose(at, (turned @ [3, 4, 5, 1])[:3]), at
    before = vtk_to_numpy(reader.UpdateTimeStep(0.0).GetPointData().GetScalars()).copy()
    assert np.abs(vtk_to_numpy(reader.UpdateTimeStep(4.0).GetPointData().GetScalars()) - before).max() > 0.3

    # The unit of the times, where the file tells one.
    assert reader.GetTimeUnit() == "s" and reader.GetTimeLabel() == "Time (s)"
    assert image.GetFieldData().GetAbstractArray("time_unit").GetValue(0) == "s"

    # A region has the values of the whole, at their places, and no others.
    whole = [vtk_to_numpy(reader.UpdateTimeStep(1.0).GetPointData().GetArray(i)).reshape(12, 16, 14).copy() for i in (0, 1)]
    box = [2, 9, 3, 3, 1, 11]
    reader = Bcc4Reader()
    reader.SetFileName(path)
    reader.UpdateInformation()
    reader.GetOutputInformation(0).Set(pipeline.UPDATE_TIME_STEP(), 1.0)
    reader.UpdateExtent(box)
    image = reader.GetOutputDataObject(0)
    assert list(image.GetExtent()) == box, image.GetExtent()
    for i in (0, 1):
        values = vtk_to_numpy(image.GetPointData().GetArray(i)).reshape(11, 1, 8)
        assert np.abs(values - whole[i][1:12, 3:4, 2:10]).max() < 1e-5

    # It tells how far it is, and stops where it is told to; who asks again gets all.
    told = []
    reader = Bcc4Reader()
    reader.SetFileName(path)
    watch = reader.AddObserver("ProgressEvent", lambda *_: told.append(reader.GetProgress()))
    reader.UpdateTimeStep(0.5)
    assert len(told) > 4 and told == sorted(told) and told[-1] == 1, told
    reader.RemoveObserver(watch)
    watch = reader.AddObserver("ProgressEvent", lambda *_: reader.SetAbortExecute(reader.GetProgress() > .3))
    assert reader.UpdateTimeStep(2.0).GetPointData().GetNumberOfArrays() == 0
    reader.RemoveObserver(watch)
    reader.SetAbortExecute(0)
    image = reader.UpdateTimeStep(2.0)
    assert np.array_equal(in_file(vtk_to_numpy(image.GetPointData().GetArray("heat")).reshape(12, 16, 14)),
                          volume.slice(time=2.0, channel=1).sample_grid())

    # Labels stay labels between frames: integers, those of the nearest one.
    labels_path = os.path.join(scratch, "labels.bcc4")
    labels = np.where(np.add.outer(np.arange(4), np.arange(16)) < 9, 3, 40)[:, None, None, :] * np.ones((12, 14, 1), int)
    with Writer(device, labels_path, (16, 14, 12, 4), overwrite=True, lattice="cc",
                channels=[Channel("organ", labels=True)]) as writer:
        for i, frame in enumerate(labels):
            writer.add_frame(frame.astype(np.float32), i)
    reader = Bcc4Reader()
    reader.SetFileName(labels_path)
    for time, frame in ((0, 0), (.5, 1), (1.3, 1), (1.7, 2), (2.5, 3), (3, 3)):
        values = vtk_to_numpy(reader.UpdateTimeStep(time).GetPointData().GetArray("organ"))
        assert values.dtype.kind == "i" and np.array_equal(values.reshape(12, 14, 16), labels[frame]), time

    # Around an axis that goes round each sample is there once.
    round_path = os.path.join(scratch, "round.bcc4")
    with Writer(device, round_path, (16, 14, 12, len(times)), overwrite=True, lattice="cc", periodic_axes=1,
                channels=[Channel("column")]) as writer:
        for time in times:
            writer.add_frame(np.sin(x * np.pi / 8) + y, time)
    reader = Bcc4Reader()
    reader.SetFileName(round_path)
    values = vtk_to_numpy(reader.UpdateTimeStep(0.5).GetPointData().GetArray("column")).reshape(12, 14, 16)
    assert np.abs(values - np.sin(x * np.pi / 8) - y).max() < 0.01

    # A surface stands where the file's world has it, which filters do not know of directions alone.
    contour = vtkContourFilter()
    reader = Bcc4Reader()
    reader.SetFileName(path)
    contour.SetInputConnection(reader.GetOutputPort())
    contour.SetValue(0, 0.5)
    contour.UpdateTimeStep(2.0)
    surface = contour.GetOutput()
    assert surface.GetNumberOfPoints() > 50
    # The level set of the blob at frame 3 (time 2) is a sphere of radius sqrt(12 ln 2) voxels about (9, 7, 6).
    points = vtk_to_numpy(surface.GetPoints().GetData())
    index = (np.linalg.inv(turned) @ np.c_[points, np.ones(len(points))].T).T[:, :3]
    radii = np.linalg.norm(index - [9, 7, 6], axis=1)
    assert np.abs(radii - np.sqrt(12 * np.log(2))).max() < 0.1, radii

    # Oblique axes keep their directions; that filters may leave them out is said once.
    said = []
    watch = vtkOutputWindow.GetInstance().AddObserver("WarningEvent", lambda *_: said.append(1))
    write(device, oblique)
    reader = Bcc4Reader()
    reader.SetFileName(path)
    image = reader.UpdateTimeStep(2.0)
    image.TransformIndexToPhysicalPoint([3, 4, 5], at)
    assert np.allclose(at, (oblique @ [3, 4, 5, 1])[:3]), at
    assert np.array_equal(vtk_to_numpy(image.GetPointData().GetScalars()).reshape(12, 14, 16),
                          Volume(device, path).slice(time=2.0).sample_grid())

    reader.UpdateTimeStep(1.0)
    assert said == [1], said
    vtkOutputWindow.GetInstance().RemoveObserver(watch)

    # A label that is missing is no number at all; a series that goes round in time has moments behind its last frame.
    missing_path = os.path.join(scratch, "missing.bcc4")
    labels = labels.astype(np.float32)
    labels[:, 2:5, :, 7] = np.nan
    with Writer(device, missing_path, (16, 14, 12, 4), overwrite=True, lattice="cc", nonfinite="hole", ends="periodic",
                channels=[Channel("organ", labels=True)]) as writer:
        for i, frame in enumerate(labels):
            writer.add_frame(frame, i)
    reader = Bcc4Reader()
    reader.SetFileName(missing_path)
    for time, frame in ((1, 1), (3.2, 3), (3.8, 0)):
        values = vtk_to_numpy(reader.UpdateTimeStep(time).GetPointData().GetArray("organ")).reshape(12, 14, 16)
        assert np.array_equal(values, labels[frame], equal_nan=True), time
