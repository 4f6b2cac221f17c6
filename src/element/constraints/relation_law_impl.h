// SPDX-License-Identifier: BSD-3-Clause
// Values of relations for any number type.
#pragma once

#include <cmath>

#include "element/constraints/relation_law.h"

namespace gelenk {

template <class T>
void RelationLaw::load(const T* x, const T* rates, T* at) const {
  for (const Named& of : named_) *at++ = T(of.size) * (of.is_rate ? rates[of.term] : x[of.term]);
  for (const Named& of : named_) *at++ = T(of.size) * (of.is_rate ? T(0) : rates[of.term]);
}

template <class T>
T RelationLaw::length(const T* factors) const {
  using std::sqrt;
  T sum(0);
  for (int i = 0; i < terms_; ++i) sum += factors[i] * factors[i];
  return sqrt(sum);
}

template <class T>
T RelationLaw::value(const T* x, const T* rates, T* factors) const {
  T at[2 * most_terms];
  T out[1 + most_terms];
  load(x, rates, at);
  first_.evaluate(at, out);
  const T size = length(out + 1);
  for (int i = 0; i < terms_; ++i) factors[i] = out[1 + i] / size;
  return out[0] / size;
}

template <class T>
T RelationLaw::bias(const T* x, const T* rates) const {
  T at[2 * most_terms];
  T out[2 * most_terms];
  load(x, rates, at);
  second_.evaluate(at, out);
  const T size = length(out);
  if (is_of_rates_) return out[terms_] / size;
  T along(0), turn(0), rate(0);
  for (int i = 0; i < terms_; ++i) {
    along += out[terms_ + i] * rates[i];
    turn += out[terms_ + i] * out[i];
    rate += out[i] * rates[i];
  }
  return (along - rate * turn / (size * size)) / size;
}

}  // namespace gelenk
