// SPDX-License-Identifier: BSD-3-Clause
#include "fmu/lifecycle.h"

#include "fmu/api_call.h"
#include "fmu/fmi2/adapter.h"

namespace gelenk {
namespace {

// The text as a printf format, as which loggers interpret messages.
std::string as_format(const std::string& text) {
  std::string out;
  for (const char c : text) out.append(c == '%' ? 2 : 1, c);
  return out;
}

// callbacks may be null, and so may its logger: then nothing is logged.
Log log_of(const fmi2CallbackFunctions* callbacks, const char* name, bool events) {
  const std::string instance = name != nullptr ? name : "";
  if (callbacks == nullptr || callbacks->logger == nullptr) return {{}, instance, events};
  const auto pass = [logger = callbacks->logger, environment = callbacks->componentEnvironment](
                        const char* of, Status status, const char* category, const std::string& text) {
    logger(environment, of, as_fmi2(status), category, as_format(text).c_str());
  };
  return {pass, instance, events};
}

std::string fault_of_type(int type) {
  if (type == fmi2CoSimulation || type == fmi2ModelExchange) return {};
  return "type: found " + std::to_string(type) + ", expected fmi2ModelExchange (0) or fmi2CoSimulation (1)";
}

}  // namespace
}  // namespace gelenk

using gelenk::as_fmi2;
using gelenk::given;
using gelenk::is_true;

extern "C" {

const char* fmi2GetTypesPlatform() { return fmi2TypesPlatform; }

const char* fmi2GetVersion() { return "2.0"; }

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions* functions,
                              fmi2Boolean /*visible*/, fmi2Boolean loggingOn) {
  using Kind = gelenk::Plant::Kind;
  const int type = gelenk::number_of(fmuType);
  try {
    return gelenk::instantiate(gelenk::log_of(functions, instanceName, is_true(loggingOn)),
                               {.function = "fmi2Instantiate",
                                .interface = {gelenk::fmi2_vocabulary},
                                .kind = type == fmi2ModelExchange ? Kind::model_exchange : Kind::co_simulation,
                                .token = fmuGUID,
                                .resources = fmuResourceLocation,
                                .fault = gelenk::fault_of_type(type)});
  } catch (...) {  // no memory
    return nullptr;
  }
}

void fmi2FreeInstance(fmi2Component c) { gelenk::free_instance(c); }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[]) {
  return as_fmi2(gelenk::set_debug_logging(c, "fmi2SetDebugLogging", is_true(loggingOn), nCategories, categories));
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime) {
  const gelenk::ExperimentSetup experiment{.tolerance = given(is_true(toleranceDefined), tolerance),
                                           .start = startTime,
                                           .stop = given(is_true(stopTimeDefined), stopTime)};
  return as_fmi2(gelenk::setup_experiment(c, "fmi2SetupExperiment", experiment));
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  return as_fmi2(gelenk::enter_initialization(c, "fmi2EnterInitializationMode", nullptr));
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  return as_fmi2(gelenk::exit_initialization(c, "fmi2ExitInitializationMode"));
}

fmi2Status fmi2Terminate(fmi2Component c) { return as_fmi2(gelenk::terminate(c, "fmi2Terminate")); }

fmi2Status fmi2Reset(fmi2Component c) { return as_fmi2(gelenk::reset(c, "fmi2Reset")); }

}  // extern "C"
