// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <boost/math/distributions/students_t.hpp>

namespace plumb {

// The factor by which a standard uncertainty of this many degrees of freedom, above 0, covers 95.45 of 100: 2
// for many (Student's t).
inline double coverage_factor(double freedom) {
    return quantile(boost::math::students_t(freedom), (1 + 0.954499736104) / 2);
}

}  // namespace plumb
