// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <Eigen/Core>

#include <vector>

namespace plumb {

// Coefficients of a linear law, from visits of several bores:
//
//     y = A w + c_g + noise
//
// with a constant c_g for each group g, which is a bore at one orientation; it is not wanted. Of w_j is known
// beforehand that it is about 0 by w0_j (A. E. Hoerl and R. W. Kennard, Technometrics 12, 1970). What a law
// leaves of slow growth lasts for half an hour and longer, so visits that follow each other closely are one
// observation: `weight` is the number of observations that a visit counts for, at most 1.
struct GrowthVisits {
    Eigen::MatrixXd terms;   // A, a row for each visit, in the order of time
    Eigen::VectorXd growth;  // y, mu
    Eigen::VectorXd weight;
    std::vector<int> groups;  // g of each visit
    std::vector<int> duties;  // of each visit
};

struct IdentifiedGrowth {
    Eigen::VectorXd value;       // w
    Eigen::MatrixXd covariance;  // of w
    double drift = 0;            // mu, rms of y about the constants of the groups
    double rest = 0;             // mu, rms of what the law leaves of it
    double predicted_rest = 0;   // mu, the same of duties that were left out; infinite if there is but one
    // That rest, as of an error that is always there, mu, and one that is a part of each term.
    double floor = 0, share = 0;
};

// `usual` is w0, above 0, one for each column; `sigma` in mu the least standard deviation of an observation.
// Each duty in turn is left out and predicted by the law of the others.
IdentifiedGrowth identified_growth(const GrowthVisits& visits, const Eigen::VectorXd& usual, double sigma);

}  // namespace plumb
