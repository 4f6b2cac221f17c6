// SPDX-License-Identifier: BSD-3-Clause
// Model exchange, where the importer integrates. Each function is one of FMI, in all versions, whose name is given for
// messages.
#pragma once

#include <cstddef>
#include <initializer_list>

#include "fmu/place.h"
#include "fmu/status.h"
#include "simulation/model_exchange.h"

namespace gelenk {

Status enter_event_mode(void* instance, const char* function) noexcept;
// No other event follows at the same time: what one causes is part of it.
Status pass_event(void* instance, const char* function, std::initializer_list<Place> results,
                  ModelExchange::Event& event) noexcept;
Status enter_continuous_time_mode(void* instance, const char* function) noexcept;
// has_event: whether event mode must be entered.
Status complete_step(void* instance, const char* function, std::initializer_list<Place> results,
                     bool& has_event) noexcept;
Status set_time(void* instance, const char* function, double time) noexcept;
Status set_states(void* instance, const char* function, const double* states, std::size_t count) noexcept;
Status get_states(void* instance, const char* function, double* states, std::size_t count) noexcept;
Status get_rates(void* instance, const char* function, double* rates, std::size_t count) noexcept;
Status get_nominals(void* instance, const char* function, double* nominals, std::size_t count) noexcept;
Status get_number_of_states(void* instance, const char* function, std::size_t* count) noexcept;
Status get_number_of_indicators(void* instance, const char* function, std::size_t* count) noexcept;
Status get_event_indicators(void* instance, const char* function, double* indicators, std::size_t count) noexcept;

}  // namespace gelenk
