// SPDX-License-Identifier: BSD-3-Clause
// What the FMU runtime can do, and the categories of what it says: modelDescription.xml declares them, the FMI
// functions keep to them.
#pragma once

#include <array>
#include <string_view>

namespace gelenk {

struct Capability {
  const char* name;
  bool works;
};

inline constexpr std::array<Capability, 8> capabilities = {{
    {"canHandleVariableCommunicationStepSize", true},
    {"canInterpolateInputs", true},
    {"canRunAsynchronuously", false},
    {"canBeInstantiatedOnlyOncePerProcess", false},
    {"canNotUseMemoryManagementFunctions", true},
    {"canGetAndSetFMUstate", true},
    {"canSerializeFMUstate", true},
    {"providesDirectionalDerivative", true},
}};

inline constexpr int max_output_derivative_order = 2;

struct LogCategory {
  const char* name;
  const char* description;
};

// Standard names of FMI 2.0, section 2.2.4. Warnings, discards and errors are told unless the master declines.
enum class Category : unsigned { events, warning, discard, error };
inline constexpr std::array<LogCategory, 4> log_categories = {{
    {"logEvents", "what assembly found, changes of the instance's mode"},
    {"logStatusWarning", "singular positions passed, where loops could go on by another branch"},
    {"logStatusDiscard", "steps that could not be made, derivatives that do not exist"},
    {"logStatusError", "wrong calls and why they were refused"},
}};
inline constexpr std::string_view log_all = "logAll";

}  // namespace gelenk
