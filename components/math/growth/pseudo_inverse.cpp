// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/pseudo_inverse.hpp"

#include <Eigen/QR>

namespace plumb {

Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& m) {
    return m.completeOrthogonalDecomposition().pseudoInverse();
}

}  // namespace plumb
