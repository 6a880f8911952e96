// SPDX-License-Identifier: Apache-2.0
#include "readers/frame_reader.h"

namespace bcc4 {

Frame dense_frame(Type type, std::shared_ptr<const Bytes> bytes, const std::vector<FileAxis>& axes,
                  uint64_t component) {
  uint64_t stride = type_size(type);
  Box box;
  box.type = type;
  box.data = bytes->data();
  box.dims = {1, 1, 1};
  box.stride_bytes = {stride, stride, stride};
  for (const FileAxis& axis : axes) {
    if (axis.role == AxisRole::t) continue;
    if (axis.role == AxisRole::component) {
      box.data += component * stride;
    } else {
      box.dims[static_cast<size_t>(axis.role)] = axis.size;
      box.stride_bytes[static_cast<size_t>(axis.role)] = stride;
    }
    stride *= axis.size;
  }
  return {{box}, {std::move(bytes)}};
}

} // namespace bcc4
