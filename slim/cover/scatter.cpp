#include "slim/cover/scatter.h"

#include "slim/model/surfel_tree.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace slim {
namespace {

constexpr std::uint32_t kMany = 15;
constexpr double kThickOfSparse = 0.03;  // noise is small against so large a leaf
constexpr double kNarrowOfFew = 0.06;
constexpr double kNarrow = 0.2;  // breadth of a leaf whose points are a line (0.5 on a surface)
constexpr double kWire = 0.06;  // the same of a wire's
constexpr std::uint32_t kFewOfWire = 8;  // fewer points may lie on a line by chance
constexpr double kThick = 0.15;  // eps / rho of one whose points fill a volume (0.25 at random)
// eps / rho of points at random, which no energy makes a surface
constexpr double kThickest = 0.25;
constexpr double kClump = 0.9;  // share of the points within half of the radius (0.25 on a surface)
constexpr std::uint32_t kFewOfThick = 60;
constexpr double kThickOfDoubtful = 0.12;
// A ball with two sheets in it, where scans disagree, up to the points and down to the noise it may
// hold.
constexpr double kTwoSheets = 0.2;
constexpr std::uint32_t kFewOfTwoSheets = 200;
constexpr double kNoisyTwoSheets = 0.04;
// sqrt(lambda) / rho, below it a few points are a detail; of the usual finest ball it is 0.10 and
// 0.27 on bunny_raw and happy_stand_raw, 0.02 to 0.03 on clean meshes, 0.06 on autzen_stadium.
constexpr double kNoisy = 0.07;
constexpr std::size_t kFewOfGap = 8;  // points that a leaf in a gap covers:
                                      // fewer do not fill its ball
constexpr double kBeyondLast = 1.15;  // times the farthest of them: so far their leaf reaches
constexpr double kLeastOfGap = 0.1;

}  // namespace

bool is_scatter(const CoveringSurfel& leaf, bool forced, bool sparse, bool clean) {
    const FittedSurfel& f = leaf.fitted;
    if (f.n_points <= kFewest) return false;
    // A few points of a surface may look like a line; where the energy chose, a thick leaf is one
    // of noise.
    const double narrow = f.n_points > kMany ? kNarrow : kNarrowOfFew;
    const bool is_thick = is_thicker(leaf, forced, sparse, clean, 1);
    // strays' normals agree on nothing
    const bool is_torn = sparse && 2 * leaf.n_aside > f.n_points;
    // A scan line on a surface is a line too, but its normals agree; those about a pole do not.
    const bool is_line = leaf.breadth < narrow && 5 * leaf.n_aside > f.n_points;
    // In the air a clump has no more points in a larger ball, and the larger is the cheaper.
    const bool is_clump = f.n_points > kMany && leaf.middle > kClump;
    return is_line || is_thick || is_torn || is_clump;
}

bool is_wire(const CoveringSurfel& leaf) {
    return leaf.fitted.n_points >= kFewOfWire && leaf.breadth < kWire;
}

bool is_too_large_on_wire(const CoveringSurfel& leaf) {
    return leaf.on_wire && leaf.fitted.n_points > kMany;
}

bool is_thicker(const CoveringSurfel& leaf, bool forced, bool sparse, bool clean, double factor) {
    const double thick = sparse ? kThickOfSparse : kThick;
    const double error = leaf.fitted.fit_error, rho = factor * leaf.fitted.surfel.support_radius;
    return ((forced || sparse) && error > thick * rho) || (clean && error > kThickest * rho);
}

double share_of_few(const CoveringSurfel& leaf) {
    if (leaf.covered.size() < 2 || leaf.covered.size() >= kFewOfGap) return 1;
    double farthest = 0;
    for (const Covered& p : leaf.covered)
        farthest =
            std::max(farthest, std::hypot(static_cast<double>(p.u), static_cast<double>(p.v)));
    return std::clamp(kBeyondLast * farthest, kLeastOfGap, 1.0);
}

bool is_doubtful(const FittedSurfel& leaf, double noise_variance) {
    const double rho = leaf.surfel.support_radius, noise = std::sqrt(noise_variance);
    if (leaf.n_points <= kFewOfTwoSheets && leaf.fit_error > kTwoSheets * rho)
        return noise > kNoisyTwoSheets * rho;
    if ((leaf.flags & kForced) && are_few_in_noise(leaf.n_points, rho, noise_variance)) return true;
    return noise > kNoisy * rho && leaf.n_points <= kFewOfThick &&
           leaf.fit_error > kThickOfDoubtful * rho;
}

bool are_few_in_noise(std::size_t n_points, double radius, double noise_variance) {
    return n_points <= kFewOfForced && std::sqrt(noise_variance) > kNoisy * radius;
}

}  // namespace slim
