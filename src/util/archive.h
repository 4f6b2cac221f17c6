// SPDX-License-Identifier: BSD-3-Clause
// Archive: the saved state of a run as a sequence of 64-bit words, read back in the order in which they were written;
// the restored run continues with bitwise identical results. Each class lists the data that it carries from one step to
// the next once, in serialize(Archive&), which both writes and reads.
#pragma once

#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace gelenk {

class Archive {
 public:
  // An empty archive for writing.
  Archive() = default;
  // An archive for reading, from its first word.
  explicit Archive(std::vector<std::uint64_t> words) : words_(std::move(words)), reading_(true) {}

  bool reading() const { return reading_; }
  const std::vector<std::uint64_t>& words() const { return words_; }

  // Empties the archive for writing; its memory is kept.
  void start_writing() {
    words_.clear();
    reading_ = false;
  }
  // Switches to reading, from the first word.
  void start_reading() {
    next_ = 0;
    reading_ = true;
  }
  // Whether all words have been read.
  bool at_end() const { return next_ == words_.size(); }
  // Reserves memory, so that writing this many words does not allocate.
  void reserve(std::size_t words) { words_.reserve(words); }
  // Appends all words of another archive.
  void append(const Archive& other) { words_.insert(words_.end(), other.words_.begin(), other.words_.end()); }
  // To be called after reading: throws std::invalid_argument if words are left.
  void finish() const {
    if (reading_ && next_ != words_.size()) fail();
  }

  // Write x, or read it. Vectors and arrays keep their length, which is not part of the archive. Throw
  // std::invalid_argument if the archive ends too early or a value is out of range for its type.
  void serialize(double& x) { word(x); }
  void serialize(std::uint64_t& x) { word(x); }
  void serialize(bool& x) {
    int number = x ? 1 : 0;
    serialize_in_range(number, 0, 1);
    x = number == 1;
  }
  template <std::signed_integral Int>
  void serialize(Int& x) {
    // Counts are far below this limit, 2^48 in 64 bits and 2^28 in 32, and arithmetic with them cannot overflow.
    constexpr std::int64_t limit = std::numeric_limits<Int>::max() >> (sizeof(Int) > 4 ? 15 : 3);
    std::int64_t wide = x;
    word(wide);
    if (reading_ && (wide > limit || wide < -limit)) fail();
    x = static_cast<Int>(wide);
  }
  template <class Numbers>
    requires requires(Numbers& x) { x.begin(); }
  void serialize(Numbers& x) {
    if constexpr (requires(Numbers& of) { std::span<double>(of); }) {
      serialize_span(std::span<double>(x));
    } else {
      for (auto& number : x) serialize(number);
    }
  }
  template <class First, class Second, class... Rest>
  void serialize(First& first, Second& second, Rest&... rest) {
    serialize(first);
    serialize(second);
    (serialize(rest), ...);
  }

  // Serializes an index or a count; throws std::invalid_argument if it is not in [low, high].
  template <std::signed_integral Int>
  void serialize_in_range(Int& x, Int low, Int high) {
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
  // At once, since every step writes many.
  void serialize_span(std::span<double> x) {
    static_assert(sizeof(double) == sizeof(std::uint64_t));
    if (x.empty()) return;
    const std::size_t first = reading_ ? next_ : words_.size();
    if (!reading_) {
      words_.resize(first + x.size());
      std::memcpy(words_.data() + first, x.data(), x.size_bytes());
      return;
    }
    if (words_.size() - next_ < x.size()) fail();
    std::memcpy(x.data(), words_.data() + first, x.size_bytes());
    next_ += x.size();
  }
  [[noreturn]] static void fail() { throw std::invalid_argument("it is not of this plant, or damaged"); }

  std::vector<std::uint64_t> words_;
  std::size_t next_ = 0;  // index of the next word to read
  bool reading_ = false;
};

}  // namespace gelenk
