// SPDX-License-Identifier: BSD-3-Clause
// The reader of FMU states: words of any kind behind a head and a checksum that are right. Such a state is refused or
// taken; either way the calls come back, and the instance can go back to a state of its own and gives that state's run.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fmi2Functions.h"
#include "fmu/instance.h"
#include "fmu/saved_state.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

using namespace gelenk;

// Plants: scenes in this folder with their integrators; tests/fuzz/states.py reads this list. four_bar is a loop with a
// spring and a damper, rubbing has dry friction and limits, touching has contacts; all have a motor named drive.
constexpr std::array plants = {"four_bar/auto",       "four_bar/rk4",  "four_bar/ida",
                               "four_bar/cvode",      "four_bar/dirk", "four_bar/generalized-alpha",
                               "rubbing/auto",        "rubbing/rk4",   "rubbing/ida",
                               "touching/moreau-jean"};
constexpr double size_of_step = 1e-3;  // s

std::string scene(std::string_view plant) {
  const std::size_t slash = plant.find('/');
  std::ifstream file(FUZZED_SCENES "/" + std::string(plant.substr(0, slash)) + ".json");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::string given = "\"auto\"";
  return text.replace(text.find(given), given.size(), '"' + std::string(plant.substr(slash + 1)) + '"');
}

void demand(bool holds, const char* what) {
  if (holds) return;
  std::cerr << what << '\n';
  std::abort();
}

// An instance that has made some steps, with a state of its own to go back to and the outputs of the step after it.
struct Host {
  explicit Host(std::string_view plant)
      : model(std::make_shared<const PlantModel>(scene(plant), "fuzzed.json")),
        instance(model, Log({}, "plant", false), Plant::Kind::co_simulation, Interface{fmi2_vocabulary}) {
    for (int i = 0; i < static_cast<int>(model->catalog.variables().size()); ++i) {
      if (model->catalog.variables()[i].source == Source::output) outputs.push_back(i);
    }
    const double torque = 0.5;
    const auto input = std::ranges::find(model->catalog.variables(), Source::input, &Variable::source);
    const auto reference = static_cast<fmi2ValueReference>(input - model->catalog.variables().begin());
    bool fine = fmi2SetupExperiment(&instance, fmi2False, 0, 0, fmi2False, 0) == fmi2OK;
    fine = fine && fmi2EnterInitializationMode(&instance) == fmi2OK;
    fine = fine && fmi2SetReal(&instance, &reference, 1, &torque) == fmi2OK;
    fine = fine && fmi2ExitInitializationMode(&instance) == fmi2OK;
    for (int k = 0; k < 5; ++k) fine = fine && step() == fmi2OK;
    demand(fine && fmi2GetFMUstate(&instance, &home) == fmi2OK, "no run to begin with");
    expected = go_home();
  }

  fmi2Status step() { return fmi2DoStep(&instance, instance.plant().time(), size_of_step, fmi2False); }

  std::vector<double> go_home() {
    demand(fmi2SetFMUstate(&instance, home) == fmi2OK, "its own state is refused");
    demand(step() == fmi2OK, "the step after its own state fails");
    std::vector<double> values;
    for (const int i : outputs) values.push_back(instance.plant().get(i));
    return values;
  }

  std::shared_ptr<const PlantModel> model;
  Instance instance;
  std::vector<int> outputs;
  fmi2FMUstate home = nullptr;
  std::vector<double> expected;
};

Host& host_of(std::uint8_t which) {
  static std::array<std::unique_ptr<Host>, plants.size()> hosts;
  std::unique_ptr<Host>& host = hosts[which % plants.size()];
  if (!host) host = std::make_unique<Host>(plants[which % plants.size()]);
  return *host;
}

}  // namespace

// First byte: the host; the others: words of the record.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  Host& host = host_of(data[0]);
  const char* rest = reinterpret_cast<const char*>(data) + 1;
  fmi2FMUstate state = nullptr;
  if (fmi2DeSerializeFMUstate(&host.instance, rest, size - 1, &state) == fmi2OK) {  // a whole one, by chance
    fmi2FreeFMUstate(&host.instance, &state);
  }
  std::vector<std::uint64_t> words((size - 1) / sizeof(std::uint64_t));
  if (!words.empty()) std::memcpy(words.data(), rest, words.size() * sizeof(std::uint64_t));
  const SavedState given{Archive(std::move(words)), false};
  std::vector<char> bytes(serialized_size(given));
  serialize(given, host.model->guid, bytes);
  demand(fmi2DeSerializeFMUstate(&host.instance, bytes.data(), bytes.size(), &state) == fmi2OK,
         "a right head is refused");
  if (fmi2SetFMUstate(&host.instance, state) == fmi2OK) {
    for (int k = 0; k < 2; ++k) host.step();
    for (const int i : host.outputs) {
      const auto reference = static_cast<fmi2ValueReference>(i);
      double value = 0;
      fmi2GetReal(&host.instance, &reference, 1, &value);
    }
  }
  fmi2FreeFMUstate(&host.instance, &state);
  const std::vector<double> found = host.go_home();
  const auto same = [](double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
  };
  demand(std::ranges::equal(found, host.expected, same), "another run after a state from outside");
  return 0;
}

// Nearly all words of chance are refused by the first few: many an input begins as a state that is one.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned seed) {
  if (size < 16 || seed % 16 == 0) {
    Host& host = host_of(static_cast<std::uint8_t>(seed / 16));
    const std::span<const std::uint64_t> words = static_cast<SavedState*>(host.home)->archive.words();
    const std::size_t length = words.size() * sizeof(std::uint64_t);
    if (length + 1 > max_size) return LLVMFuzzerMutate(data, size, max_size);
    data[0] = static_cast<std::uint8_t>(seed / 16);
    std::memcpy(data + 1, words.data(), length);
    size = length + 1;
  }
  return LLVMFuzzerMutate(data, size, max_size);
}
