// SPDX-License-Identifier: BSD-3-Clause
// Building blocks of the JSON Schema.
#pragma once

#include <string>

#include "scene/json_fields.h"

namespace gelenk::schema {

Json number(const std::string& unit, const std::string& description, Allowed allowed = Allowed::any);
Json list(int size, const std::string& unit, const std::string& description, Allowed allowed = Allowed::any);
Json text(const std::string& description);
Json reference(const std::string& definition);

// A mapping with these fields and no others.
Json object(const Json& fields, const std::vector<std::string>& required);

// A mapping from names to entries.
Json section(const Json& entry, const std::string& description, bool filled);

// Entries told apart by their `type`.
Json when_type(const std::string& type, const Json& then);
Json by_type(const Json& names, const Json& cases);

// An entry of the section of constraints (schema_constraints.cpp).
Json constraint();

}  // namespace gelenk::schema
