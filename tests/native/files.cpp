// SPDX-License-Identifier: BSD-3-Clause
// How FMUs are written.
#include <string>
#include <system_error>

#include "fmu/export/write_file.h"
#include "units.h"

namespace nb = nanobind;

namespace native {

void bind_files(nb::module_& m) {
  // Returns the number of the error, 0: none.
  m.def(
      "write_file",
      [](const std::string& target, nb::bytes content) {
        try {
          const nb::gil_scoped_release others_may_run;  // such as the reader of a pipe
          gelenk::write_file(target, {content.c_str(), content.size()});
        } catch (const std::system_error& error) {
          return error.code().value();
        }
        return 0;
      },
      nb::arg("target"), nb::arg("content"));
}

}  // namespace native
