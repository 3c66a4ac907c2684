// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/growth/rigid_part.hpp"

#include <Eigen/SVD>

#include <algorithm>
#include <cmath>

namespace plumb {

Eigen::Matrix<double, 3, 9> rigid_rows(const Eigen::Vector3d& place) {
    Eigen::Matrix<double, 3, 9> rows = Eigen::Matrix<double, 3, 9>::Zero();
    rows.leftCols<3>().setIdentity();
    for (int i = 0; i < 3; ++i) rows(i, 3 + i) = place[i];
    rows(0, 7) = place.z(), rows(0, 8) = -place.y();
    rows(1, 6) = -place.z(), rows(1, 8) = place.x();
    rows(2, 6) = place.y(), rows(2, 7) = -place.x();
    return rows;
}

RigidPart rigid_part(const Eigen::MatrixX3d& places, const Eigen::MatrixX3d& deviations) {
    const Eigen::Index bores = places.rows();
    Eigen::MatrixXd design(3 * bores, 9);
    Eigen::VectorXd right(3 * bores);
    for (Eigen::Index i = 0; i < bores; ++i) {
        design.middleRows<3>(3 * i) = rigid_rows(places.row(i).transpose());
        right.segment<3>(3 * i) = deviations.row(i).transpose();
    }
    // Columns of places are as large as those of translations: the rank is a question of shape, not of units.
    RigidPart::Parameters scale = RigidPart::Parameters::Ones();
    const double size = std::max(places.cwiseAbs().maxCoeff(), 1e-12);
    scale.tail<6>().setConstant(1 / size);
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(design * scale.asDiagonal(),
                                                Eigen::ComputeFullV | Eigen::ComputeThinU);
    const Eigen::VectorXd& singular = svd.singularValues();
    RigidPart part;
    Eigen::Matrix<double, 9, 9> cofactor = Eigen::Matrix<double, 9, 9>::Zero();
    RigidPart::Parameters found = RigidPart::Parameters::Zero(), unseen = RigidPart::Parameters::Zero();
    for (Eigen::Index i = 0; i < 9; ++i) {
        const RigidPart::Parameters direction = svd.matrixV().col(i);
        if (i >= singular.size() || !(singular[i] > 1e-6 * singular[0])) {
            unseen += direction.cwiseAbs2();
            continue;
        }
        ++part.rank;
        found += direction * (svd.matrixU().col(i).dot(right) / singular[i]);
        cofactor += direction * direction.transpose() / (singular[i] * singular[i]);
    }
    part.value = scale.asDiagonal() * found;
    for (Eigen::Index i = 0; i < 9; ++i) {
        part.determined[static_cast<std::size_t>(i)] = unseen[i] < 1e-9;
        part.per_unit[i] = std::sqrt(cofactor(i, i)) * scale[i];
    }
    const Eigen::VectorXd rest = right - design * part.value;
    part.rest.resize(bores, 3);
    for (Eigen::Index i = 0; i < bores; ++i) part.rest.row(i) = rest.segment<3>(3 * i).transpose();
    const Eigen::Index freedom = 3 * bores - part.rank;
    part.rms = freedom > 0 ? std::sqrt(rest.squaredNorm() / static_cast<double>(freedom)) : 0;
    return part;
}

}  // namespace plumb
