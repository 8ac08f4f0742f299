#include "pipeline/build/cloud_spread.h"

#include <algorithm>
#include <cstddef>

namespace slim {
namespace {

constexpr std::size_t kSampled = 4096;  // points that tell strays from the others, at most

}  // namespace

bool PointMoments::are_of_a_line() const {
    const auto moment = [&](double ab, double a, double b) { return ab / n_ - a / n_ * (b / n_); };
    const double xx = moment(xx_, x_, x_), yy = moment(yy_, y_, y_), zz = moment(zz_, z_, z_);
    const double xy = moment(xy_, x_, y_), xz = moment(xz_, x_, z_), yz = moment(yz_, y_, z_);
    // Of the eigenvalues the sum, and the sum of the products of two: about the middle one over the
    // largest.
    const double sum = xx + yy + zz;
    const double pairs = xx * yy + yy * zz + zz * xx - xy * xy - xz * xz - yz * yz;
    return sum > 0 && pairs < 1e-12 * sum * sum;
}

void CloudSpread::keep(const Vec3d& p) {
    sample_.push_back(p);
    if (sample_.size() < kSampled) return;
    for (std::size_t i = 0; 2 * i < sample_.size(); ++i) sample_[i] = sample_[2 * i];
    sample_.resize(sample_.size() / 2);
    step_ *= 2;
}

/// The sample without the tenth that is farthest from its middle; of few points strays may be more
/// than that.
bool CloudSpread::middle_is_line() const {
    Vec3d middle;
    std::vector<double> values(sample_.size());
    const auto nth = [&](double share) {
        const auto at = values.begin() +
                        static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
        std::nth_element(values.begin(), at, values.end());
        return *at;
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = sample_[i][axis];
        middle[axis] = nth(0.5);
    }
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = length(sample_[i] - middle);
    const double most = nth(0.9);
    PointMoments near;
    for (const Vec3d& p : sample_)
        if (length(p - middle) <= most) near.add(p);
    return near.are_of_a_line();
}

}  // namespace slim
