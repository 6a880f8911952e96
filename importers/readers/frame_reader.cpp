#include "readers/frame_reader.h"

#include <algorithm>

namespace bcc4 {

void gather_plane(const Frame& frame, const std::array<uint64_t, 4>& dims, uint64_t z, double air,
                  double* plane) {
  const auto nx = static_cast<int64_t>(dims[0]);
  std::fill(plane, plane + dims[0] * dims[1], air);
  for (const Box& box : frame.boxes) {
    const int64_t k = static_cast<int64_t>(z) - box.begin[2];
    if (k < 0 || k >= box.dims[2]) continue;
    visit_type(box.type, [&](auto zero) {
      for (int64_t j = 0; j < box.dims[1]; ++j) {
        const std::byte* from = box.data + j * box.stride_bytes[1] + k * box.stride_bytes[2];
        double* to = plane + (box.begin[1] + j) * nx + box.begin[0];
        for (int64_t i = 0; i < box.dims[0]; ++i)
          to[i] = load_as<decltype(zero)>(from + i * box.stride_bytes[0]);
      }
    });
  }
}

Frame dense_frame(Type type, std::shared_ptr<const Bytes> bytes, const std::array<uint64_t, 4>& dims) {
  Frame frame;
  const auto size = static_cast<int64_t>(type_size(type));
  Box box{.type = type, .data = bytes->data()};
  int64_t stride = size;
  for (size_t a = 0; a < 3; ++a) {
    box.dims[a] = static_cast<int64_t>(dims[a]);
    box.stride_bytes[a] = stride;
    stride *= box.dims[a];
  }
  frame.boxes.push_back(box);
  frame.storage.push_back(std::move(bytes));
  return frame;
}

} // namespace bcc4
