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
    std::vector<int> groups;  // g of each visit; a bore on another day is another group
    std::vector<int> blocks;  // of each visit: contiguous, rising with time
    std::vector<int> days;    // of each visit: rising with time
};

struct IdentifiedGrowth {
    Eigen::VectorXd value;       // w
    Eigen::MatrixXd covariance;  // of w
    double drift = 0;            // mu, rms of y about the constants of the groups
    double rest = 0;             // mu, rms of the error of the law about them

    // Forward in time: each block from the third on is predicted by the law of the blocks before it, and each
    // day from the second on by the law of the days before it. y and A w count from the first visit of a
    // group, as growth counts from a work zero.
    std::vector<double> block_rests;  // mu, rms of y - A w by block
    double predicted_rest = 0;        // mu, rms of all blocks; infinite if there are too few
    double scale = 0;                 // standard uncertainty of the size of A w, 0.35 at least with one day
};

// `usual` is w0, above 0, one for each column; `sigma` in mu the least standard deviation of an observation.
IdentifiedGrowth identified_growth(const GrowthVisits& visits, const Eigen::VectorXd& usual, double sigma);

}  // namespace plumb
