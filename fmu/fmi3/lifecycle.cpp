// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/lifecycle.h"

#include "fmu/api_call.h"
#include "fmu/fmi3/adapter.h"

namespace gelenk {
namespace {

Log log_of(fmi3LogMessageCallback logger, fmi3InstanceEnvironment environment, const char* name, bool events) {
  const std::string instance = name != nullptr ? name : "";
  if (logger == nullptr) return {{}, instance, events};
  const auto pass = [logger, environment](const char* /*instance*/, Status status, const char* category,
                                          const std::string& text) {
    logger(environment, as_fmi3(status), category, text.c_str());
  };
  return {pass, instance, events};
}

// What co-simulation refuses of the features that importers may ask for.
std::string fault_of_features(bool uses_event_mode, std::size_t intermediate_variables) {
  if (uses_event_mode) {
    return "eventModeUsed: found true, expected false: events are passed within fmi3DoStep, and the FMU has no event "
           "mode in co-simulation (hasEventMode)";
  }
  if (intermediate_variables > 0) {
    return "requiredIntermediateVariables: found " + std::to_string(intermediate_variables) +
           ", expected none: the FMU has no intermediate updates (providesIntermediateUpdate)";
  }
  return {};
}

fmi3Instance refuse_kind(const Log& log, const char* function, const char* why) noexcept {
  try {
    log.write(Category::error, std::string(function) + ": " + why);
  } catch (...) {
    return nullptr;  // no memory for the message
  }
  return nullptr;
}

}  // namespace
}  // namespace gelenk

using gelenk::as_fmi3;
using gelenk::given;
using gelenk::Instance;
using gelenk::Mode;

extern "C" {

const char* fmi3GetVersion() { return "3.0"; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken,
                                         fmi3String resourcePath, fmi3Boolean /*visible*/, fmi3Boolean loggingOn,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference /*requiredIntermediateVariables*/[],
                                         size_t nRequiredIntermediateVariables,
                                         fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback /*intermediateUpdate*/) {
  try {
    return gelenk::instantiate(gelenk::log_of(logMessage, instanceEnvironment, instanceName, loggingOn),
                               {.function = "fmi3InstantiateCoSimulation",
                                .interface = {gelenk::fmi3_vocabulary, true, earlyReturnAllowed},
                                .kind = gelenk::Plant::Kind::co_simulation,
                                .token = instantiationToken,
                                .resources = resourcePath,
                                .fault = gelenk::fault_of_features(eventModeUsed, nRequiredIntermediateVariables)});
  } catch (...) {  // no memory
    return nullptr;
  }
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean /*visible*/, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage) {
  try {
    return gelenk::instantiate(gelenk::log_of(logMessage, instanceEnvironment, instanceName, loggingOn),
                               {.function = "fmi3InstantiateModelExchange",
                                .interface = {gelenk::fmi3_vocabulary, true},
                                .kind = gelenk::Plant::Kind::model_exchange,
                                .token = instantiationToken,
                                .resources = resourcePath});
  } catch (...) {  // no memory
    return nullptr;
  }
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String /*instantiationToken*/,
                                               fmi3String /*resourcePath*/, fmi3Boolean /*visible*/,
                                               fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment,
                                               fmi3LogMessageCallback logMessage,
                                               fmi3ClockUpdateCallback /*clockUpdate*/,
                                               fmi3LockPreemptionCallback /*lockPreemption*/,
                                               fmi3UnlockPreemptionCallback /*unlockPreemption*/) {
  try {
    return gelenk::refuse_kind(gelenk::log_of(logMessage, instanceEnvironment, instanceName, loggingOn),
                               "fmi3InstantiateScheduledExecution",
                               "this FMU has no clocks, whose partitions could be scheduled");
  } catch (...) {  // no memory
    return nullptr;
  }
}

void fmi3FreeInstance(fmi3Instance instance) { gelenk::free_instance(instance); }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[]) {
  return as_fmi3(gelenk::set_debug_logging(instance, "fmi3SetDebugLogging", loggingOn, nCategories, categories));
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime) {
  const gelenk::ExperimentSetup experiment{
      .tolerance = given(toleranceDefined, tolerance), .start = startTime, .stop = given(stopTimeDefined, stopTime)};
  return as_fmi3(gelenk::enter_initialization(instance, "fmi3EnterInitializationMode", &experiment));
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
  return as_fmi3(gelenk::exit_initialization(instance, "fmi3ExitInitializationMode"));
}

fmi3Status fmi3Terminate(fmi3Instance instance) { return as_fmi3(gelenk::terminate(instance, "fmi3Terminate")); }

fmi3Status fmi3Reset(fmi3Instance instance) { return as_fmi3(gelenk::reset(instance, "fmi3Reset")); }

// The FMU has no structural parameters, so that there is nothing to do in configuration mode.
fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance) {
  return as_fmi3(gelenk::call(instance, "fmi3EnterConfigurationMode", 0U | Mode::instantiated, [](Instance& of) {
    of.configure(true);
    return gelenk::Status::ok;
  }));
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance) {
  return as_fmi3(gelenk::call(instance, "fmi3ExitConfigurationMode", 0U | Mode::configuration, [](Instance& of) {
    of.configure(false);
    return gelenk::Status::ok;
  }));
}

}  // extern "C"
