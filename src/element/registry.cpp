// SPDX-License-Identifier: BSD-3-Clause
#include "element/registry.h"

#include <array>

#include "util/stored_impl.h"

namespace gelenk {
namespace {

template <class E>
constexpr bool reads_reaction = false;
template <ReadsReaction E>
constexpr bool reads_reaction<E> = true;
template <class E>
constexpr bool reads_acceleration = false;
template <ReadsAcceleration E>
constexpr bool reads_acceleration<E> = true;
template <class E>
constexpr bool reads_gravity = false;
template <ReadsGravity E>
constexpr bool reads_gravity<E> = true;
template <class E>
constexpr bool of_whole = false;
template <OfWhole E>
constexpr bool of_whole<E> = true;

template <class E>
std::span<const SignalGroup> own_outputs() {
  if constexpr (requires { E::outputs; }) return E::outputs;
  return {};
}

template <class E>
ElementKind describe() {
  ElementKind out{
      .kind = E::kind, .summary = E::summary, .ports = E::ports, .fields = E::fields(), .outputs = own_outputs<E>()};
  out.reads_reaction = reads_reaction<E>;
  out.reads_acceleration = reads_acceleration<E>;
  out.reads_gravity = reads_gravity<E>;
  out.of_whole = of_whole<E>;
  out.is_between_bodies = BodyConstraint<E>;
  return out;
}

template <class... E>
std::span<const ElementKind> describe_all(const std::variant<E...>*) {
  static const std::array<ElementKind, sizeof...(E)> kinds = {describe<E>()...};
  return kinds;
}

template <class Any, class... E>
Any make_nth(std::size_t n, const std::variant<E...>*) {
  using MakeElement = Any (*)();
  static constexpr std::array<MakeElement, sizeof...(E)> makers = {[] { return Any(E()); }...};
  return makers.at(n)();
}

template <class E>
std::optional<ElementFault> own_fault(const E& element, const Coordinate& coordinate) {
  if constexpr (requires { element.fault(coordinate); }) return element.fault(coordinate);
  return {};
}

// Access to element k of JointForces, which is always present or optional.
template <std::size_t k, class E>
struct JointForceAccess {
  using Element = E;
  static void* find(JointForces& forces) { return &std::get<k>(forces); }
  static void emplace(JointForces&) {}
  static void erase(JointForces& forces) { std::get<k>(forces) = {}; }
};
template <std::size_t k, class E>
struct JointForceAccess<k, std::optional<E>> {
  using Element = E;
  static void* find(JointForces& forces) { return std::get<k>(forces) ? &*std::get<k>(forces) : nullptr; }
  static void emplace(JointForces& forces) { std::get<k>(forces).emplace(); }
  static void erase(JointForces& forces) { std::get<k>(forces).reset(); }
};

template <std::size_t k>
JointForceKind describe_joint_force() {
  using Access = JointForceAccess<k, std::tuple_element_t<k, JointForces::tuple>>;
  using Element = typename Access::Element;
  return {.group = Element::group,
          .summary = Element::summary,
          .misfit = Element::misfit,
          .fields = Element::fields(),
          .outputs = own_outputs<Element>(),
          .fits = Element::fits,
          .of_joint = requires { Element::holds_joint; },
          .find = Access::find,
          .defaults = []() -> const void* {
            static const Element plain;
            return &plain;
          },
          .emplace = Access::emplace,
          .erase = Access::erase,
          .inputs = [](const void* element) { return own_inputs(*static_cast<const Element*>(element)); },
          .fault = [](const void* element, const Coordinate& coordinate) -> std::optional<ElementFault> {
            return own_fault(*static_cast<const Element*>(element), coordinate);
          },
          .doubt = [](const void* element, double q, const Coordinate& coordinate) -> std::optional<ElementFault> {
            if constexpr (requires(const Element & e) { e.doubt(q, coordinate); }) {
              return static_cast<const Element*>(element)->doubt(q, coordinate);
            }
            return {};
          }};
}

template <std::size_t... k>
std::span<const JointForceKind> describe_joint_forces(std::index_sequence<k...>) {
  static const std::array<JointForceKind, sizeof...(k)> kinds = {describe_joint_force<k>()...};
  return kinds;
}

template <class E>
bool acts(const E& element) {
  if constexpr (requires { element.has_value(); }) {
    return element.has_value();
  } else {
    return !element.is_idle();
  }
}

}  // namespace

template <class Any>
std::span<const ElementKind> element_kinds() {
  return describe_all(static_cast<const Any*>(nullptr));
}
template <class Any>
Stored<Any> make_element(std::size_t n) {
  return make_nth<Any>(n, static_cast<const Any*>(nullptr));
}
template <class Any>
const ElementKind& kind_of(const Any& element) {
  return element_kinds<Any>()[element.index()];
}
template <class Any>
void* data_of(Any& element) {
  return std::visit([](auto& e) -> void* { return &e; }, element);
}
template <class Any>
const void* data_of(const Any& element) {
  return std::visit([](const auto& e) -> const void* { return &e; }, element);
}
template <class Any>
std::span<const SignalGroup> inputs_of(const Any& element) {
  return std::visit([](const auto& e) { return own_inputs(e); }, element);
}
template <class Any>
std::optional<ElementFault> fault_of(const Any& element, const Coordinate& coordinate) {
  return std::visit([&](const auto& e) { return own_fault(e, coordinate); }, element);
}

template <class Any>
std::optional<ElementFault> doubt_of(const Any& element) {
  return std::visit(
      [](const auto& e) -> std::optional<ElementFault> {
        if constexpr (requires { e.doubt(); }) return e.doubt();
        return {};
      },
      element);
}

const Motion* find_motion(const AnyConstraint& constraint) {
  return std::get_if<Motion>(static_cast<const AnyConstraint::variant*>(&constraint));
}

bool holds_positions(const AnyConstraint& constraint) {
  return std::visit(
      [](const auto& c) {
        if constexpr (BodyConstraint<std::decay_t<decltype(c)>>) return false;
        if constexpr (requires { c.holds_position(); }) return c.holds_position();
        return true;
      },
      constraint);
}

bool includes_joined(const AnyContact& contact) {
  return std::visit([](const auto& c) { return c.adjacent; }, contact);
}

ContactLaw law_of(const AnyContact& contact) {
  return std::visit([](const auto& c) { return c.law(); }, contact);
}

namespace {

template <class Any>
double added_inertia(const Any& element) {
  return std::visit(
      [](const auto& e) -> double {
        if constexpr (requires { e.inertia(); }) return e.inertia();
        return 0;
      },
      element);
}

}  // namespace

double inertia_of(const AnyMotor& motor) { return added_inertia(motor); }
double inertia_of(const AnyComponent& component) { return added_inertia(component); }

Stored<AnySensor> sensor_of_length() { return AnySensor(Distance()); }
Stored<AnyForce> force_along_line() { return AnyForce(LineForce()); }

ComponentEquations equations_of(const AnyComponent& component) {
  ComponentEquations out;
  std::visit([&](const auto& c) { c.describe(out); }, component);
  return out;
}

std::span<const JointForceKind> joint_force_kinds() {
  return describe_joint_forces(std::make_index_sequence<std::tuple_size_v<JointForces::tuple>>());
}

const void* JointForceKind::in(const JointForces& forces) const {
  return find(const_cast<JointForces&>(forces));  // NOLINT(*-const-cast): only an address is computed
}

bool is_idle(const JointForces& forces) {
  return std::apply([](const auto&... force) { return !(acts(force) || ...); }, forces.all());
}

// NOLINTBEGIN(bugprone-macro-parentheses): names of types
#define GELENK_SECTION(Any)                                                     \
  template std::span<const ElementKind> element_kinds<Any>();                   \
  template Stored<Any> make_element<Any>(std::size_t);                          \
  template const ElementKind& kind_of(const Any&);                              \
  template void* data_of(Any&);                                                 \
  template const void* data_of(const Any&);                                     \
  template class Stored<Any>;                                                   \
  template std::span<const SignalGroup> inputs_of(const Any&);                  \
  template std::optional<ElementFault> fault_of(const Any&, const Coordinate&); \
  template std::optional<ElementFault> doubt_of(const Any&);
// NOLINTEND(bugprone-macro-parentheses)

GELENK_SECTION(AnyMotor)
GELENK_SECTION(AnyForce)
GELENK_SECTION(AnyConstraint)
GELENK_SECTION(AnyContact)
GELENK_SECTION(AnySensor)
GELENK_SECTION(AnyComponent)
#undef GELENK_SECTION
template class Stored<JointForces>;

}  // namespace gelenk
