// SPDX-License-Identifier: BSD-3-Clause
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.h"
#include "fmu/export/pack.h"
#include "simulation/simulation.h"

namespace nb = nanobind;

namespace {

// The exception classes are defined in Python (gelenk/errors.py), with documentation and types.
template <class Argument>
void raise(const char* name, const Argument& argument) {
  try {
    const nb::object type = nb::module_::import_("gelenk.errors").attr(name);
    const nb::object error = type(argument);
    PyErr_SetObject(type.ptr(), error.ptr());
  } catch (nb::python_error& e) {
    e.restore();
  }
}

void translate(const std::exception_ptr& thrown, void*) {
  try {
    std::rethrow_exception(thrown);
  } catch (const gelenk::SceneError& e) {
    raise("SceneError", e.lines());
  } catch (const gelenk::AssemblyError& e) {
    raise("AssemblyError", std::string(e.what()));
  } catch (const gelenk::StepBudgetError& e) {
    raise("StepBudgetError", std::string(e.what()));
  } catch (const gelenk::StepError& e) {
    raise("StepError", std::string(e.what()));
  } catch (const gelenk::UsageError& e) {
    raise("UsageError", std::string(e.what()));
  } catch (const gelenk::ExportError& e) {
    raise("ExportError", std::string(e.what()));
  }
}

}  // namespace

void gelenk::bind_errors(nb::module_&) { nb::register_exception_translator(translate); }
