"""A reader of .bcc4 for ParaView and VTK: a time-varying vtkImageData, at any time and not only on frames.

ParaView: Tools > Manage Plugins > Load New, this file; the Python package bccsplat must be in PYTHONPATH.
VTK:      reader = Bcc4Reader(); reader.SetFileName("smoke.bcc4"); reader.UpdateTimeStep(0.5)
"""
import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.util.vtkAlgorithm import VTKPythonAlgorithmBase
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline

import bccsplat

try:
    from paraview.util.vtkAlgorithm import smdomain, smhint, smproperty, smproxy
except ImportError:  # plain VTK has no use for them

    class _Ignored:
        def __getattr__(self, _name):
            return lambda *_arguments, **_named: lambda decorated: decorated

    smdomain = smhint = smproperty = smproxy = _Ignored()

_PIPELINE = vtkStreamingDemandDrivenPipeline


@smproxy.reader(name="Bcc4Reader", label="bccsplat volume", extensions="bcc4", file_description="bccsplat volumes")
class Bcc4Reader(VTKPythonAlgorithmBase):
    """One array per channel, at the source's resolution, in the world space of the file. Along axes whose samples are
    unevenly spaced voxels are even, as many as there are samples."""

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
        return 1

    def RequestData(self, _request, _inputs, outputs):
        out, volume = outputs.GetInformationObject(0), self._open()
        dims, origin, spacing, direction = self._geometry()
        info = volume.info()
        asked = out.Get(_PIPELINE.UPDATE_TIME_STEP()) if out.Has(_PIPELINE.UPDATE_TIME_STEP()) else info.time_first
        time = min(max(asked, info.time_first), info.time_last)
        image = vtkImageData.GetData(outputs)
        image.SetDimensions(dims)
        image.SetOrigin(origin)
        image.SetSpacing(spacing)
        image.SetDirectionMatrix(direction.ravel().tolist())
        for channel in range(info.channel_count):
            box = volume.slice(time=time, channel=channel, space="even").sample_grid(origin=(0, 0, 0), dims=tuple(dims))  # x fastest
            array = numpy_to_vtk(box.ravel())
            array.SetName(volume.channel_info(channel).name)
            image.GetPointData().AddArray(array)
            if channel == 0:
                image.GetPointData().SetActiveScalars(array.GetName())
        image.GetInformation().Set(vtkImageData.DATA_TIME_STEP(), time)
        return 1
