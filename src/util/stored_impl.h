// SPDX-License-Identifier: BSD-3-Clause
// The members of Stored, for the file that defines T: `template class Stored<T>;`.
#pragma once

#include <utility>

#include "util/stored.h"

namespace gelenk {

template <class T>
Stored<T>::Stored() : value_(new T()) {}
template <class T>
Stored<T>::Stored(T value) : value_(new T(std::move(value))) {}
template <class T>
Stored<T>::Stored(const Stored& other) : value_(new T(*other.value_)) {}
template <class T>
Stored<T>& Stored<T>::operator=(const Stored& other) {
  if (this != &other) *this = Stored(other);
  return *this;
}
template <class T>
Stored<T>::~Stored() {
  delete value_;
}

}  // namespace gelenk
