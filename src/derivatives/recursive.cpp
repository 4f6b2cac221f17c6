// SPDX-License-Identifier: BSD-3-Clause
#include "derivatives/recursive_constraints_impl.h"

namespace gelenk {

template class RecursiveJacobians<Planar>;
template class RecursiveJacobians<Spatial>;

}  // namespace gelenk
