// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>

#include <vector>

namespace plumb {

// Coefficients of a linear law, found from visits of several bores in several passes:
//
//     y = A w + c_g + noise
//
// with a constant c_g for each group g, which is a bore at one orientation; it is not wanted. The square of
// w_j counts with the weight (sigma / w0_j)^2, w0_j being the size of a large coefficient: what the visits do
// not determine stays small (A. E. Hoerl and R. W. Kennard, Technometrics 12, 1970).
struct GrowthVisits {
    Eigen::MatrixXd terms;    // A, a row for each visit
    Eigen::VectorXd growth;   // y, mu
    std::vector<int> groups;  // g of each visit
    std::vector<int> passes;  // of each visit
};

struct IdentifiedGrowth {
    Eigen::VectorXd value;      // w
    double drift = 0;           // mu, rms of y about the constants of the groups
    double rest = 0;            // mu, rms of what the law leaves of it
    double predicted_rest = 0;  // mu, the same of passes that were left out; infinite if there were none
};

// `large` is w0, above 0, one for each column; `sigma` in mu that of a visit. The rest of passes that were
// left out is that of each pass but the first: the law is found from the others, and has to explain how the
// bores have moved since the first pass.
IdentifiedGrowth identified_growth(const GrowthVisits& visits, const Eigen::VectorXd& large, double sigma);

}  // namespace plumb
