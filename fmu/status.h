// SPDX-License-Identifier: BSD-3-Clause
// The result of an FMI function, and how the versions of FMI name what messages speak of.
#pragma once

namespace gelenk {

// With the numbers of fmi2Status and fmi3Status.
enum class Status { ok = 0, warning = 1, discard = 2, error = 3 };

// Names of functions, arguments and types in one version of FMI.
struct Vocabulary {
  const char *enter_initialization, *exit_initialization, *terminate;
  const char* stop_time;   // the function that receives it
  const char* pass_event;  // the function in which discrete states change
  const char *serialize, *serialized_size;
  const char *token, *resources;  // arguments of the functions that instantiate
  const char* no_exchange;        // what precedes the reason why an FMU is not for model exchange
  const char *real, *integer, *enumeration;
};

// How an instance is seen from outside.
struct Interface {
  const Vocabulary& vocabulary;
  bool indicators_are_variables = false;  // whether event indicators can be read by value references
  bool may_return_early = false;          // whether a step that exhausts its evaluation budget returns early
};

inline constexpr Vocabulary fmi2_vocabulary{.enter_initialization = "fmi2EnterInitializationMode",
                                            .exit_initialization = "fmi2ExitInitializationMode",
                                            .terminate = "fmi2Terminate",
                                            .stop_time = "fmi2SetupExperiment",
                                            .pass_event = "fmi2NewDiscreteStates",
                                            .serialize = "fmi2SerializeFMUstate",
                                            .serialized_size = "fmi2SerializedFMUstateSize",
                                            .token = "GUID",
                                            .resources = "resource location",
                                            .no_exchange = "type: found model exchange, expected co-simulation: ",
                                            .real = "Real",
                                            .integer = "Integer",
                                            .enumeration = "Integer"};

inline constexpr Vocabulary fmi3_vocabulary{.enter_initialization = "fmi3EnterInitializationMode",
                                            .exit_initialization = "fmi3ExitInitializationMode",
                                            .terminate = "fmi3Terminate",
                                            .stop_time = "fmi3EnterInitializationMode",
                                            .pass_event = "fmi3UpdateDiscreteStates",
                                            .serialize = "fmi3SerializeFMUState",
                                            .serialized_size = "fmi3SerializedFMUStateSize",
                                            .token = "instantiation token",
                                            .resources = "resource path",
                                            .no_exchange = "this FMU is for co-simulation: ",
                                            .real = "Float64",
                                            .integer = "Int32",
                                            .enumeration = "Enumeration"};

}  // namespace gelenk
