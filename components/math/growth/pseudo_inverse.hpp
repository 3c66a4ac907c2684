// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>

namespace plumb {

// The Moore-Penrose inverse of m (rows x columns), columns x rows: times the right side it gives the shortest
// of all solutions of least squares, also where the columns depend on each other. Allocates; not for
// update().
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& m);

}  // namespace plumb
