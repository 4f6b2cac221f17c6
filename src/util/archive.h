// SPDX-License-Identifier: BSD-3-Clause
// Archive: the saved state of a run as a sequence of 64-bit words, read back in the order in which they were written;
// the restored run continues with bitwise identical results. Each class lists the data that it carries from one step to
// the next once, in serialize(Archive&), which both writes and reads.
#pragma once

#include <algorithm>
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
  explicit Archive(std::vector<std::uint64_t> words) : words_(std::move(words)), end_(words_.size()), reading_(true) {}

  bool reading() const { return reading_; }
  std::span<const std::uint64_t> words() const { return {words_.data(), reading_ ? end_ : next_}; }

  // Empties the archive for writing; its memory is kept.
  void start_writing() {
    next_ = 0;
    end_ = words_.size();
    reading_ = false;
  }
  // Switches to reading, from the first word.
  void start_reading() {
    if (!reading_) end_ = next_;
    next_ = 0;
    reading_ = true;
  }
  // Whether all words have been read.
  bool at_end() const { return next_ == end_; }
  // Reserves memory, so that writing this many words does not allocate.
  void reserve(std::size_t words) {
    if (words_.size() < words) words_.resize(words);
    if (!reading_) end_ = words_.size();
  }
  // Appends all words of another archive to one that is written.
  void append(const Archive& other) {
    const std::span<const std::uint64_t> words = other.words();
    if (end_ - next_ < words.size()) make_room(words.size());
    std::ranges::copy(words, words_.begin() + static_cast<std::ptrdiff_t>(next_));
    next_ += words.size();
  }
  // To be called after reading: throws std::invalid_argument if words are left.
  void finish() const {
    if (reading_ && next_ != end_) fail();
  }

  // Write x, or read it. Vectors and arrays keep their length, which is not part of the archive. Throw
  // std::invalid_argument if the archive ends too early or a value is out of range for its type.
  [[gnu::always_inline]] void serialize(double& x) { word(x); }
  [[gnu::always_inline]] void serialize(std::uint64_t& x) { word(x); }
  [[gnu::always_inline]] void serialize(bool& x) {
    if (reading_) {
      x = take_in_range(0, 1) == 1;
    } else {
      put(x ? 1 : 0);
    }
  }
  template <std::signed_integral Int>
  [[gnu::always_inline]] void serialize(Int& x) {
    // Counts are far below this limit, 2^48 in 64 bits and 2^28 in 32, and arithmetic with them cannot overflow.
    constexpr std::int64_t limit = std::numeric_limits<Int>::max() >> (sizeof(Int) > 4 ? 15 : 3);
    serialize_in_range<Int>(x, -limit, limit);
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

  // Serializes an index or a count; throws std::invalid_argument if one that is read is not in [low, high].
  template <std::signed_integral Int>
  [[gnu::always_inline]] void serialize_in_range(Int& x, Int low, Int high) {
    if (reading_) {
      x = static_cast<Int>(take_in_range(low, high));
    } else {
      put(static_cast<std::uint64_t>(static_cast<std::int64_t>(x)));
    }
  }

 private:
  // Writing is inlined, since every step writes its start; reading is not.
  template <class T>
  [[gnu::always_inline]] void word(T& x) {
    if (reading_) {
      x = std::bit_cast<T>(take());
    } else {
      put(std::bit_cast<std::uint64_t>(x));
    }
  }
  [[gnu::always_inline]] void put(std::uint64_t word) {
    if (next_ == end_) make_room(1);
    words_[next_++] = word;
  }
  [[gnu::noinline]] std::uint64_t take() {
    if (next_ == end_) fail();
    return words_[next_++];
  }
  [[gnu::noinline]] std::int64_t take_in_range(std::int64_t low, std::int64_t high) {
    const auto number = static_cast<std::int64_t>(take());
    if (number < low || number > high) fail();
    return number;
  }
  // For as many words to be written; there are not as many to be read.
  [[gnu::noinline]] void make_room(std::size_t words) {
    if (reading_) fail();
    words_.resize(std::max(2 * words_.size(), next_ + words));
    end_ = words_.size();
  }
  // At once, since every step writes many.
  void serialize_span(std::span<double> x) {
    static_assert(sizeof(double) == sizeof(std::uint64_t));
    if (x.empty()) return;
    if (end_ - next_ < x.size()) make_room(x.size());
    if (reading_) {
      std::memcpy(x.data(), words_.data() + next_, x.size_bytes());
    } else {
      std::memcpy(words_.data() + next_, x.data(), x.size_bytes());
    }
    next_ += x.size();
  }
  [[noreturn]] static void fail() { throw std::invalid_argument("it is not of this plant, or damaged"); }

  std::vector<std::uint64_t> words_;  // those of the archive, and room for more
  std::size_t next_ = 0;              // index of the next word to write or to read
  std::size_t end_ = 0;               // of the room for words, or of the words to read
  bool reading_ = false;
};

}  // namespace gelenk
