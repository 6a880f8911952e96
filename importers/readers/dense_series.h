// SPDX-License-Identifier: Apache-2.0
// Frames out of one big array of bytes, whatever the order of its axes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "readers/byte_stream.h"
#include "readers/frame_reader.h"
#include "readers/reader_options.h"
#include "readers/stored_values.h"

namespace bcc4 {

struct DenseLayout : StoredValues {
  bool swap = false;          // the bytes are not in native order
  std::vector<FileAxis> axes; // fastest first; each role at most once

  [[nodiscard]] uint64_t size_of(AxisRole role) const;
};

// Returns the product of the axes' sizes and the type's size in bytes; throws when an axis is empty or the
// product overflows.
[[nodiscard]] uint64_t layout_bytes(const DenseLayout& layout, const std::string& path);
// Returns text such as "x 64 (fastest), y 64, z 64, t 99 (slowest)".
[[nodiscard]] std::string layout_text(const DenseLayout& layout);
// Makes axes of letters such as "zyxt" or "xyz" with sizes by letter; throws for other letters or a letter
// twice.
[[nodiscard]] std::vector<FileAxis> axes_from_letters(const std::string& letters,
                                                      const std::array<uint64_t, 4>& sizes);
// Returns the roles that --axes gives to the `count` axes of a file, fastest first; `owner` names what has
// the axes, for the error. Where there may be components, a c stands for their axis.
[[nodiscard]] std::vector<AxisRole> roles_from_letters(const std::string& letters, size_t count,
                                                       const std::string& owner,
                                                       bool with_components = false);

// Marks what is behind the last frame that is taken as unread. One file per frame has nothing to mark.
void leave_unread(std::vector<Segment>& segments, const DenseLayout& layout, const FrameSelection& frames);
// Returns how many frames are whole where a file ends so many bytes behind its first value, and by which
// option they are taken; "" where there are none, or they do not stand one behind the other.
[[nodiscard]] std::string whole_frames(const DenseLayout& layout, uint64_t bytes);
// Does the former, and throws where a file cannot hold what it declares before that, with the latter.
void check_segments(std::vector<Segment>& segments, const DenseLayout& layout, const FrameSelection& frames);

// Where time is not the slowest axis, frames are collected in passes over the array: as many per pass as fit
// in half of the memory limit, so memory does not grow with the number of frames.
class DenseSeries {
 public:
  DenseSeries(std::vector<Segment> segments, DenseLayout layout, uint64_t memory_limit);

  // Returns the type of the frames handed out: the source's, or a float type where values are converted.
  [[nodiscard]] Type frame_type() const { return frame_type_; }
  [[nodiscard]] Frame read(uint64_t t, uint64_t component);
  // Returns at least these samples: of arrays whose slowest axis of space is z, and time behind it, no others
  // where the frame does not fit.
  [[nodiscard]] Frame read_box(uint64_t t, uint64_t component, const SampleBox& wanted);
  // Returns whether a frame fits the memory limit; else read refuses it, and read_box does not.
  [[nodiscard]] bool frame_fits() const { return frame_held_ <= memory_limit_; }
  [[nodiscard]] const std::string& path_of(uint64_t t) const;
  // Says how a file is read in which time is not the slowest axis; "" where it is.
  [[nodiscard]] std::string passes_text() const;

 private:
  void fetch(uint64_t t);
  [[nodiscard]] std::shared_ptr<Bytes> read_planes(uint64_t t, const SampleBox& wanted);
  [[noreturn]] void refuse_frame() const; // more than memory allows
  [[nodiscard]] bool has_planes() const;  // one after the other, of one component

  SegmentedBytes bytes_;
  DenseLayout layout_;
  Type frame_type_;
  uint64_t inner_;                                 // bytes of the axes faster than t
  uint64_t outer_ = 1;                             // product of the axes slower than t
  uint64_t memory_limit_ = 0, frame_held_ = 0;     // bytes; of one frame
  uint64_t batch_ = 1;                             // frames held
  uint64_t first_ = 0;                             // frame number of held_[0]
  std::vector<std::shared_ptr<const Bytes>> held_; // all components of a frame, converted
};

} // namespace bcc4
