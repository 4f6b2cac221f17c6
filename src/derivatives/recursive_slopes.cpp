// SPDX-License-Identifier: BSD-3-Clause
#include "derivatives/recursive_slopes_rows_impl.h"

namespace gelenk {

template class RecursiveSlopes<Planar>;
template class RecursiveSlopes<Spatial>;

}  // namespace gelenk
