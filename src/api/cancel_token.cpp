// SPDX-License-Identifier: Apache-2.0
#include "api/handles.h"

using namespace bccsplat;
using namespace bccsplat::api;

extern "C" {

bccsplat_status bccsplat_cancel_token_create(bccsplat_cancel_token** token) {
  return guard([&] {
    require(token, "token");
    *token = nullptr;
    *token = new bccsplat_cancel_token;
  });
}

void bccsplat_cancel_token_retain(bccsplat_cancel_token* token) { retain(token); }
void bccsplat_cancel_token_release(bccsplat_cancel_token* token) { release(token); }

bccsplat_status bccsplat_cancel_token_cancel(bccsplat_cancel_token* token) {
  return guard([&] {
    require(token, "token");
    token->state.cancel();
  });
}

bccsplat_status bccsplat_cancel_token_reset(bccsplat_cancel_token* token) {
  return guard([&] {
    require(token, "token");
    token->state.reset();
  });
}

bccsplat_status bccsplat_cancel_token_is_cancelled(const bccsplat_cancel_token* token, int32_t* cancelled) {
  return guard([&] {
    require(token, "token"), require(cancelled, "cancelled");
    *cancelled = token->state.cancelled();
  });
}

} // extern "C"
