// SPDX-License-Identifier: BSD-3-Clause
// FMU states: saving, restoring, serialization.
#include "fmu/api_call.h"

namespace gelenk {
namespace {

// Runs body(instance, state) with a state of this instance.
template <class Body>
fmi2Status with_state(fmi2Component c, const char* function, unsigned modes, fmi2FMUstate state, Body&& body) noexcept {
  return call(c, function, modes, [&](Instance& instance) {
    SavedState* found = instance.find(state);
    if (found == nullptr) {
      return refuse(instance, function,
                    std::string("FMU state: found ") + (state == nullptr ? "a null pointer" : "an unknown one") +
                        ", expected one that this instance has created and not freed");
    }
    return body(instance, *found);
  });
}

fmi2Status refuse_null_pointer(Instance& instance, const char* function, const char* what) {
  return refuse(instance, function, std::string(what) + ": found a null pointer, expected a place for the result");
}

}  // namespace
}  // namespace gelenk

using gelenk::Instance;
using gelenk::Mode;
using gelenk::SavedState;

namespace {

// After an internal error the state must not be saved, but a saved one may be restored.
constexpr unsigned savable_modes = gelenk::assembled | Mode::instantiated;

}  // namespace

extern "C" {

// A state of this instance is overwritten and its memory reused. Any other pointer is replaced by a new state, since
// some masters do not initialize it.
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate* FMUstate) {
  constexpr const char* name = "fmi2GetFMUstate";
  return gelenk::call(c, name, savable_modes, [&](Instance& instance) {
    if (FMUstate == nullptr) return gelenk::refuse_null_pointer(instance, name, "FMU state");
    if (SavedState* found = instance.find(*FMUstate)) {
      instance.save(*found);
    } else {
      *FMUstate = instance.save();
    }
    return fmi2OK;
  });
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate) {
  constexpr const char* name = "fmi2SetFMUstate";
  return gelenk::with_state(c, name, gelenk::any_mode, FMUstate, [](Instance& instance, SavedState& state) {
    try {
      instance.restore(state);
    } catch (const std::invalid_argument& error) {
      return gelenk::refuse(instance, name, std::string("FMU state: ") + error.what());
    }
    return fmi2OK;
  });
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate* FMUstate) {
  constexpr const char* name = "fmi2FreeFMUstate";
  if (FMUstate == nullptr || *FMUstate == nullptr) {  // as free() does
    return gelenk::call(c, name, gelenk::any_mode, [](Instance&) { return fmi2OK; });
  }
  return gelenk::with_state(c, name, gelenk::any_mode, *FMUstate, [&](Instance& instance, SavedState& state) {
    instance.free(&state);
    *FMUstate = nullptr;
    return fmi2OK;
  });
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t* size) {
  constexpr const char* name = "fmi2SerializedFMUstateSize";
  return gelenk::with_state(c, name, gelenk::any_mode, FMUstate, [&](Instance& instance, SavedState& state) {
    if (size == nullptr) return gelenk::refuse_null_pointer(instance, name, "size");
    *size = gelenk::serialized_size(state);
    return fmi2OK;
  });
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size) {
  constexpr const char* name = "fmi2SerializeFMUstate";
  return gelenk::with_state(c, name, gelenk::any_mode, FMUstate, [&](Instance& instance, SavedState& state) {
    if (serializedState == nullptr) return gelenk::refuse_null_pointer(instance, name, "bytes");
    const std::size_t needed = gelenk::serialized_size(state);
    if (size < needed) {
      return gelenk::refuse(instance, name,
                            "size: found " + std::to_string(size) + ", expected " + std::to_string(needed) +
                                ", the number returned by fmi2SerializedFMUstateSize");
    }
    gelenk::serialize(state, instance.plant().model().guid, {serializedState, needed});
    return fmi2OK;
  });
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate* FMUstate) {
  constexpr const char* name = "fmi2DeSerializeFMUstate";
  return gelenk::call(c, name, gelenk::any_mode, [&](Instance& instance) {
    if (serializedState == nullptr)
      return gelenk::refuse(instance, name, "bytes: found a null pointer, expected a state");
    if (FMUstate == nullptr) return gelenk::refuse_null_pointer(instance, name, "FMU state");
    auto state = gelenk::deserialize(instance.plant().model().guid, {serializedState, size});
    *FMUstate = instance.adopt(std::move(state));
    return fmi2OK;
  });
}

}  // extern "C"
