// SPDX-License-Identifier: Apache-2.0
#include "store/recode.h"

#include <cmath>
#include <utility>

#include "api/numbers.h"
#include "api/streams.h"
#include "api/structs.h"
#include "api/writer.h"

using namespace bccsplat;
using namespace bccsplat::api;

namespace {

RecodeSettings read_recode_settings(const bccsplat_recode_options& o) {
  require_zero(o.reserved, "bccsplat_recode_options.reserved");
  RecodeSettings s;
  s.overwrite = o.overwrite != 0;
  if (o.store == BCCSPLAT_STORE_WAVELETS)
    fail(Code::unsupported,
         "a file is not coded anew as wavelets: their error is measured at the frames of the ",
         "source, which it does not hold; write the source with BCCSPLAT_STORE_WAVELETS (bcc4 import --store "
         "wavelets), or its exported frames where there is none");
  require_choice(o.store, BCCSPLAT_STORE_COEFFICIENTS, "bccsplat_recode_options.store");
  if (o.store != BCCSPLAT_STORE_DEFAULT) s.coefficients = o.store == BCCSPLAT_STORE_COEFFICIENTS;
  if (o.value_type < 0 || o.value_type > BCCSPLAT_TYPE_F32)
    fail(Code::invalid_argument, "value_type must be U8, U16, F16 or F32");
  if (o.value_type != 0) s.value_type = static_cast<ValueType>(o.value_type);
  require_range(o.value_step, 0, largest_value, "bccsplat_recode_options.value_step");
  s.value_step = o.value_step;
  if (o.kernel) s.kernel = o.kernel;
  if (o.format < 0 || o.format > bcc4_version)
    fail(Code::invalid_argument, "format ", o.format, " is not a version from 1 to ", bcc4_version);
  s.format = static_cast<uint16_t>(o.format);
  return s;
}

// run(samples, settings, context) recodes.
template<class Run>
bccsplat_status recode_volume(const bccsplat_volume* volume, const bccsplat_recode_options* options,
                              bccsplat_writer_report* report, const Run& run) {
  return guard([&] {
    require(volume, "volume");
    check_output(report, "report");
    const auto o = read_struct(options, "bccsplat_recode_options");
    const Token token = read_token(o.cancel_token);
    Progress progress(progress_callback(o.progress, o.progress_user));
    watch(progress, token), watch(progress, volume->token);
    progress.throw_if_cancelled();
    const Bcc4Samples samples(volume->file.reader(),
                              volume->device->memory); // as the file has them, relative to air
    write_report(report, run(samples, read_recode_settings(o), volume->device->context(progress)));
  });
}

} // namespace

extern "C" {

bccsplat_status bccsplat_volume_recode(const bccsplat_volume* volume, const char* path,
                                       const bccsplat_recode_options* options,
                                       bccsplat_writer_report* report) {
  return recode_volume(volume, options, report,
                       [&](const Bcc4Samples& samples, RecodeSettings settings, const Context& context) {
                         require(path, "path");
                         settings.path = path;
                         return recode(samples, settings, context);
                       });
}

bccsplat_status bccsplat_volume_recode_stream(const bccsplat_volume* volume,
                                              const bccsplat_write_stream* stream,
                                              const bccsplat_recode_options* options,
                                              bccsplat_writer_report* report) {
  return recode_volume(
      volume, options, report,
      [&](const Bcc4Samples& samples, const RecodeSettings& settings, const Context& context) {
        std::unique_ptr<ByteSink> sink = sink_of(stream);
        return recode(
            samples, settings, [&] { return std::move(sink); }, context);
      });
}

} // extern "C"
