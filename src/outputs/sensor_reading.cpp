// SPDX-License-Identifier: BSD-3-Clause
#include "outputs/sensor_reading.h"

#include "element/sensors/registry.h"
#include "outputs/port_readings.h"

namespace gelenk {
namespace {

// Owns all that it needs, since loads outlive the reduced scene of which they were made.
class SensorReading final : public NamedReading {
 public:
  SensorReading(const Scene& scene, const ReducedScene& reduced, const Sensor& sensor, int group, int component)
      : is_(sensor.is), places_(scene, reduced, sensor, false), group_(group), component_(component) {
    if (places_.island < 0) return;
    const Mechanism& mechanism = reduced.islands[static_cast<std::size_t>(places_.island)];
    X_W0_ = mechanism.X_W0;
    for (const BodyPlace& at : places_.frames)
      links_.push_back(at.rod < 0 ? at.link : mechanism.cuts[static_cast<std::size_t>(at.rod)].link_a);
  }

  double read(const Readings<double>& at) const override { return read_as(at); }
  Dual read(const Readings<Dual>& at) const override { return read_as(at); }
  Series read(const Readings<Series>& at) const override { return read_as(at); }
  void mark_links(std::vector<bool>& marked) const override {
    for (const int link : links_) marked[static_cast<std::size_t>(link)] = true;
  }

 private:
  template <class T>
  T read_as(const Readings<T>& at) const {
    const SeenPorts<T> seen(places_, X_W0_, places_.island < 0 ? nullptr : &at);
    return std::visit(
        [&](const auto& sensor) -> T {
          if constexpr (OfWhole<std::decay_t<decltype(sensor)>>)
            return T(0);
          else
            return sensor.output(seen, group_, component_);
        },
        *is_);
  }

  Stored<AnySensor> is_;
  PortPlaces places_;
  Pose3 X_W0_;
  std::vector<int> links_;
  int group_, component_;
};

}  // namespace

std::shared_ptr<const NamedReading> sensor_reading(const Scene& scene, const ReducedScene& reduced,
                                                   const Sensor& sensor, int group, int component) {
  return std::make_shared<SensorReading>(scene, reduced, sensor, group, component);
}

}  // namespace gelenk
