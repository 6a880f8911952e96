"""A reader of .bcc4 for ParaView and VTK: a time-varying vtkImageData, at any time and not only on frames.

ParaView: Tools > Manage Plugins > Load New, this file; the Python package bccsplat must be in PYTHONPATH.
          Debian 12's ParaView 5.11 loads no plugin in Python: it asks for what Python 3.11 no longer has. It does with a
          file usercustomize.py in a folder of PYTHONPATH that says
              import inspect
              inspect.getargspec = inspect.getfullargspec
VTK:      reader = Bcc4Reader(); reader.SetFileName("smoke.bcc4"); reader.UpdateTimeStep(0.5)
"""
import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringArray
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm, vtkStreamingDemandDrivenPipeline

import bccsplat

try:
    from paraview.util.vtkAlgorithm import smdomain, smhint, smproperty, smproxy
except ImportError:  # plain VTK has no use for them

    class _Ignored:
        def __getattr__(self, _name):
            return lambda *_arguments, **_named: lambda decorated: decorated

    smdomain = smhint = smproperty = smproxy = _Ignored()

_PIPELINE = vtkStreamingDemandDrivenPipeline
_PLANES = 8  # that are sampled before somebody hears how far it is, and may stop it


class _Placement:
    """Where an image's voxels are in a file and in the world. Axes that run along those of the world, either way, are put in
    their order, for filters that know an origin and distances alone. Others keep their directions.

    axes: the file's axis along each of the image; backwards: which of them run against it; upright: whether all is in order."""

    def __init__(self, dims, affine):
        columns = affine[:3, :3]
        lengths = np.linalg.norm(columns, axis=0)
        directions = columns / lengths
        order = np.rint(directions)
        self.upright = bool(np.abs(directions - order).max() < 1e-5)
        self.axes = [int(np.abs(row).argmax()) for row in order] if self.upright else [0, 1, 2]
        self.backwards = [self.upright and order[n, axis] < 0 for n, axis in enumerate(self.axes)]
        self.spacing = lengths[self.axes]
        self.directions = np.eye(3) if self.upright else directions
        self.dims = [dims[axis] for axis in self.axes]
        first = np.zeros(3)
        for axis, backward in zip(self.axes, self.backwards):
            first[axis] = dims[axis] - 1 if backward else 0
        self.origin = columns @ first + affine[:3, 3]

    def place(self, image):
        image.SetOrigin(self.origin)
        image.SetSpacing(self.spacing)
        image.SetDirectionMatrix(self.directions.ravel().tolist())

    def in_file(self, extent):
        """The first and last samples, x, y, z of the file, of an extent of the image."""
        first, last = [0, 0, 0], [0, 0, 0]
        for n, (axis, backward) in enumerate(zip(self.axes, self.backwards)):
            ends = extent[2 * n], extent[2 * n + 1]
            first[axis], last[axis] = (self.dims[n] - 1 - end for end in ends[::-1]) if backward else ends
        return first, last

    def in_image(self, values):
        """Values [z, y, x] of the file in the order of the image."""
        turned = values.transpose([2 - self.axes[n] for n in (2, 1, 0)])
        return turned[tuple(slice(None, None, -1 if self.backwards[n] else 1) for n in (2, 1, 0))]


