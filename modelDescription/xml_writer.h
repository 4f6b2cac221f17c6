// SPDX-License-Identifier: BSD-3-Clause
// XML as text, one element a line.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "modelDescription/write_xml.h"
#include "util/text.h"

namespace gelenk {

class XmlWriter {
 public:
  XmlWriter& open(int depth, std::string_view element) {
    text_.append(2 * static_cast<std::size_t>(depth), ' ').append("<").append(element);
    return *this;
  }
  XmlWriter& attribute(std::string_view name, std::string_view value) {
    text_.append(" ").append(name).append("=\"").append(escaped(value)).append("\"");
    return *this;
  }
  XmlWriter& attribute(std::string_view name, double value) { return attribute(name, text::number(value)); }
  XmlWriter& attribute(std::string_view name, int value) { return attribute(name, std::to_string(value)); }
  XmlWriter& attribute(std::string_view name, bool value) { return attribute(name, value ? "true" : "false"); }
  XmlWriter& attribute(std::string_view name, const char* value) { return attribute(name, std::string_view(value)); }
  void end() { text_.append("/>\n"); }
  void inside() { text_.append(">\n"); }
  void close(int depth, std::string_view element) {
    text_.append(2 * static_cast<std::size_t>(depth), ' ').append("</").append(element).append(">\n");
  }
  void raw(std::string_view text) { text_.append(text); }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

}  // namespace gelenk
