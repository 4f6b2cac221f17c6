// SPDX-License-Identifier: BSD-3-Clause
// Capabilities of the FMU runtime and its log categories. modelDescription.xml declares them, the FMI functions use
// them.
#pragma once

#include <array>
#include <string_view>

namespace gelenk {

struct Capability {
  const char* name;
  bool supported;
  bool of_both = true;  // kinds of FMU; otherwise of co-simulation alone
};

inline constexpr std::array<Capability, 8> capabilities = {{
    {"canHandleVariableCommunicationStepSize", true, false},
    {"canInterpolateInputs", true, false},
    {"canRunAsynchronuously", false, false},
    {"canBeInstantiatedOnlyOncePerProcess", false},
    {"canNotUseMemoryManagementFunctions", true},
    {"canGetAndSetFMUstate", true},
    {"canSerializeFMUstate", true},
    {"providesDirectionalDerivative", true},
}};

// Of FMI 3.0.
inline constexpr std::array<Capability, 6> fmi3_capabilities = {{
    {"canHandleVariableCommunicationStepSize", true, false},
    {"canGetAndSetFMUState", true},
    {"canSerializeFMUState", true},
    {"providesDirectionalDerivatives", true},
    {"providesAdjointDerivatives", true},
    {"mightReturnEarlyFromDoStep", true, false},
}};

inline constexpr int max_output_derivative_order = 2;

struct LogCategory {
  const char* name;
  const char* description;
};

// Standard names of FMI 2.0, section 2.2.4. Warnings, discards and errors are logged unless the master disables them.
enum class Category : unsigned { events, warning, discard, error };
inline constexpr std::array<LogCategory, 4> log_categories = {{
    {"logEvents", "results of the assembly, events, changes of the instance's mode"},
    {"logStatusWarning", "singular configurations crossed, from which the mechanism could continue on another branch"},
    {"logStatusDiscard", "failed steps, states that do not determine the mechanism, derivatives that do not exist"},
    {"logStatusError", "invalid calls and the reasons why they were rejected"},
}};
inline constexpr std::string_view log_all = "logAll";

}  // namespace gelenk
