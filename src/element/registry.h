// SPDX-License-Identifier: BSD-3-Clause
// The lists of all sections.
#pragma once

#include "element/components/registry.h"
#include "element/constraints/registry.h"
#include "element/contacts/registry.h"
#include "element/forces/registry.h"
#include "element/joint_forces/registry.h"
#include "element/kinds.h"
#include "element/motors/registry.h"
#include "element/sensors/registry.h"
