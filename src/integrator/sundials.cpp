// SPDX-License-Identifier: BSD-3-Clause
#include "integrator/sundials.h"

#include <sundials/sundials_logger.h>

namespace gelenk::sundials {

Context::Context() {
  if (SUNContext_Create(SUN_COMM_NULL, &context_) != SUN_SUCCESS) throw std::bad_alloc();
  SUNContext_ClearErrHandlers(context_);
  SUNContext_PushErrHandler(context_, keep, this);
  // Warnings are otherwise written to stderr separately.
  SUNLogger logger = nullptr;
  SUNContext_GetLogger(context_, &logger);
  SUNLogger_SetErrorFilename(logger, "");
  SUNLogger_SetWarningFilename(logger, "");
}

Context::~Context() { SUNContext_Free(&context_); }

void Context::keep(int, const char*, const char*, const char* message, SUNErrCode, void* self, SUNContext) {
  if (message != nullptr) static_cast<Context*>(self)->last_error_ = message;
}

}  // namespace gelenk::sundials
