"""A reader of .bcc4 for ParaView and VTK: a time-varying vtkImageData, at any time and not only on frames.

ParaView: Tools > Manage Plugins > Load New, this file; the Python package bccsplat must be in PYTHONPATH.
VTK:      reader = Bcc4Reader(); reader.SetFileName("smoke.bcc4"); reader.UpdateTimeStep(0.5)
"""
import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonCore import vtkStringArray
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


@smproxy.reader(name="Bcc4Reader", label="bccsplat volume", extensions="bcc4", file_description="bccsplat volumes")
class Bcc4Reader(VTKPythonAlgorithmBase):
    """One array per channel, at the source's resolution, in the world space of the file. Along axes whose samples are
    unevenly spaced voxels are even, as many as there are samples. Labels are integers, of the nearest frame. A filter that
    takes a region, such as Extract Subset, has no more than that made."""

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
        return self._open().times().tolist() if self._name else None

    @smproperty.stringvector(name="TimeUnit", information_only="1")
    def GetTimeUnit(self):
        """Of the times, as the file tells it; "": not told."""
        return self._open().info().time_unit or "" if self._name else ""

    def UpdateTimeStep(self, time):
        """For VTK without ParaView."""
        self.UpdateInformation()
        self.GetOutputInformation(0).Set(_PIPELINE.UPDATE_TIME_STEP(), time)
        self.Update()
        return self.GetOutputDataObject(0)

    def _open(self):
        if self._volume is None:
            self._volume = bccsplat.Volume(bccsplat.Device(), self._name, self._kernel or None)
        return self._volume

    def _geometry(self):
        """Samples per axis, origin, spacing and direction of the axes in world space."""
        info = self._open().info()
        affine = np.array(info.affine[:]).reshape(4, 4)
        spacing = np.linalg.norm(affine[:3, :3], axis=0)
        return info.dims[:3], affine[:3, 3], spacing, affine[:3, :3] / spacing

    def RequestInformation(self, _request, _inputs, outputs):
        dims, origin, spacing, direction = self._geometry()
        out, times = outputs.GetInformationObject(0), self._open().times()
        out.Set(_PIPELINE.WHOLE_EXTENT(), [0, dims[0] - 1, 0, dims[1] - 1, 0, dims[2] - 1], 6)
        out.Set(vtkImageData.ORIGIN(), origin.tolist(), 3)
        out.Set(vtkImageData.SPACING(), spacing.tolist(), 3)
        out.Set(vtkImageData.DIRECTION(), direction.ravel().tolist(), 9)
        out.Set(_PIPELINE.TIME_STEPS(), times.tolist(), len(times))
        out.Set(_PIPELINE.TIME_RANGE(), [times[0], times[-1]], 2)
        out.Set(vtkAlgorithm.CAN_PRODUCE_SUB_EXTENT(), 1)
        return 1

    def _tell(self, fraction):
        """Whether to stop."""
        self.UpdateProgress(fraction)
        return bool(self.GetAbortExecute())

    def _values(self, channel, time, extent, tell):
        """Of a channel in an extent, both ends included, x fastest. tell: gets the fraction that is there, and may stop it."""
        volume = self._open()
        first, last = extent[::2], extent[1::2]
        labels = volume.channel_info(channel).labels
        # Nothing lies between labels.
        when = {"frame": round(volume.time_to_index(time))} if labels else {"time": time}
        # A box counts samples, which are not where even voxels are.
        even = all(len(volume.axis(axis)[0]) == 0 for axis in range(3))
        cut = volume.slice(channel=channel, space="even", box=(first, last) if even else None,
                           progress=lambda made: tell(made / 2), **when)
        width, height, depth = (end - begin + 1 for begin, end in zip(first, last))
        values = np.empty((depth, height, width), np.float32)
        for z in range(0, depth, _PLANES):
            part = values[z:z + _PLANES]
            cut.sample_grid(origin=(first[0], first[1], first[2] + z), dims=part.shape[::-1], out=part)
            if tell((1 + (z + len(part)) / depth) / 2):
                raise bccsplat.Cancelled("stopped")
        return values.astype(np.int32) if labels else values

    def RequestData(self, _request, _inputs, outputs):
        out, volume = outputs.GetInformationObject(0), self._open()
        _, origin, spacing, direction = self._geometry()
        info = volume.info()
        asked = out.Get(_PIPELINE.UPDATE_TIME_STEP()) if out.Has(_PIPELINE.UPDATE_TIME_STEP()) else info.time_first
        time = min(max(asked, info.time_first), info.time_last)
        extent = [int(end) for end in out.Get(_PIPELINE.UPDATE_EXTENT())]
        image = vtkImageData.GetData(outputs)
        image.SetExtent(extent)
        image.SetOrigin(origin)
        image.SetSpacing(spacing)
        image.SetDirectionMatrix(direction.ravel().tolist())
        for channel in range(info.channel_count):
            try:
                values = self._values(channel, time, extent, lambda made: self._tell((channel + made) / info.channel_count))
            except bccsplat.Cancelled:
                image.Initialize()
                self.Modified()  # what was stopped is no answer to the next one who asks
                return 1
            array = numpy_to_vtk(values.ravel())
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
