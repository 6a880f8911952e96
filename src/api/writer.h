// SPDX-License-Identifier: Apache-2.0
// What stands behind a writer's handle, and the translation of its options.
#pragma once

#include "api/handles.h"
#include "store/volume_writer.h"

namespace bccsplat::api {

// The core's settings of the options of the C ABI. path: null for a stream.
[[nodiscard]] WriterSettings read_writer_settings(const bccsplat_writer_options& options, const char* path);
// Fills the caller's struct; report may be null.
void write_report(bccsplat_writer_report* out, const WriteReport& report);

} // namespace bccsplat::api

struct bccsplat_writer : bccsplat::api::Object<bccsplat::api::Kind::writer> {
  bccsplat_writer(bccsplat_device* owner, const bccsplat_writer_options& options,
                  bccsplat::WriterSettings settings, std::unique_ptr<bccsplat::ByteSink> stream)
      : device(owner), token(bccsplat::api::read_token(options.cancel_token)),
        progress(bccsplat::api::progress_callback(options.progress, options.progress_user)),
        writer(std::move(settings), std::move(stream), begin(owner)) {}

  bccsplat::api::Ref<bccsplat_device> device;
  bccsplat::api::Token token;
  bccsplat::Progress progress;
  bccsplat::VolumeWriter writer;
  mutable bccsplat::api::Users users;

 private:
  [[nodiscard]] bccsplat::Context begin(bccsplat_device* owner) {
    bccsplat::api::watch(progress, token);
    progress.begin_call();
    return owner->context(progress);
  }
};
