// SPDX-License-Identifier: BSD-3-Clause
// What other programs call what scene files name.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gelenk {

// Words with spaces between.
using Words = std::string_view;
// Whether the word is among them, in capital letters or small ones.
bool contains(Words words, std::string_view word);

// Our word for what another program calls `found`, if it is one of `known`; else empty.
std::string our_word(std::string_view found, const std::vector<std::string>& known);

}  // namespace gelenk
