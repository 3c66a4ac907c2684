// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/coverage_factor.hpp"

#include <boost/math/distributions/students_t.hpp>

namespace plumb {

double coverage_factor(double freedom) {
    return quantile(boost::math::students_t(freedom), (1 + 0.954499736104) / 2);
}

}  // namespace plumb
