#include "slim/tree/leaf_agreement.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace slim {
namespace {

constexpr double kSampleRadius = 0.5;  // of the leaf's
constexpr double kSameSide = 0.7;      // cosine between normals of one surface
constexpr double kBeside = 2;          // of the smaller radius
constexpr std::size_t kAgree = 4, kNearly = 2;  // samples

std::size_t n_inside(const LeafSamples& smaller, const Vec3d& center, double radius) {
    const auto inside = [&](const LeafSamples::Sample& s) {
        return sq_length(s.position - center) < radius * radius;
    };
    const auto samples = smaller.samples();
    return static_cast<std::size_t>(std::count_if(samples.begin(), samples.end(), inside));
}

/// Samples that lie on the larger leaf's surface, and whether any lies beside it.
struct Votes {
    std::size_t agree = 0;
    bool beside = false;
};

Votes votes_on(const LeafSamples& smaller, const Surfel& larger) {
    Votes votes;
    for (const auto& [position, normal] : smaller.samples()) {
        const Vec3d x = (position - larger.center) / larger.support_radius;
        if (!(sq_length(x) < 1)) continue;
        const Vec3d gradient = larger.sheet_gradient(larger.active_sheet(x), x);
        const double steepness = length(gradient);
        const double distance = std::abs(larger.value(x)) * larger.support_radius /
                                (steepness * smaller.support_radius());
        votes.agree += distance < kBelongs && dot(gradient, normal) > kSameSide * steepness;
        votes.beside |= distance < kBeside;
    }
    return votes;
}

}  // namespace

LeafSamples::LeafSamples(const Surfel& leaf) : support_radius_(leaf.support_radius) {
    for (std::size_t sheet = 0; sheet < leaf.n_sheets(); ++sheet) {
        for (std::size_t k = 0; k < kPerSheet; ++k) {
            const double r = k == 0 ? 0 : kSampleRadius;
            const double angle = static_cast<double>(k) * std::numbers::pi / 3;
            const double u = r * std::cos(angle), v = r * std::sin(angle);
            const Vec3d x = leaf.sheet_frame(sheet).world_from_local(
                {u, v, leaf.sheet_polynomial(sheet).value(u, v)});
            if (!(sq_length(x) < 1) || leaf.active_sheet(x) != sheet) continue;
            samples_[n_++] = {leaf.center + x * leaf.support_radius,
                              normalized(leaf.sheet_gradient(sheet, x))};
        }
    }
}

Meeting meeting_of(const LeafSamples& smaller, const SurfelTree& tree, std::size_t larger) {
    if (n_inside(smaller, tree.center(larger), tree.support_radius(larger)) == 0)
        return Meeting::apart;
    const Votes votes = votes_on(smaller, tree.surfel(larger));
    if (votes.agree >= kAgree) return Meeting::agree;
    if (votes.agree >= kNearly) return Meeting::nearly;
    return votes.beside ? Meeting::beside : Meeting::apart;
}

bool agrees(const LeafSamples& smaller, const SurfelTree& tree, std::size_t larger) {
    if (n_inside(smaller, tree.center(larger), tree.support_radius(larger)) < kAgree) return false;
    return votes_on(smaller, tree.surfel(larger)).agree >= kAgree;
}

}  // namespace slim
