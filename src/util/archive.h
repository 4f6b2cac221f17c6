// SPDX-License-Identifier: BSD-3-Clause
// Archive: numbers of a run, written down and read back in the same order, so that the run can go on from there to the
// bit. What a class carries from one step to the next it names once, in serialize(Archive&), for both ways.
#pragma once

#include <bit>
#include <concepts>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

namespace gelenk {

class Archive {
 public:
  // Empty, to be written.
  Archive() = default;
  // To be read from its beginning.
  explicit Archive(std::vector<std::uint64_t> words) : words_(std::move(words)), reading_(true) {}

  bool reading() const { return reading_; }
  const std::vector<std::uint64_t>& words() const { return words_; }

  void write_anew() {
    words_.clear();
    reading_ = false;
  }
  void read_anew() {
    next_ = 0;
    reading_ = true;
  }
  // All that was written has been read.
  bool ended() const { return next_ == words_.size(); }
  // So that writing this many words asks nothing of the heap.
  void reserve(std::size_t words) { words_.reserve(words); }
  // Writes what another record holds.
  void append(const Archive& other) { words_.insert(words_.end(), other.words_.begin(), other.words_.end()); }
  // After reading: throws std::invalid_argument if anything is left.
  void finish() const {
    if (reading_ && next_ != words_.size()) fail();
  }

  // Vectors and arrays keep their length, which is not part of the record. Throw std::invalid_argument when the record
  // ends too early, and for a bool that is none.
  void serialize(double& x) { word(x); }
  void serialize(std::uint64_t& x) { word(x); }
  void serialize(bool& x) {
    int number = x ? 1 : 0;
    within(number, 0, 1);
    x = number == 1;
  }
  template <std::signed_integral Int>
  void serialize(Int& x) {
    // What is counted is far from this, and what is computed from it stays in range: 2^48 in 64 bits, 2^28 in 32.
    constexpr std::int64_t most = std::numeric_limits<Int>::max() >> (sizeof(Int) > 4 ? 15 : 3);
    std::int64_t wide = x;
    word(wide);
    if (reading_ && (wide > most || wide < -most)) fail();
    x = static_cast<Int>(wide);
  }
  template <class Numbers>
    requires requires(Numbers& x) { x.begin(); }
  void serialize(Numbers& x) {
    for (auto& number : x) serialize(number);
  }
  template <class First, class Second, class... Rest>
  void serialize(First& first, Second& second, Rest&... rest) {
    serialize(first);
    serialize(second);
    (serialize(rest), ...);
  }

  // A whole number that decides where something is found. Throws std::invalid_argument outside [low, high].
  template <std::signed_integral Int>
  void within(Int& x, Int low, Int high) {
    Int number = x;
    serialize(number);
    if (number < low || number > high) fail();
    x = number;
  }

 private:
  template <class T>
  void word(T& x) {
    if (!reading_) {
      words_.push_back(std::bit_cast<std::uint64_t>(x));
      return;
    }
    if (next_ == words_.size()) fail();
    x = std::bit_cast<T>(words_[next_++]);
  }
  [[noreturn]] static void fail() { throw std::invalid_argument("it is not of this plant, or damaged"); }

  std::vector<std::uint64_t> words_;
  std::size_t next_ = 0;  // to be read
  bool reading_ = false;
};

}  // namespace gelenk
