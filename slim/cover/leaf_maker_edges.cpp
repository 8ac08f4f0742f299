// Edges: whether they are looked for, and leaves at them.

#include "slim/blend/blend.h"
#include "slim/cover/leaf_maker.h"
#include "slim/cover/leaf_rim.h"
#include "slim/cover/scatter.h"
#include "slim/fit/sharp_clusters.h"

#include <cmath>
#include <utility>

namespace slim {
namespace {

// eps / rho of a smooth leaf that rounds a real edge or corner off
constexpr double kRoundsOff = 0.055;
// sqrt(typical noise) over the usual finest ball: from it on noise is as thick
constexpr double kThinNoise = 0.015;
constexpr double kFlat = 0.01;        // eps / rho of a plane that bends nowhere
constexpr double kOwnNormals = 0.999; // mean cosine of its points' normals to its own
// sqrt(lambda) over the usual finest ball: from it on normals feign edges
constexpr double kNoisy = 0.08;

/// Whether the normals of the points about a leaf that are no edge's are its own: estimated ones
/// turn towards an edge.
bool has_own_normals(const FittedSurfel& leaf, const BallPoints<double>& ball) {
    double sum = 0, n = 0;
    for (std::size_t i = 0; i < ball.n; ++i) {
        const double along =
            dot(leaf.surfel.frame.normal, Vec3d{ball.nx[i], ball.ny[i], ball.nz[i]});
        if (along > kSharpGate) sum += along, ++n;
    }
    return sum > kOwnNormals * n;
}

}  // namespace

/// Whether the cloud has neither contrary normals nor much noise.
bool LeafMaker::is_clean() const {
    const bool is_noisy = std::sqrt(rules_.noise_variance) > kNoisy * kFinestBall * spacing_;
    return rules_.ladder.contrary_share < kCleanNormals && !is_noisy;
}

Edges LeafMaker::edges() const {
    if (!rules_.sharp) return Edges::ignored;
    return is_clean() ? Edges::real : Edges::doubtful;
}

/// Whether edges are looked for in a cloud whose noise is more than a share of the spacing.
bool LeafMaker::are_edges_in_noise() const {
    return edges() == Edges::doubtful && relative_noise() >= kLittleNoise;
}

/// Whether a smooth leaf rounds a real edge or corner off (notes/0011). In noise a smaller ball
/// would be thicker still, and leaves would fall apart into single points.
bool LeafMaker::rounds_off(const CoveringSurfel& leaf) const {
    if (std::sqrt(rules_.typical_variance) > kThinNoise * kFinestBall * spacing_) return false;
    const FittedSurfel& f = leaf.fitted;
    return edges() == Edges::real && f.n_points > kFewest &&
           f.fit_error > kRoundsOff * f.surfel.support_radius;
}

/// Gives a centre near an edge or a corner the radius and number of sheets that beat its smooth
/// choice. The exact fit must confirm them, here and not later, so that the smooth choice is still
/// at hand.
void LeafMaker::sharpen(LeafCandidate& c, const Vec3d& center, LeafWork& work) const {
    auto found = sharp_.choose(center, c.choice, work.ladder);
    if (!found) {
        const Vec3d normal = normalized(to_double(block_.normal[c.point]));
        const double before = c.choice.radius;
        c.choice.radius =
            static_cast<float>(sharp_.clear_radius(center, normal, c.choice, work.ladder));
        // A tip's own point: no larger ball holds more of a surface.
        if (c.choice.radius < 0.99 * kGoldenRatio * kGoldenRatio * before) c.choice.limited = false;
        return;
    }
    found->radius = static_cast<float>(found->radius);
    auto fitted = fit_sharp_surfel(pyramid_.all(), center, *found, rules_.usual_degree(),
                                   rules_.noise_variance, work.exact.ball, work.sharp);
    if (!fitted) return;
    c.surfel = std::move(*fitted);
    c.choice = {found->radius, rules_.usual_degree()};
    c.n_sheets = found->n_sheets;
}

/// The share of its radius with which a flat leaf beside an edge ends there (slim/fit/notes/0014);
/// 1 for others.
double LeafMaker::share_before_edges(const CoveringSurfel& leaf,
                                     const BallPoints<double>& ball) const {
    const FittedSurfel& f = leaf.fitted;
    const bool is_flat = f.surfel.degree < 2 && f.fit_error < kFlat * f.surfel.support_radius;
    return is_flat && has_own_normals(f, ball) && shows_edge(ball) ? share_at_edges(leaf) : 1;
}

}  // namespace slim
