// SPDX-License-Identifier: BSD-3-Clause
#include "integrator/sundials.h"

namespace gelenk::sundials {

Context::Context() {
  if (SUNContext_Create(SUN_COMM_NULL, &context_) != SUN_SUCCESS) throw std::bad_alloc();
  SUNContext_ClearErrHandlers(context_);
  SUNContext_PushErrHandler(context_, keep, this);
}

Context::~Context() { SUNContext_Free(&context_); }

void Context::keep(int, const char*, const char*, const char* message, SUNErrCode, void* self, SUNContext) {
  if (message != nullptr) static_cast<Context*>(self)->last_error_ = message;
}

}  // namespace gelenk::sundials
