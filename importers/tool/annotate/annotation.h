// SPDX-License-Identifier: Apache-2.0
// What a picture needs to be shown by itself: --annotate, drawn into it after it was rendered.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tool/annotate/color_bar.h"
#include "tool/annotate/projection.h"
#include "tool/annotate/world_names.h"
#include "tool/handles.h"
#include "tool/view/picture_sequence.h"
#include "tool/view/render_arguments.h"
#include "tool/view/xray_exposure.h"

namespace bcc4 {

class Annotation {
 public:
  // colors: of the transfer function that is drawn with. of_labels: these are those of a look of labels.
  // Parts that were asked for by name and that these pictures cannot have are told.
  Annotation(const RenderArguments& arguments, const Volume& volume, uint32_t channel,
             std::vector<std::array<double, 4>> colors, bool of_labels, double iso_value,
             const std::vector<Picture>& pictures);

  // number: of the picture, in order. domain: the slice that the picture is of, in whole. exposure: of
  // X-rays. trail: the bar of its colours, if they differ.
  void draw(const Image& image, size_t number, const bccsplat_camera& camera,
            const bccsplat_slice_info& domain, const std::optional<XrayExposure>& exposure,
            const std::optional<ColorBar>& trail) const;

 private:
  [[nodiscard]] std::optional<ColorBar> color_bar(const std::optional<XrayExposure>& exposure) const;

  const RenderArguments& a_;
  AnnotationParts parts_;
  bccsplat_volume_info volume_;
  Ink ink_;
  std::string title_, heading_, spatial_unit_;
  std::vector<std::array<double, 4>> colors_;
  std::optional<ColorBar> fields_;   // of several surfaces, of labels
  std::vector<std::string> moments_; // of each picture
  std::vector<bool> is_time_slice_;
  std::optional<WorldNames> names_; // of the axes
  bool one_unit_;                   // of all axes, in which the world has the file's shape
};

} // namespace bcc4
