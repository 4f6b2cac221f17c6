// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/states.h"

#include "fmu/api_call.h"

namespace gelenk {
namespace {

// After an internal error the state must not be saved, but a saved one may be restored.
constexpr unsigned savable_modes = assembled | Mode::instantiated;

// Runs body(instance, state) with a state of this instance.
template <class Body>
Status with_state(void* c, const char* function, const void* state, Body&& body) noexcept {
  return call(c, function, any_mode, [&](Instance& instance) {
    SavedState* found = instance.find(state);
    if (found == nullptr) {
      return refuse(instance, function,
                    std::string("FMU state: found ") + (state == nullptr ? "a null pointer" : "an unknown one") +
                        ", expected one that this instance has created and not freed");
    }
    return body(instance, *found);
  });
}

Status refuse_null_pointer(Instance& instance, const char* function, const char* what) {
  return refuse(instance, function, std::string(what) + ": found a null pointer, expected a place for the result");
}

}  // namespace

Status get_state(void* instance, const char* function, void** state) noexcept {
  return call(instance, function, savable_modes, [&](Instance& of) {
    if (state == nullptr) return refuse_null_pointer(of, function, "FMU state");
    if (SavedState* found = of.find(*state)) {
      of.save(*found);
    } else {
      *state = of.save();
    }
    return Status::ok;
  });
}

Status set_state(void* instance, const char* function, void* state) noexcept {
  return with_state(instance, function, state, [&](Instance& of, SavedState& saved) {
    try {
      of.restore(saved);
    } catch (const std::invalid_argument& error) {
      return refuse(of, function, std::string("FMU state: ") + error.what());
    }
    return Status::ok;
  });
}

Status free_state(void* instance, const char* function, void** state) noexcept {
  if (state == nullptr || *state == nullptr) {  // as free() does
    return call(instance, function, any_mode, [](Instance&) { return Status::ok; });
  }
  return with_state(instance, function, *state, [&](Instance& of, SavedState& saved) {
    of.free(&saved);
    *state = nullptr;
    return Status::ok;
  });
}

Status get_serialized_size(void* instance, const char* function, void* state, std::size_t* size) noexcept {
  return with_state(instance, function, state, [&](Instance& of, const SavedState& saved) {
    if (size == nullptr) return refuse_null_pointer(of, function, "size");
    *size = serialized_size(saved);
    return Status::ok;
  });
}

Status serialize_state(void* instance, const char* function, void* state, char* bytes, std::size_t size) noexcept {
  return with_state(instance, function, state, [&](Instance& of, const SavedState& saved) {
    if (bytes == nullptr) return refuse_null_pointer(of, function, "bytes");
    const std::size_t needed = serialized_size(saved);
    if (size < needed) {
      return refuse(of, function,
                    "size: found " + std::to_string(size) + ", expected " + std::to_string(needed) +
                        ", the number returned by " + of.interface().vocabulary.serialized_size);
    }
    serialize(saved, of.plant().model().guid, {bytes, needed});
    return Status::ok;
  });
}

Status deserialize_state(void* instance, const char* function, const char* bytes, std::size_t size,
                         void** state) noexcept {
  return call(instance, function, any_mode, [&](Instance& of) {
    if (bytes == nullptr) return refuse(of, function, "bytes: found a null pointer, expected a state");
    if (state == nullptr) return refuse_null_pointer(of, function, "FMU state");
    auto saved = deserialize(of.plant().model().guid, {bytes, size}, of.interface().vocabulary);
    *state = of.adopt(std::move(saved));
    return Status::ok;
  });
}

}  // namespace gelenk
