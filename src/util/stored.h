// SPDX-License-Identifier: BSD-3-Clause
// A value of a type that is only declared here.
#pragma once

#include <utility>

namespace gelenk {

// Holds a value on the heap, and is copied, assigned and destroyed as the value itself would be. What holds it needs no
// definition of T; what looks at the value does. One file instantiates the members: stored_impl.h. What has been
// moved from may only be assigned or destroyed.
template <class T>
class Stored {
 public:
  Stored();  // the default value
  Stored(T value);
  Stored(const Stored& other);
  Stored(Stored&& other) noexcept : value_(std::exchange(other.value_, nullptr)) {}
  Stored& operator=(const Stored& other);
  Stored& operator=(Stored&& other) noexcept {
    std::swap(value_, other.value_);
    return *this;
  }
  ~Stored();

  T& operator*() { return *value_; }
  const T& operator*() const { return *value_; }
  T* operator->() { return value_; }
  const T* operator->() const { return value_; }
  const T& value() const { return *value_; }

 private:
  T* value_;
};

}  // namespace gelenk