@smproxy.reader(name="Bcc4Reader", label="bccsplat volume", extensions="bcc4", file_description="bccsplat volumes")
class Bcc4Reader(VTKPythonAlgorithmBase):
    """One array per channel, at the source's resolution, in the world space of the file: axes along those of the world stand
    in their order, whichever way the file has them. Along axes whose samples are unevenly spaced voxels are even, as many as
    there are samples. Labels are integers, of the nearest frame. Missing samples are NaN: Contour draws a wall around them
    unless Threshold takes them away first. A filter that takes a region, such as Extract Subset, has no more than that made."""

    def __init__(self):
        super().__init__(nInputPorts=0, nOutputPorts=1, outputType="vtkImageData")
        self._name, self._kernel, self._volume = "", "", None

    @smproperty.stringvector(name="FileName", panel_visibility="never")
    @smdomain.filelist()
    @smhint.filechooser(extensions="bcc4", file_description="bccsplat volumes")
    def SetFileName(self, name):
        if name != self._name:
            self._name, self._volume = name, None
            self.Modified()

    @smproperty.stringvector(name="Kernel", default_values="")
    def SetKernel(self, kernel):
        """Reconstruction by name, such as "fast"; empty: what the file recommends."""
        if kernel != self._kernel:
            self._kernel, self._volume = kernel, None
            self.Modified()

    @smproperty.doublevector(name="TimestepValues", information_only="1", si_class="vtkSITimeStepsProperty")
    def GetTimestepValues(self):
        return self._told(lambda volume: volume.times().tolist(), None)

    @smproperty.stringvector(name="TimeUnit", information_only="1", panel_visibility="default")
    def GetTimeUnit(self):
        """Of the times, as the file tells it; "": not told."""
        return self._told(lambda volume: volume.info().time_unit or "", "")

    @smproperty.stringvector(name="TimeLabelAnnotation", information_only="1")
    def GetTimeLabel(self):
        """What ParaView's time is called, with its unit."""
        unit = self.GetTimeUnit()
        return "Time (%s)" % unit if unit else "Time"

    def UpdateTimeStep(self, time):
        """For VTK without ParaView."""
        self.UpdateInformation()
        self.GetOutputInformation(0).Set(_PIPELINE.UPDATE_TIME_STEP(), time)
        self.Update()
        return self.GetOutputDataObject(0)

    def _open(self):
        if self._volume is None:
            self._volume = bccsplat.Volume(bccsplat.Device(), self._name, self._kernel or None)
            if not self._placement().upright:
                vtkOutputWindow.GetInstance().DisplayWarningText(
                    "%s: its axes are oblique in the world; filters that know no directions, such as Contour of ParaView 5.11, "
                    "leave that out\n" % self._name)
        return self._volume

    def _told(self, question, otherwise):
        """What the file says; of one that does not open RequestInformation tells why."""
        try:
            return question(self._open()) if self._name else otherwise
        except bccsplat.Error:
            return otherwise

    def _placement(self):
        info = self._open().info()
        return _Placement(info.dims[:3], np.array(info.affine[:]).reshape(4, 4))

    def RequestInformation(self, _request, _inputs, outputs):
        placement, info = self._placement(), self._open().info()
        out, times = outputs.GetInformationObject(0), self._open().times()
        out.Set(_PIPELINE.WHOLE_EXTENT(), [end for n in placement.dims for end in (0, n - 1)], 6)
        out.Set(vtkImageData.ORIGIN(), placement.origin.tolist(), 3)
        out.Set(vtkImageData.SPACING(), placement.spacing.tolist(), 3)
        out.Set(vtkImageData.DIRECTION(), placement.directions.ravel().tolist(), 9)
        out.Set(_PIPELINE.TIME_STEPS(), times.tolist(), len(times))
        out.Set(_PIPELINE.TIME_RANGE(), [info.time_first, info.time_end], 2)
        out.Set(vtkAlgorithm.CAN_PRODUCE_SUB_EXTENT(), 1)
        return 1

    def _tell(self, fraction):
        """Whether to stop."""
        self.UpdateProgress(fraction)
        return bool(self.GetAbortExecute())

    def _values(self, channel, time, first, last, tell):
        """Of a channel in a box of the file's samples, both ends included, [z, y, x]. tell: gets the fraction that is there,
        and may stop it."""
        volume = self._open()
        # A box counts samples, which are not where even voxels are.
        even = all(len(volume.axis(axis)[0]) == 0 for axis in range(3))
        cut = volume.slice(time=time, channel=channel, space="even", box=(first, last) if even else None,
                           progress=lambda made: tell(made / 2))
        width, height, depth = (end - begin + 1 for begin, end in zip(first, last))
        values = np.empty((depth, height, width), np.float32)
        for z in range(0, depth, _PLANES):
            part = values[z:z + _PLANES]
            cut.sample_grid(origin=(first[0], first[1], first[2] + z), dims=part.shape[::-1], out=part)
            if tell((1 + (z + len(part)) / depth) / 2):
                raise bccsplat.Cancelled("stopped")
        # NaN, where a label is missing, is no integer, nor is every label one.
        if volume.channel_info(channel).labels and np.array_equal(values, np.rint(values)):
            return values.astype(np.int32)
        return values

    def RequestData(self, _request, _inputs, outputs):
        out, volume, placement = outputs.GetInformationObject(0), self._open(), self._placement()
        info = volume.info()
        asked = out.Get(_PIPELINE.UPDATE_TIME_STEP()) if out.Has(_PIPELINE.UPDATE_TIME_STEP()) else info.time_first
        time = min(max(asked, info.time_first), info.time_end)
        extent = [int(end) for end in out.Get(_PIPELINE.UPDATE_EXTENT())]
        box = placement.in_file(extent)
        image = vtkImageData.GetData(outputs)
        image.SetExtent(extent)
        placement.place(image)
        for channel in range(info.channel_count):
            try:
                values = self._values(channel, time, *box, lambda made: self._tell((channel + made) / info.channel_count))
            except bccsplat.Cancelled:
                image.Initialize()
                self.Modified()  # what was stopped is no answer to the next one who asks
                return 1
            array = numpy_to_vtk(placement.in_image(values).ravel())
            array.SetName(volume.channel_info(channel).name)
            image.GetPointData().AddArray(array)
            if channel == 0:
                image.GetPointData().SetActiveScalars(array.GetName())
        unit = vtkStringArray()
        unit.SetName("time_unit")
        unit.InsertNextValue(self.GetTimeUnit())
        image.GetFieldData().AddArray(unit)
        image.GetInformation().Set(vtkImageData.DATA_TIME_STEP(), time)
        return 1
