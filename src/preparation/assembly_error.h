// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

namespace gelenk {

// The loops cannot be closed with these start values. The message has the smallest closure error and its location.
class AssemblyError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A loop has a small closure error, which may be caused by rounded dimensions.
class OpenLoop : public AssemblyError {
 public:
  OpenLoop(const std::string& what, double closure_error) : AssemblyError(what), closure_error(closure_error) {}
  double closure_error;  // m or rad, in natural units
};

}  // namespace gelenk
